//! Finds an order in which nodes can be cooked, and over which lists each node repeats.
//!
//! A node repeats over the lists of the `for_each` it stands in, over the files that match its own pattern, and over
//! every list that reaches an input which takes a single value.

use super::load::Loader;
use super::model::{Origin, OriginId};
use super::resolve::{RawSource, Wires};
use crate::document::Diagnostic;
use crate::files::Pattern;
use petgraph::Direction;
use petgraph::algo::{kosaraju_scc, toposort};
use petgraph::graph::{DiGraph, NodeIndex};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The order of the nodes, and the lists they repeat over.
pub(super) struct Scoped {
    /// Raw node indices, each after those it needs. Nodes that stand in a circle or have mistakes, and those behind them, are
    /// left out, since what they repeat over is not known.
    pub order: Vec<usize>,
    /// Per raw node: the lists it repeats over, outermost first. Nodes of origins are raw indices.
    pub scope: Vec<Vec<OriginId>>,
    /// The lists.
    pub origins: Vec<Origin>,
}

/// Orders and scopes all nodes of which that can be told; circles and missing lists are reported.
pub(super) fn order_and_scope(loader: &mut Loader, wires: &Wires) -> Scoped {
    let order = order(loader, wires);
    let lists = wires.each.iter().chain(&wires.node_each).flatten();
    let iterated = lists.filter(|list| !list.list).map(|list| list.node).collect();
    let scope = vec![Vec::new(); loader.nodes.len()];
    let mut work = Work { wires, iterated, origins: Vec::new(), scope };
    for node in &order {
        work.scope_of(loader, *node);
    }
    let mut known = vec![false; loader.nodes.len()];
    for node in &order {
        known[*node] = true;
    }
    work.check_lists(loader, &known);
    Scoped { order, scope: work.scope, origins: work.origins }
}

fn order(loader: &mut Loader, wires: &Wires) -> Vec<usize> {
    let mut graph = DiGraph::<usize, ()>::with_capacity(loader.nodes.len(), loader.nodes.len() * 2);
    for node in 0..loader.nodes.len() {
        graph.add_node(node);
    }
    for node in 0..loader.nodes.len() {
        let inputs = wires.inputs[node].iter().flat_map(|input| &input.sources);
        let lists = each_of(loader, wires, node);
        for source in inputs.chain(lists) {
            graph.add_edge(NodeIndex::new(source.node), NodeIndex::new(node), ());
        }
    }
    if let (Ok(order), true) = (toposort(&graph, None), loader.nodes.iter().all(|node| node.sound)) {
        return order.into_iter().map(|index| graph[index]).collect();
    }
    let mut doubtful: Vec<bool> = loader.nodes.iter().map(|node| !node.sound).collect();
    let mut order = Vec::new();
    // Components come with those that need them before them.
    for component in kosaraju_scc(&graph).into_iter().rev() {
        let first = component[0];
        if component.len() > 1 || graph.contains_edge(first, first) {
            report_cycle(loader, &graph, &component);
            for node in component {
                doubtful[node.index()] = true;
            }
            continue;
        }
        if graph.neighbors_directed(first, Direction::Incoming).any(|needed| doubtful[needed.index()]) {
            doubtful[first.index()] = true;
        }
        if !doubtful[first.index()] {
            order.push(graph[first]);
        }
    }
    order
}

/// The lists of every `for_each` that a node stands in, innermost last.
fn each_of<'a>(loader: &Loader, wires: &'a Wires, node: usize) -> Vec<&'a RawSource> {
    let mut lists: Vec<_> = wires.node_each[node].iter().collect();
    let mut instance = loader.nodes[node].instance;
    loop {
        lists.extend(&wires.each[instance]);
        match &loader.instances[instance].parent {
            Some((parent, _)) => instance = *parent,
            None => break,
        }
    }
    lists.reverse();
    lists
}

