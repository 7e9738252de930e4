//! `grimace check`: every mistake in a graph, in one pass.

use crate::arguments::Check;
use crate::exit::{Exit, Trouble};
use crate::graph::Asked;
use crate::words::count;
use crate::{mistakes, output};
use serde_json::json;

/// Checks a graph and the graphs nested in it.
pub fn check(arguments: &Check) -> Result<Exit, Trouble> {
    let asked = Asked::read(&arguments.graph)?;
    let graph = asked.path.display().to_string();
    match asked.load() {
        Ok(plan) => {
            let (nodes, nested) = (plan.nodes.len(), plan.sources.len() - 1);
            if arguments.json {
                output::print_json(&json!({
                    "event": "checked", "graph": graph, "mistakes": 0, "nodes": nodes, "nested_graphs": nested,
                }))?;
            } else {
                let within = if nested == 0 { String::new() } else { format!(", {}", count(nested, "nested graph")) };
                output::print(&format!("{graph}: no mistakes ({}{within})\n", count(nodes, "node")))?;
            }
            Ok(Exit::Fine)
        }
        Err(found) if arguments.json => {
            mistakes::print_json(&found)?;
            output::print_json(&json!({ "event": "checked", "graph": graph, "mistakes": found.0.len() }))?;
            Ok(mistakes::exit(&found))
        }
        Err(found) => Err(mistakes::tell(found)),
    }
}
