//! `grimace run`: cooks a graph, and shows how it goes.

use crate::arguments::{Global, Run};
use crate::exit::{Exit, Trouble};
use crate::graph::Asked;
use crate::tell::{JsonLines, People, Wanted};
use crate::{cooking, signals};
use graph_core::plan::Plan;

/// Cooks the graph.
pub fn run(arguments: &Run, global: &Global) -> Result<Exit, Trouble> {
    let asked = Asked::read(&arguments.graph)?;
    let plan = cooking::load(&asked, arguments.json)?;
    let options = cooking::options(&arguments.cook, false);
    let cancel = signals::cancelled_by_signals()?;
    let cook = |plan: Plan, tell: &(dyn Fn(graph_core::cook::Event) + Sync)| {
        cooking::run((&asked, plan), &arguments.store, &options, &cancel, tell)
    };
    let summary = if arguments.json {
        let lines = JsonLines::new(&cancel);
        let summary = cook(plan, &|event| lines.tell(&event));
        lines.finish()?;
        summary?
    } else {
        let wanted = Wanted { quiet: global.quiet, verbose: global.verbose };
        People::new(wanted).during(|people| cook(plan, &|event| people.tell(event)))?
    };
    Ok(cooking::exit(&summary))
}
