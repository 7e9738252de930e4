//! `grimace run`: cooks a graph, and shows how it goes.

use crate::arguments::{Global, Run};
use crate::cooking::Work;
use crate::exit::{Exit, Trouble};
use crate::graph::Asked;
use crate::logs::Level;
use crate::tell::{JsonLines, People, Wanted};
use crate::{cooking, output, signals};
use graph_core::cook::{Event, Summary};
use serde_json::json;

/// Cooks the graph.
pub fn run(arguments: &Run, global: &Global) -> Result<Exit, Trouble> {
    let asked = Asked::read(&arguments.graph)?;
    let options = cooking::options(&arguments.cook, false);
    let work = cooking::find(&asked, &arguments.store, &options, arguments.json)?;
    let profile = cooking::begin_logs(global, arguments.profile.as_deref())?;
    let cancel = signals::cancelled_by_signals()?;
    let cook = |work: Work, tell: &(dyn Fn(Event) + Sync)| {
        let told = |event| {
            if let Some(profile) = &profile {
                profile.take(&event);
            }
            tell(event);
        };
        cooking::run((&asked, work), &arguments.store, &options, &cancel, &told)
    };
    let summary = if arguments.json {
        let lines = JsonLines::new(&cancel);
        let summary = cook(work, &|event| lines.tell(&event));
        lines.finish().and_then(|()| told_in_json(summary))
    } else {
        let logged = global.log.is_some_and(|level| level != Level::Off) && global.log_file.is_none();
        let wanted = Wanted { quiet: global.quiet, verbose: global.verbose, plain: logged };
        People::new(wanted).during(|people| cook(work, &|event| people.tell(event)))
    };
    // A cook that failed is what one wants to look at.
    profile.map_or(Ok(()), |profile| profile.write()).and(summary).map(|summary| cooking::exit(&summary))
}

/// The same; a cook that could not run, or not to its end, is told as JSON too, and ends with the summary that readers wait for.
fn told_in_json(summary: Result<Summary, Trouble>) -> Result<Summary, Trouble> {
    if let Err(trouble @ (Trouble::Store(_) | Trouble::Cook(_))) = &summary {
        output::print_json(&json!({ "event": "diagnostic", "code": "cook", "message": trouble.to_string() }))?;
        output::print_json(&Event::Summary(Summary::default()))?;
    }
    summary
}
