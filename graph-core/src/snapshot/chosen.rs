//! Which outputs of a graph a snapshot holds: what the graph itself gives as its `outputs`, and every value that a node takes
//! which writes a file.

use crate::plan::Plan;
use std::collections::BTreeMap;

/// An output that a snapshot holds, of a node of the plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chosen {
    /// Position of the node in the plan.
    pub node: usize,
    /// The output.
    pub port: String,
}

/// The chosen outputs, by their names: `solve/fine.curves`.
pub fn chosen(plan: &Plan) -> BTreeMap<String, Chosen> {
    let writing = plan.nodes.iter().filter(|node| node.card.writes.is_some());
    let taken = writing.flat_map(|node| &node.inputs).flat_map(|input| &input.sources);
    let sources = plan.outputs.values().flatten().chain(taken);
    let named = sources.map(|source| {
        let name = format!("{}.{}", plan.nodes[source.node].path, source.port);
        (name, Chosen { node: source.node, port: source.port.clone() })
    });
    named.collect()
}
