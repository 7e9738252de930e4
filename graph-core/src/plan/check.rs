//! Makes nodes from their entries, and the plan from wired and scoped nodes, checking types and files.

use super::load::Loader;
use super::model::{Origin, Plan, PlanInput, PlanNode, PlanSource};
use super::resolve::{RawSource, Wires};
use super::scope::Scoped;
use crate::document::{
    Diagnostic, GivenParam, Graph, Override, Place, Resolved, Scope, Spanned, build_node, did_you_mean, node_parameters,
};
use crate::files::Pattern;
use crate::node::{Card, Kinds, Node, PortFacts, type_text};
use petgraph::graph::{DiGraph, NodeIndex};
use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

/// A node made from its entry.
pub(crate) struct Made {
    pub node: Arc<dyn Node>,
    pub card: Arc<Card>,
    pub reads: Option<Pattern>,
    pub writes: Option<PathBuf>,
    pub mentions_item: bool,
}

/// Makes the node `name` of `graph` for the item called `item`, or as it is outside of any item.
pub(crate) fn make(
    graph: &Graph,
    name: &str,
    kind: &Spanned<String>,
    scope: &Scope,
    item: Option<&str>,
    overrides: &[Override],
    path: &str,
) -> (Option<Made>, Vec<Diagnostic>) {
    let entry = &graph.nodes[name];
    let given = match node_parameters(graph, entry, scope, item, overrides, path) {
        Ok(given) => given,
        Err(mistakes) => return (None, mistakes),
    };
    let node: Arc<dyn Node> = match build_node(scope.kinds(), kind, &given.parameters, &graph.source) {
        Ok(node) => node.into(),
        Err(mistakes) => return (None, mistakes),
    };
    let card = node.card();
    let mut mistakes = Vec::new();
    let mut file = |parameter: Option<&'static str>| {
        let parameter = parameter?;
        let path = given.parameters.get(parameter).and_then(path_of);
        if path.is_none() {
            let message = format!("`{name}` needs its parameter `{parameter}`: the path of a file");
            let mistake = Diagnostic::at("missing-parameter", &graph.source, entry.name_span, message);
            mistakes.push(mistake.help(format!("add it: with: ({parameter}: \"…\")")));
        }
        path
    };
    let reads = file(card.reads).map(Pattern::new);
    let writes = file(card.writes);
    if !mistakes.is_empty() {
        return (None, mistakes);
    }
    let made = Made { node, card: Arc::new(card), reads, writes, mentions_item: given.mentions_item };
    (Some(made), Vec::new())
}

/// A node of a kind with its defaults, in place of one whose parameters have mistakes.
pub(super) fn stand_in(kinds: &Kinds, kind: &str) -> Option<Made> {
    let node: Arc<dyn Node> = kinds.get(kind)?.default_node().into();
    let card = Arc::new(node.card());
    Some(Made { node, card, reads: None, writes: None, mentions_item: false })
}

fn path_of(given: &GivenParam<'_>) -> Option<PathBuf> {
    match &given.value {
        Resolved::Text { text, .. } if !text.is_empty() => given.value.path(),
        _ => None,
    }
}

/// Checks the types of all connections.
pub(super) fn types(loader: &mut Loader, wires: &Wires) {
    for node in 0..loader.nodes.len() {
        check_types(loader, wires, node);
    }
}

/// The first card of `kind`, where this one is equal to it.
fn shared(cards: &mut HashMap<String, Arc<Card>>, kind: &str, card: &Arc<Card>) -> Arc<Card> {
    match cards.get(kind) {
        Some(first) if first == card => Arc::clone(first),
        Some(_) => Arc::clone(card),
        None => Arc::clone(cards.entry(kind.to_owned()).or_insert_with(|| Arc::clone(card))),
    }
}

/// The plan, in the order of `scoped`; mistakes are reported and give `None`.
pub(super) fn assemble(loader: &mut Loader, wires: &Wires, scoped: Scoped) -> Option<Plan> {
    for node in &scoped.order {
        check_files(loader, *node, &scoped.scope[*node]);
    }
    if !loader.diagnostics.is_empty() {
        return None;
    }
    let mut position = vec![0; scoped.order.len()];
    for (place, node) in scoped.order.iter().enumerate() {
        position[*node] = place;
    }
    // Nodes of a kind mostly have equal cards, and share one.
    let mut cards: HashMap<String, Arc<Card>> = HashMap::new();
    let mut nodes = Vec::with_capacity(scoped.order.len());
    let mut graph = DiGraph::with_capacity(scoped.order.len(), scoped.order.len() * 2);
    for raw in &scoped.order {
        let place = position[*raw];
        graph.add_node(place);
        let inputs: Vec<_> = wires.inputs[*raw]
            .iter()
            .map(|input| PlanInput {
                port: input.port,
                place: input.place.clone(),
                sources: input.sources.iter().map(|source| moved(source, &position)).collect(),
            })
            .collect();
        for source in inputs.iter().flat_map(|input| &input.sources) {
            graph.update_edge(NodeIndex::new(source.node), NodeIndex::new(place), ());
        }
        let node = &loader.nodes[*raw];
        let source = Arc::clone(&node.template.graph.source);
        nodes.push(PlanNode {
            path: loader.path(*raw),
            place: Place { source, span: loader.entry(*raw).name_span },
            kind: node.kind.value.clone(),
            node: Arc::clone(&node.made.node),
            card: shared(&mut cards, &node.kind.value, &node.made.card),
            scope: scoped.scope[*raw].clone(),
            inputs,
            reads: node.made.reads.clone(),
            writes: node.made.writes.clone(),
            template: node.template.clone(),
        });
    }
    let origins = scoped.origins.into_iter().map(|origin| Origin { node: position[origin.node], ..origin }).collect();
    let given = wires.outputs.iter();
    let outputs = given
        .map(|(name, sources)| (name.clone(), sources.iter().map(|source| moved(source, &position)).collect()))
        .collect();
    Some(Plan { sources: Vec::new(), environment: Arc::default(), nodes, origins, outputs, wires: graph })
}

