//! The plan as data.

use crate::document::{Diagnostic, Entry, Environment, Graph, Place, Scope, Source, ValuePlace};
use crate::files::Pattern;
use crate::node::{Card, Kinds, Node, PortFacts};
use petgraph::graph::DiGraph;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// All nodes of a graph and of the graphs nested in it, flat and wired.
#[derive(Debug)]
pub struct Plan {
    /// Every graph file, the root first.
    pub sources: Vec<Arc<Source>>,
    /// The environment that their texts refer to.
    pub environment: Arc<Environment>,
    /// The nodes, each after those it needs.
    pub nodes: Vec<PlanNode>,
    /// The lists that nodes repeat over.
    pub origins: Vec<Origin>,
    /// What the graph itself gives: where each of its outputs comes from.
    pub outputs: BTreeMap<String, Vec<PlanSource>>,
    /// Who needs whom: weights are indices into `nodes`, edges go from producer to consumer.
    pub wires: DiGraph<usize, ()>,
}

/// Index of an [`Origin`].
pub type OriginId = usize;

/// Where a list of items comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// The node whose files or list output are the items.
    pub node: usize,
    /// The list output; `None` where the items are the files that match the node's pattern.
    pub port: Option<String>,
    /// The lists over which the node itself already repeats.
    pub scope: Vec<OriginId>,
}

/// One node of a plan. It stands for one cell, or for one cell an item of each list it repeats over.
#[derive(Debug, Clone)]
pub struct PlanNode {
    /// Name through all nesting, for example `solve/raw`.
    pub path: String,
    /// Where the graph places it.
    pub place: Place,
    /// Its kind.
    pub kind: String,
    /// The node, with parameters as they are outside of any item.
    pub node: Arc<dyn Node>,
    /// Its card.
    pub card: Arc<Card>,
    /// The lists over which it repeats, outermost first.
    pub scope: Vec<OriginId>,
    /// Its inputs.
    pub inputs: Vec<PlanInput>,
    /// The file or pattern that it reads.
    pub reads: Option<Pattern>,
    /// The file that it writes.
    pub writes: Option<PathBuf>,
    /// What it was made from, to make it anew for an item whose name its parameters mention.
    pub template: Template,
}

/// What a node of a plan was made from.
#[derive(Debug, Clone)]
pub struct Template {
    /// The graph file.
    pub graph: Arc<Graph>,
    /// Name of the node in that file.
    pub name: String,
    /// What `${…}` stands for there.
    pub scope: Arc<Scope>,
    /// Whether a parameter mentions the item's name.
    pub mentions_item: bool,
}

impl Template {
    /// The node's entry in its file.
    pub fn entry(&self) -> &Entry {
        &self.graph.nodes[&self.name]
    }

    /// Where the value of a parameter comes from; `None` where the graph does not give it.
    pub fn parameter_place(&self, parameter: &str) -> Option<ValuePlace> {
        let given = self.entry().with.get(parameter)?;
        Some(self.scope.place_of(&given.value, &self.graph.source))
    }
}

/// One input of a node.
#[derive(Debug, Clone)]
pub struct PlanInput {
    /// The port.
    pub port: PortFacts,
    /// Where the connection is written.
    pub place: Place,
    /// Where values come from: one source, or several that a list port gathers. Empty where an optional port is open.
    pub sources: Vec<PlanSource>,
}

/// An output that an input is connected to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanSource {
    /// The node.
    pub node: usize,
    /// The output.
    pub port: String,
    /// Whether that output is itself a list.
    pub list: bool,
    /// What the graph calls it, to name items by where several sources are gathered.
    pub label: String,
}

impl Plan {
    /// The root graph file.
    pub fn root(&self) -> &Source {
        &self.sources[0]
    }

    /// The kinds that its graphs may name.
    pub fn kinds(&self) -> &Kinds {
        self.environment.kinds()
    }

    /// Indices of the nodes that are called `name`, or stand in a nested graph called so.
    pub fn find(&self, name: &str) -> Vec<usize> {
        let inside = |path: &str| path.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
        (0..self.nodes.len()).filter(|index| inside(&self.nodes[*index].path)).collect()
    }

    /// Marks the nodes `wanted` and everything that they need.
    pub fn with_ancestors(&self, wanted: &[usize]) -> Vec<bool> {
        let mut marked = vec![false; self.nodes.len()];
        let mut open = wanted.to_vec();
        while let Some(index) = open.pop() {
            if !std::mem::replace(&mut marked[index], true) {
                let node = &self.nodes[index];
                open.extend(node.inputs.iter().flat_map(|input| &input.sources).map(|source| source.node));
                open.extend(node.scope.iter().map(|origin| self.origins[*origin].node));
            }
        }
        marked
    }

    /// A diagnostic that `name` is no node, with the nearest that is.
    pub fn unknown_node(&self, name: &str) -> Diagnostic {
        let near = crate::document::did_you_mean(name, self.nodes.iter().map(|node| node.path.as_str()));
        Diagnostic::new("unknown-node", format!("there is no node `{name}` in {}", self.root().path.display()))
            .may_help(near.map(|near| format!("did you mean `{near}`?")))
    }
}