/// Walks a cycle inside a strongly connected component and prints it as a path.
fn report_cycle(loader: &mut Loader, graph: &DiGraph<usize, ()>, component: &[NodeIndex]) {
    let mut walk = vec![component.iter().copied().min().unwrap_or(component[0])];
    loop {
        let last = walk[walk.len() - 1];
        let next = graph.neighbors(last).filter(|next| component.contains(next)).min();
        let Some(next) = next else { return };
        if let Some(start) = walk.iter().position(|seen| *seen == next) {
            walk.drain(..start);
            walk.push(next);
            break;
        }
        walk.push(next);
    }
    let path: Vec<_> = walk.iter().map(|index| loader.path(graph[*index])).collect();
    let node = graph[walk[0]];
    let instance = loader.nodes[node].instance;
    let source = Arc::clone(&loader.instances[instance].graph.source);
    let span = loader.entry(node).name_span;
    let mistake = Diagnostic::at("cycle", &source, span, format!("the graph runs in a circle: {}", path.join(" → ")));
    loader.report(instance, mistake.help("cut one of these connections"));
}

struct Work<'a> {
    wires: &'a Wires,
    /// Nodes that some `for_each` names and that give no list by themselves.
    iterated: BTreeSet<usize>,
    origins: Vec<Origin>,
    scope: Vec<Vec<OriginId>>,
}

impl Work<'_> {
    fn origin(&mut self, node: usize, port: Option<&str>, scope: &[OriginId]) -> OriginId {
        let known = self.origins.iter().position(|origin| origin.node == node && origin.port.as_deref() == port);
        known.unwrap_or_else(|| {
            self.origins.push(Origin { node, port: port.map(str::to_owned), scope: scope.to_vec() });
            self.origins.len() - 1
        })
    }

    /// The lists through which a source's values vary, its own list output included.
    fn reach(&mut self, source: &RawSource) -> Vec<OriginId> {
        let mut path = self.scope[source.node].clone();
        if source.list {
            path.push(self.origin(source.node, Some(&source.port), &path.clone()));
        }
        path
    }

    fn scope_of(&mut self, loader: &mut Loader, node: usize) {
        let mut path = Vec::new();
        for list in each_of(loader, self.wires, node) {
            let reach = self.reach(list);
            if reach.is_empty() {
                let name = loader.nodes[node].template.name.clone();
                Self::no_list(loader, loader.nodes[node].instance, &name, list);
            }
            merge(&mut path, &reach);
        }
        for input in self.wires.inputs[node].iter().filter(|input| !input.port.list) {
            for source in &input.sources {
                let reach = self.reach(source);
                if path.iter().all(|origin| reach.contains(origin)) {
                    path = reach;
                }
            }
        }
        if loader.nodes[node].made.reads.as_ref().is_some_and(Pattern::is_wild) || self.is_iterated(node) {
            let own = self.origin(node, None, &path);
            path.push(own);
        }
        self.scope[node] = path;
    }

    /// Whether some `for_each` names this node, which reads a file: then one file is a list of one item.
    fn is_iterated(&self, node: usize) -> bool {
        self.iterated.contains(&node) && self.wires.inputs[node].is_empty()
    }

    /// Reports that what the node `name` of `instance` stands in, or is itself, repeats over no list.
    fn no_list(loader: &mut Loader, mut instance: usize, name: &str, list: &RawSource) {
        // The mistake stands at the `for_each`: the node's own, or that of a graph around it.
        let mut entry = loader.instances[instance].graph.nodes[name].clone();
        while entry.for_each.is_none() {
            let Some((parent, name)) = loader.instances[instance].parent.clone() else { return };
            entry = loader.instances[parent].graph.nodes[&name].clone();
            instance = parent;
        }
        let Some(for_each) = &entry.for_each else { return };
        let source = Arc::clone(&loader.instances[instance].graph.source);
        let message = format!("`for_each` needs a list, and `{}.{}` is a single value", list.label, list.port);
        let mistake = Diagnostic::at("not-a-list", &source, for_each.span, message);
        loader.report(instance, mistake.help("name a node that loads a pattern of files or gives a list"));
    }

    /// Holds the list of every nested graph against what is known of its giver, also where no node within is sound.
    fn check_lists(&mut self, loader: &mut Loader, known: &[bool]) {
        for (instance, list) in self.wires.each.iter().enumerate() {
            let Some(list) = list.as_ref().filter(|list| known[list.node]) else { continue };
            if let (true, Some((parent, name))) =
                (self.reach(list).is_empty(), loader.instances[instance].parent.clone())
            {
                Self::no_list(loader, parent, &name, list);
            }
        }
    }
}

/// Appends what `path` does not repeat over yet.
fn merge(path: &mut Vec<OriginId>, more: &[OriginId]) {
    for origin in more {
        if !path.contains(origin) {
            path.push(*origin);
        }
    }
}
