//! References outside of parameters: `${name}` in a node's kind, in what it is wired and repeated to, and in the outputs
//! of a graph. (The file of a nested graph is a path, and filled in where it is opened.)

use super::{Scope, resolve_name};
use crate::document::{Body, Diagnostic, Graph, Spanned};
use std::sync::Arc;

impl Scope {
    /// `graph` with these texts filled in, and every mistake in them; the graph itself where nothing refers to anything.
    pub fn wire(&self, graph: &Arc<Graph>) -> (Arc<Graph>, Vec<Diagnostic>) {
        let mut filled = Graph::clone(graph);
        let (mut mistakes, mut changed) = (Vec::new(), false);
        for text in texts(&mut filled).filter(|text| text.value.contains("${")) {
            changed = true;
            match resolve_name(text, self) {
                Ok((value, _)) => text.value = value,
                Err(more) => mistakes.extend(more),
            }
        }
        (if changed { Arc::new(filled) } else { Arc::clone(graph) }, mistakes)
    }
}

fn texts(graph: &mut Graph) -> impl Iterator<Item = &mut Spanned<String>> {
    let nodes = graph.nodes.values_mut().flat_map(|entry| {
        let kind = match &mut entry.body {
            Body::Kind(kind) => Some(kind),
            Body::Graph(_) => None,
        };
        let wired = entry.inputs.values_mut().flat_map(|input| &mut input.sources);
        kind.into_iter().chain(&mut entry.for_each).chain(wired)
    });
    nodes.chain(graph.outputs.values_mut())
}
