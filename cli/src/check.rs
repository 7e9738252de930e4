//! `grimace check`: every mistake in a graph, in one pass.

use crate::arguments::Check;
use crate::exit::{Exit, Trouble};
use crate::graph::Asked;
use crate::words::count;
use crate::{mistakes, output};
use serde::Serialize;

/// The last line of JSON.
#[derive(Serialize)]
struct Checked {
    event: &'static str,
    graph: String,
    mistakes: usize,
    #[serde(flatten)]
    sizes: Option<Sizes>,
}

/// How large a graph without mistakes is.
#[derive(Serialize)]
struct Sizes {
    nodes: usize,
    nested_graphs: usize,
}

/// Checks a graph and the graphs nested in it.
pub fn check(arguments: &Check) -> Result<Exit, Trouble> {
    let asked = Asked::read(&arguments.graph)?;
    let graph = asked.path.display().to_string();
    match asked.load() {
        Ok(plan) => {
            let (nodes, nested_graphs) = (plan.nodes.len(), plan.sources.len() - 1);
            if arguments.json {
                let sizes = Some(Sizes { nodes, nested_graphs });
                output::print_json(&Checked { event: "checked", graph, mistakes: 0, sizes })?;
            } else {
                let within = match nested_graphs {
                    0 => String::new(),
                    nested => format!(", {}", count(nested, "nested graph")),
                };
                output::print(&format!("{graph}: no mistakes ({}{within})\n", count(nodes, "node")))?;
            }
            Ok(Exit::Fine)
        }
        Err(found) if arguments.json => {
            mistakes::print_json(&found)?;
            output::print_json(&Checked { event: "checked", graph, mistakes: found.0.len(), sizes: None })?;
            Ok(mistakes::exit(&found))
        }
        Err(found) => Err(mistakes::tell(found)),
    }
}
