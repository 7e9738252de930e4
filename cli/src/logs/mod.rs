//! Logs and profiles. What is logged is what the engine tells: its events are written down by `tracing`, and nothing else is.
//! A profile shows the same cook over time, thread by thread.

mod chrome;
mod event;

pub use chrome::Profile;
pub use event::log;

use crate::arguments::Global;
use crate::exit::Trouble;
use clap::ValueEnum;
use std::fs::File;
use std::path::Path;
use std::sync::Mutex;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::registry::Registry;

/// How much is logged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Level {
    /// Nothing
    #[default]
    Off,
    /// What failed
    Error,
    /// What is worth knowing, too
    Warn,
    /// What was cooked and written, too
    Info,
    /// What was up to date, too
    Debug,
    /// Progress, too
    Trace,
}

impl Level {
    fn filter(self) -> LevelFilter {
        match self {
            Self::Off => LevelFilter::OFF,
            Self::Error => LevelFilter::ERROR,
            Self::Warn => LevelFilter::WARN,
            Self::Info => LevelFilter::INFO,
            Self::Debug => LevelFilter::DEBUG,
            Self::Trace => LevelFilter::TRACE,
        }
    }
}

type Boxed = Box<dyn Layer<Registry> + Send + Sync>;

/// Begins to log, and to profile where a profile is wanted. Where neither is, nothing is set up, and what would be logged
/// costs one comparison.
///
/// # Errors
/// Where the log's file cannot be made.
pub fn begin(global: &Global, profile: Option<&Profile>) -> Result<(), Trouble> {
    let mut layers: Vec<Boxed> = Vec::new();
    let level = global.log.unwrap_or_default();
    if level != Level::Off {
        layers.push(if let Some(path) = &global.log_file {
            to_file(path, level)?
        } else {
            let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_target(false);
            lines.with_ansi(crate::colours::on_stderr()).with_filter(level.filter()).boxed()
        });
    }
    if let Some(profile) = profile {
        layers.push(profile.layer().with_filter(LevelFilter::DEBUG).boxed());
    }
    if !layers.is_empty() {
        // The program begins one log in its life; a second one would be a mistake without consequence.
        let _ = tracing::subscriber::set_global_default(Registry::default().with(layers));
    }
    Ok(())
}

/// Lines in a file, which is made anew only where it is not there.
fn to_file(path: &Path, level: Level) -> Result<Boxed, Trouble> {
    let opened = File::options().create(true).append(true).open(path);
    let file = opened.map_err(|problem| {
        let message = format!("the log {} cannot be written: {problem}", path.display());
        Trouble::command_line(message, Some("name another file with --log-file".to_owned()))
    })?;
    let layer = tracing_subscriber::fmt::layer().with_writer(Mutex::new(file)).with_ansi(false).with_target(false);
    let is_json = path.extension().is_some_and(|ending| ending == "json" || ending == "jsonl");
    Ok(if is_json {
        layer.json().flatten_event(true).with_filter(level.filter()).boxed()
    } else {
        layer.with_filter(level.filter()).boxed()
    })
}
