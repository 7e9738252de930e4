//! `grimace why`: what made a node cook, followed upstream to the edit that began it.

use crate::arguments::Why;
use crate::exit::{Exit, Trouble};
use crate::words::count;
use crate::{graph, output};
use graph_core::cook::{Session, story};
use graph_core::document::did_you_mean;
use graph_core::plan::{self, Plan};
use graph_core::store::Store;
use std::fmt::Write;

/// Items that are listed before the rest is only counted.
const LISTED: usize = 40;

/// Prints the story of a node.
pub fn why(arguments: &Why) -> Result<Exit, Trouble> {
    let path = graph::file(&arguments.graph);
    let node = arguments.node.as_str();
    // The graph may be broken now; what was cooked before can be told all the same.
    let plan = plan::load(&path, &[]);
    if !path.is_file() {
        return Err(plan.map_or_else(crate::mistakes::tell, |_| {
            Trouble::command_line(format!("there is no graph {}", path.display()), None)
        }));
    }
    let place = graph::store_place(&arguments.store, &path);
    let session = Session::load(&Store::at(&place), &path);
    let plan = plan.ok();
    let answer = answer(&session, plan.as_ref(), node)?;
    let never = session.cells.is_empty();
    output::print(&format!("{}\n", answer.trim_end()))?;
    if never {
        output::say(&format!("no cook of {} is remembered in {}", path.display(), place.display()));
    }
    Ok(Exit::Fine)
}

fn answer(session: &Session, plan: Option<&Plan>, node: &str) -> Result<String, Trouble> {
    if let Some(story) = story(session, node) {
        return Ok(story);
    }
    let (path, item) = node.split_once('@').map_or((node, None), |(path, item)| (path, Some(item)));
    let inside = |cell: &str, path: &str| {
        cell.strip_prefix(path).is_some_and(|rest| rest.starts_with('@') || rest.starts_with('/'))
    };
    let cells: Vec<&str> = session.cells.keys().map(String::as_str).filter(|cell| inside(cell, path)).collect();
    if item.is_none() && !cells.is_empty() {
        return Ok(listed(session, node, &cells));
    }
    let planned = plan.is_some_and(|plan| !plan.find(path).is_empty());
    match item {
        Some(item) if !cells.is_empty() => {
            let items = cells.iter().filter_map(|cell| cell.split_once('@')).map(|(_, item)| item);
            let near = did_you_mean(item, items);
            let help = near.map_or_else(
                || format!("`grimace why GRAPH {path}` lists what was cooked"),
                |near| format!("did you mean `{path}@{near}`?"),
            );
            Err(Trouble::command_line(format!("`{path}` was not cooked for an item `{item}`"), Some(help)))
        }
        _ if planned => Ok(format!(
            "{node} has not been cooked yet: no cook has come as far, or it failed\n\
             `grimace plan` says what the next cook would do with it"
        )),
        _ => {
            let known = session.cells.keys().map(|cell| cell.split_once('@').map_or(cell.as_str(), |(path, _)| path));
            let planned = plan.iter().flat_map(|plan| &plan.nodes).map(|node| node.path.as_str());
            let near = did_you_mean(path, known.chain(planned));
            let help = near.map(|near| format!("did you mean `{near}`?"));
            Err(Trouble::command_line(format!("there is no node `{path}`"), help))
        }
    }
}

/// The cells of a node that is cooked once an item, or of a nested graph.
fn listed(session: &Session, node: &str, cells: &[&str]) -> String {
    let mut out = format!("{node} was cooked as {}; name one:\n", count(cells.len(), "cell"));
    let widest = cells.iter().take(LISTED).map(|cell| console::measure_text_width(cell)).max().unwrap_or(0);
    for cell in cells.iter().take(LISTED) {
        let cooked = session.cells.get(*cell).and_then(|record| record.cooked.as_ref());
        let said = match cooked {
            Some((run, cause)) if *run == session.run => format!("cooked in the last run: {}", cause.text),
            Some((run, _)) => format!("last cooked in run {run} of {}", session.run),
            None => "found in the store".to_owned(),
        };
        let _ = writeln!(out, "  {cell:<widest$}  {said}");
    }
    if cells.len() > LISTED {
        let _ = writeln!(out, "  … and {} more", cells.len() - LISTED);
    }
    out
}
