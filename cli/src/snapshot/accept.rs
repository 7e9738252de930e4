//! `grimace snapshot accept`: keeps what the graph gives now.

use super::cooked::Work;
use crate::arguments::{Global, SnapshotOf};
use crate::exit::{Exit, Trouble};
use crate::output;
use crate::words::count;
use graph_core::snapshot::{Golden, GoldenError, Taken};
use serde_json::json;

/// Cooks the graph, and writes its snapshot. Tolerances that were set by hand stay, and so does what was set, unless the command line
/// sets something.
pub fn accept(of: &SnapshotOf, global: &Global) -> Result<Exit, Trouble> {
    let before = match Golden::read(&Work::folder_of(of)) {
        Ok(before) => Some(before),
        Err(GoldenError::None(_)) => None,
        Err(problem) => return Err(problem.into()),
    };
    let known = before.as_ref().filter(|_| of.graph.set.is_empty()).map_or(&[][..], |before| &before.set);
    let work = Work::new(of, global, known)?;
    let (taken, again) = match work.cook(|engine| Ok(Taken::after(engine)?))? {
        Ok(done) => done,
        Err(exit) => return Ok(exit),
    };
    let golden = Golden::new(&taken, work.set.clone(), again.hits, before.as_ref());
    let changed = golden.write(&work.folder, &taken)?;
    let values: usize = taken.outputs.values().map(|output| output.items.len()).sum();
    if of.json {
        let files: Vec<_> = changed.iter().map(|path| path.display().to_string()).collect();
        output::print_json(&json!({
            "event": "accepted", "outputs": taken.outputs.len(), "values": values, "changed": files,
            "second_cook": again.hits,
        }))?;
    } else {
        let told = format!(
            "{}: {} with {}; {} changed\n",
            work.folder.display(),
            count(taken.outputs.len(), "output"),
            count(values, "value"),
            count(changed.len(), "file")
        );
        output::print(&told)?;
    }
    if !again.cooked.is_empty() {
        let nodes = again.cooked.join(", ");
        output::say(&format!(
            "a second cook computed again what it should have found: {nodes}; a check will expect the same"
        ));
    }
    Ok(Exit::Fine)
}
