//! The parameters of one node with everything filled in, ready to be checked against the node's kind.

use super::{Override, Resolved, Scope, resolve};
use crate::document::build::{check_parameters, takes_text};
use crate::document::{Body, Diagnostic, Entry, EntryParam, Graph};
use std::collections::BTreeMap;

/// Where a parameter's value was written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Written<'a> {
    /// In the graph.
    Graph(&'a EntryParam),
    /// On the command line, as `name=value`.
    CommandLine(&'a str),
}

/// A parameter's value on its way into a node.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenParam<'a> {
    /// Where it was written.
    pub written: Written<'a>,
    /// The value.
    pub value: Resolved,
}

/// All parameters that a node is given.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeParameters<'a> {
    /// Values by parameter.
    pub parameters: BTreeMap<String, GivenParam<'a>>,
    /// Whether one mentions the item's name, so that it differs from item to item.
    pub mentions_item: bool,
}

/// The parameters of the node `entry` of `graph`, called `path` through all nesting: what the entry says, and above it
/// what the command line sets. `{take}` and `{item}` are filled in where `item` is given, and stay where it is not.
///
/// # Errors
/// What [`resolve`] finds, for all parameters, and with it what is wrong with those that it could resolve.
pub fn node_parameters<'a>(
    graph: &Graph,
    entry: &'a Entry,
    scope: &Scope,
    item: Option<&str>,
    overrides: &'a [Override],
    path: &str,
) -> Result<NodeParameters<'a>, Vec<Diagnostic>> {
    debug_assert!(scope.source.as_ref() == Some(&graph.source), "the scope is that of the graph");
    let (mut parameters, mut mistakes, mut sound) = (BTreeMap::new(), Vec::new(), true);
    let mut put = |name: &str, written, value: Result<Resolved, Vec<Diagnostic>>| match value {
        Ok(value) => drop(parameters.insert(name.to_owned(), GivenParam { written, value })),
        Err(more) => {
            sound = false;
            mistakes.extend(more);
        }
    };
    let set: BTreeMap<&str, &Override> =
        overrides.iter().filter(|set| set.path.join("/") == path).map(|set| (set.name.as_str(), set)).collect();
    for (name, param) in entry.with.iter().filter(|(name, _)| !set.contains_key(name.as_str())) {
        put(name, Written::Graph(param), resolve(&param.value, scope));
    }
    for (name, set) in set {
        let wants_text =
            matches!(&entry.body, Body::Kind(kind) if takes_text(scope.kinds(), &kind.value, name, &set.value));
        put(name, Written::CommandLine(&set.text), set.resolved(wants_text, &scope.environment));
    }
    if !sound {
        if let Body::Kind(kind) = &entry.body {
            mistakes.extend(check_parameters(scope.kinds(), kind, &parameters, &graph.source));
        }
        return Err(mistakes);
    }
    let mentions_item = parameters.values().any(|given: &GivenParam| given.value.mentions_item());
    if let (true, Some(item)) = (mentions_item, item) {
        for given in parameters.values_mut() {
            given.value = given.value.for_item(item);
        }
    }
    Ok(NodeParameters { parameters, mentions_item })
}
