//! Events as lines of a log.

use graph_core::cook::Event;
use tracing::level_filters::LevelFilter;
use tracing::{debug, error, info, trace, warn};

/// Writes an event down.
pub fn log(event: &Event) {
    if LevelFilter::current() == LevelFilter::OFF {
        return;
    }
    match event {
        Event::Planned { cells } => debug!(cells, "planned"),
        Event::Started { node, kind, because, blocks } => info!(node, kind, because, blocks, "started"),
        Event::Progress { node, fraction, numbers } => trace!(node, fraction, ?numbers, "progress"),
        Event::Cooked { node, kind, seconds, blocks_cooked, blocks_cached, .. } => {
            info!(node, kind, seconds, blocks_cooked, blocks_cached, "cooked");
        }
        Event::Remade { node, blocks } => info!(node, blocks, "remade"),
        Event::Cached { node, kind, blocks } => debug!(node, kind, blocks, "cached"),
        Event::WouldCook { node, kind, because, sure } => info!(node, kind, because, sure, "would_cook"),
        Event::Failed { node, kind, error, place, .. } => error!(node, kind, error, place, "failed"),
        Event::Skipped { node, because } => warn!(node, because, "skipped"),
        Event::Wrote { node, path, bytes } => info!(node, path, bytes, "wrote"),
        Event::Notice { about, message } => warn!(about, notice = message, "notice"),
        Event::Summary(summary) => info!(
            cooked = summary.cooked,
            cached = summary.cached,
            failed = summary.failed,
            skipped = summary.skipped,
            written = summary.written,
            cancelled = summary.cancelled,
            seconds = summary.seconds,
            "summary"
        ),
    }
}