fn moved(source: &RawSource, position: &[usize]) -> PlanSource {
    PlanSource {
        node: position[source.node],
        port: source.port.clone(),
        list: source.list,
        label: source.label.clone(),
    }
}

fn check_types(loader: &mut Loader, wires: &Wires, node: usize) {
    let mut mistakes = Vec::new();
    for input in &wires.inputs[node] {
        for source in &input.sources {
            let card = &loader.nodes[source.node].made.card;
            let Some(given) = card.output(&source.port) else { continue };
            if given.kind.name != input.port.kind.name {
                let message = format!(
                    "input `{}` takes {}, and `{}.{}` is {}",
                    input.port.name,
                    input.port.type_text(),
                    source.label,
                    source.port,
                    type_text(given.kind.name, given.list),
                );
                let place = &input.place;
                let mistake = Diagnostic::at("type-mismatch", &place.source, place.span, message);
                mistakes.push(mistake.label(given.meaning).may_help(conversion(
                    loader.kinds(),
                    card,
                    given,
                    input.port.kind.name,
                )));
            }
        }
    }
    let instance = loader.nodes[node].instance;
    for mistake in mistakes {
        loader.report(instance, mistake);
    }
}

/// What would make the connection right: another output of the same node, or a node that converts.
pub(super) fn conversion(kinds: &Kinds, card: &Card, given: &PortFacts, wanted: &str) -> Option<String> {
    if let Some(other) = card.outputs.iter().find(|other| other.kind.name == wanted) {
        return Some(format!("the same node gives {wanted} on its output `{}`", other.name));
    }
    let converters: Vec<_> = kinds
        .all()
        .into_iter()
        .filter(|(_, kind)| {
            let card = kind.card();
            let takes = card.inputs.iter().any(|port| !port.optional && port.kind.name == given.kind.name);
            // What needs such a value already makes none from the other.
            let needs = card.inputs.iter().any(|port| !port.optional && port.kind.name == wanted);
            takes && !needs && card.outputs.iter().any(|port| port.kind.name == wanted)
        })
        .map(|(name, kind)| (kind.card().inputs.iter().filter(|port| !port.optional).count(), name))
        .collect();
    let fewest = converters.iter().map(|(inputs, _)| *inputs).min()?;
    let names: Vec<_> =
        converters.iter().filter(|(inputs, _)| *inputs == fewest).map(|(_, name)| format!("`{name}`")).collect();
    let from = given.kind.name;
    Some(format!("a node of kind {} between them makes {wanted} from {from}", names.join(" or ")))
}

fn check_files(loader: &mut Loader, node: usize, scope: &[usize]) {
    let raw = &loader.nodes[node];
    let source = Arc::clone(&raw.template.graph.source);
    let span_of = |parameter: Option<&str>| {
        let entry = raw.template.entry();
        parameter.and_then(|name| entry.with.get(name)).map_or(entry.name_span, |param| param.value.span)
    };
    let mut mistakes = Vec::new();
    if let Some(pattern) = raw.made.reads.as_ref().filter(|_| !raw.made.mentions_item) {
        mistakes.extend(check_readable(pattern).map(|(message, help)| {
            Diagnostic::at("unreadable-file", &source, span_of(raw.made.card.reads), message).may_help(help)
        }));
    }
    if raw.made.writes.is_some() && !scope.is_empty() && !raw.made.mentions_item {
        let message = "this node is cooked once an item, and every item would be written to the same file";
        let mistake = Diagnostic::at("same-file", &source, span_of(raw.made.card.writes), message);
        mistakes.push(mistake.help("put {take} into the path: it stands for the item's name"));
    }
    let instance = raw.instance;
    for mistake in mistakes {
        loader.report(instance, mistake);
    }
}

/// What keeps a file from being read, and the cure.
fn check_readable(pattern: &Pattern) -> Option<(String, Option<String>)> {
    if pattern.is_wild() {
        return pattern.files().err().map(|problem| (problem.to_string(), None));
    }
    let path = pattern.path();
    match std::fs::File::open(path).and_then(|file| file.metadata()) {
        Ok(meta) if meta.is_dir() => {
            let cure = format!("write a pattern of files in it, such as `{}/*.c3d`", path.display());
            Some((format!("{} is a folder, where a file is needed", path.display()), Some(cure)))
        }
        Ok(_) => None,
        Err(problem) => {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            let beside = std::fs::read_dir(folder.unwrap_or(std::path::Path::new(".")));
            let names: BTreeSet<String> = beside
                .into_iter()
                .flatten()
                .flatten()
                .map(|entry| entry.file_name().to_string_lossy().into_owned())
                .collect();
            let near = did_you_mean(&name, names.iter().map(String::as_str));
            let help = near.map(|near| format!("did you mean `{near}`?"));
            Some((format!("{} cannot be read: {problem}", path.display()), help))
        }
    }
}
