//! Resolves what inputs are connected to, through nested graphs, down to outputs of nodes.

use super::load::{Loader, Member};
use crate::document::{Diagnostic, GraphInput, Place, Span, Spanned, did_you_mean};
use crate::node::{PortFacts, type_text};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// An output of a node, as an input's source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RawSource {
    pub node: usize,
    pub port: String,
    pub list: bool,
    pub label: String,
}

/// All wires of the loaded nodes.
pub(super) struct Wires {
    /// Per node and input port: the place of the connection and its sources.
    pub inputs: Vec<Vec<RawInput>>,
    /// Per instance: the list it is cooked for, where it has one.
    pub each: Vec<Option<RawSource>>,
    /// Per node: the list it is itself cooked for.
    pub node_each: Vec<Option<RawSource>>,
    /// What the root graph gives.
    pub outputs: BTreeMap<String, Vec<RawSource>>,
}

/// A connected input.
pub(super) struct RawInput {
    pub port: PortFacts,
    pub place: Place,
    pub sources: Vec<RawSource>,
}

/// Resolves every connection; what cannot be resolved is reported.
pub(super) fn wires(loader: &mut Loader) -> Wires {
    check_nested_inputs(loader);
    check_unmade(loader);
    let each = (0..loader.instances.len()).map(|instance| instance_each(loader, instance)).collect();
    let mut inputs = Vec::new();
    let mut node_each = Vec::new();
    for node in 0..loader.nodes.len() {
        let instance = loader.nodes[node].instance;
        let for_each = loader.entry(node).for_each.clone();
        node_each.push(for_each.and_then(|list| reference(loader, instance, &list).into_iter().next()));
        inputs.push(node_inputs(loader, node));
    }
    let given = loader.instances[0].graph.outputs.clone();
    let outputs = given.into_iter().map(|(name, text)| (name, reference(loader, 0, &text))).collect();
    Wires { inputs, each, node_each, outputs }
}

/// Connections of what could not be made: at least the nodes that they name must be there.
fn check_unmade(loader: &mut Loader) {
    for instance in 0..loader.instances.len() {
        let graph = Arc::clone(&loader.instances[instance].graph);
        for (name, entry) in &graph.nodes {
            if matches!(loader.instances[instance].members.get(name), Some(Member::Broken)) {
                let named = entry.inputs.values().flat_map(|input| &input.sources).chain(&entry.for_each);
                named.for_each(|text| drop(reference(loader, instance, text)));
            }
        }
    }
}

fn node_inputs(loader: &mut Loader, node: usize) -> Vec<RawInput> {
    let instance = loader.nodes[node].instance;
    let graph = Arc::clone(&loader.instances[instance].graph);
    let card = Arc::clone(&loader.nodes[node].made.card);
    let name = loader.nodes[node].template.name.clone();
    let kind = loader.nodes[node].kind.clone();
    let entry = &graph.nodes[&name];
    for (port, input) in &entry.inputs {
        if card.input(port).is_none() {
            let near = did_you_mean(port, card.inputs.iter().map(|known| known.name));
            let known: Vec<_> = card.inputs.iter().map(|known| format!("`{}`", known.name)).collect();
            let message = format!("`{}` has no input `{port}`", kind.value);
            let known =
                if known.is_empty() { "it takes none".into() } else { format!("it takes {}", known.join(", ")) };
            let mistake = Diagnostic::at("unknown-port", &graph.source, input.name_span, message)
                .label(known)
                .may_help(near.map(|near| format!("did you mean `{near}`?")));
            loader.report(instance, mistake);
        }
    }
    let mut resolved = Vec::new();
    for port in &card.inputs {
        let Some(input) = entry.inputs.get(port.name) else {
            if !port.optional {
                let message =
                    format!("`{name}` needs its input `{}` ({}): {}", port.name, port.type_text(), port.meaning);
                let cure = format!("add it: in: {{ \"{}\": \"node.port\" }}", port.name);
                loader.report(
                    instance,
                    Diagnostic::at("missing-input", &graph.source, entry.name_span, message).help(cure),
                );
            }
            continue;
        };
        if input.sources.len() > 1 && !port.list {
            let message = format!("input `{}` takes one {}, not several", port.name, port.kind.name);
            let mistake = Diagnostic::at("not-a-list", &graph.source, input.sources[1].span, message);
            loader.report(instance, mistake.help("leave one; a node for each of them makes a result for each"));
            continue;
        }
        loader.troubled = false;
        let sources = input.sources.iter().flat_map(|text| reference(loader, instance, text)).collect::<Vec<_>>();
        let span = input.sources.first().map_or(input.name_span, |text| text.span);
        let open_through_nesting = sources.is_empty() && !port.optional && !loader.troubled;
        if open_through_nesting {
            let message = format!("`{name}` needs its input `{}`, which the nesting graph leaves open", port.name);
            loader.report(instance, Diagnostic::at("missing-input", &graph.source, span, message));
        }
        resolved.push(RawInput { port: *port, place: Place { source: Arc::clone(&graph.source), span }, sources });
    }
    resolved
}

/// The outputs that the text `node`, `node.port` or a graph input's name stands for, in `instance`.
fn reference(loader: &mut Loader, instance: usize, text: &Spanned<String>) -> Vec<RawSource> {
    let here = (instance, text.value.clone());
    if loader.resolving.contains(&here) {
        let message = format!("`{}` leads in a circle through nested graphs", text.value);
        let source = Arc::clone(&loader.instances[instance].graph.source);
        loader.report(instance, Diagnostic::at("cycle", &source, text.span, message));
        return Vec::new();
    }
    loader.resolving.push(here);
    let sources = follow(loader, instance, text);
    loader.resolving.pop();
    sources
}

fn follow(loader: &mut Loader, instance: usize, text: &Spanned<String>) -> Vec<RawSource> {
    let graph = Arc::clone(&loader.instances[instance].graph);
    let members = &loader.instances[instance].members;
    let (name, port) = match text.value.rsplit_once('.') {
        _ if members.contains_key(&text.value) || graph.inputs.contains_key(&text.value) => (text.value.as_str(), None),
        Some((name, port)) => (name, Some(port)),
        None => (text.value.as_str(), None),
    };
    match members.get(name).copied() {
        Some(Member::Node(node)) => output(loader, instance, node, name, port, text.span),
        Some(Member::Nested(nested)) => nested_output(loader, instance, nested, port, text),
        Some(Member::Broken) => {
            loader.troubled = true;
            Vec::new()
        }
        None if graph.inputs.contains_key(name) => {
            if let Some(port) = port {
                let message = format!("`{name}` is an input of this graph and has no port `{port}`");
                let mistake = Diagnostic::at("unknown-port", &graph.source, text.span, message);
                loader.report(instance, mistake.help(format!("write \"{name}\"")));
                return Vec::new();
            }
            graph_input(loader, instance, name)
        }
        None => {
            let near = did_you_mean(name, graph.nodes.keys().chain(graph.inputs.keys()).map(String::as_str));
            let message = format!("there is no node `{name}` in this graph");
            let mistake = Diagnostic::at("unknown-node", &graph.source, text.span, message);
            loader.report(instance, mistake.may_help(near.map(|near| format!("did you mean `{near}`?"))));
            Vec::new()
        }
    }
}

fn output(loader: &mut Loader, at: usize, node: usize, name: &str, port: Option<&str>, span: Span) -> Vec<RawSource> {
    let card = Arc::clone(&loader.nodes[node].made.card);
    let found = match port {
        Some(port) => card.output(port),
        None if card.outputs.len() == 1 => card.outputs.first(),
        None => None,
    };
    if let Some(found) = found {
        let (port, list) = (found.name.to_owned(), found.list);
        return vec![RawSource { node, port, list, label: name.to_owned() }];
    }
    let known: Vec<_> = card.outputs.iter().map(|known| format!("\"{name}.{}\"", known.name)).collect();
    let near = port.and_then(|port| did_you_mean(port, card.outputs.iter().map(|known| known.name)));
    let message = match port {
        Some(port) => format!("`{name}` has no output `{port}`"),
        None => format!("`{name}` has several outputs; say which"),
    };
    let help = near
        .map_or_else(|| format!("it gives {}", known.join(", ")), |near| format!("did you mean \"{name}.{near}\"?"));
    let source = Arc::clone(&loader.instances[at].graph.source);
    loader.report(at, Diagnostic::at("unknown-port", &source, span, message).help(help));
    Vec::new()
}

fn nested_output(
    loader: &mut Loader,
    at: usize,
    nested: usize,
    port: Option<&str>,
    text: &Spanned<String>,
) -> Vec<RawSource> {
    let graph = Arc::clone(&loader.instances[nested].graph);
    let found = match port {
        Some(port) => graph.outputs.get(port),
        None if graph.outputs.len() == 1 => graph.outputs.values().next(),
        None => None,
    };
    if let Some(found) = found {
        let mut sources = reference(loader, nested, found);
        for source in &mut sources {
            source.label.clone_from(&text.value);
        }
        return sources;
    }
    let known: Vec<_> = graph.outputs.keys().map(|known| format!("`{known}`")).collect();
    let file = graph.source.path.display();
    let message = match port {
        Some(port) => format!("{file} has no output `{port}`"),
        None => format!("{file} has several outputs; say which"),
    };
    let near = port.and_then(|port| did_you_mean(port, graph.outputs.keys().map(String::as_str)));
    let help = near.map_or_else(|| format!("it gives {}", known.join(", ")), |near| format!("did you mean `{near}`?"));
    let source = Arc::clone(&loader.instances[at].graph.source);
    loader.report(at, Diagnostic::at("unknown-port", &source, text.span, message).help(help));
    Vec::new()
}

/// What the nesting graph connects to the input `name` of `instance`.
fn graph_input(loader: &mut Loader, instance: usize, name: &str) -> Vec<RawSource> {
    if loader.mistyped.contains(&(instance, name.to_owned())) {
        loader.troubled = true;
        return Vec::new();
    }
    let Some((parent, node)) = loader.instances[instance].parent.clone() else { return Vec::new() };
    let entry = loader.instances[parent].graph.nodes[&node].clone();
    if let Some(input) = entry.inputs.get(name) {
        return input.sources.iter().flat_map(|text| reference(loader, parent, text)).collect();
    }
    match &entry.for_each {
        Some(list) if item_input(loader, instance).as_deref() == Some(name) => reference(loader, parent, list),
        _ => {
            // One that must be connected is told where the graph is nested.
            loader.troubled |= loader.instances[instance].graph.inputs.get(name).is_some_and(|input| !input.optional);
            Vec::new()
        }
    }
}

/// The input of `instance` that receives the item: the one that `in` leaves open.
fn item_input(loader: &Loader, instance: usize) -> Option<String> {
    let (parent, node) = loader.instances[instance].parent.as_ref()?;
    let entry = &loader.instances[*parent].graph.nodes[node];
    let open = |required: bool| {
        let inputs = loader.instances[instance].graph.inputs.iter();
        inputs
            .filter(|(name, input)| !entry.inputs.contains_key(*name) && input.optional != required)
            .map(|(name, _)| name.clone())
            .collect::<Vec<_>>()
    };
    let (needed, optional) = (open(true), open(false));
    match (needed.as_slice(), optional.as_slice()) {
        ([one], _) | ([], [one]) => Some(one.clone()),
        _ => None,
    }
}

fn instance_each(loader: &mut Loader, instance: usize) -> Option<RawSource> {
    let (parent, node) = loader.instances[instance].parent.clone()?;
    let list = loader.instances[parent].graph.nodes[&node].for_each.clone()?;
    reference(loader, parent, &list).into_iter().next()
}

/// Connections to nested graphs: unknown inputs, and required ones left open.
fn check_nested_inputs(loader: &mut Loader) {
    for instance in 1..loader.instances.len() {
        let Some((parent, node)) = loader.instances[instance].parent.clone() else { continue };
        let outer = Arc::clone(&loader.instances[parent].graph);
        let graph = Arc::clone(&loader.instances[instance].graph);
        let entry = &outer.nodes[&node];
        let file = graph.source.path.display();
        for (name, input) in entry.inputs.iter().filter(|(name, _)| !graph.inputs.contains_key(*name)) {
            let near = did_you_mean(name, graph.inputs.keys().map(String::as_str));
            let message = format!("{file} has no input `{name}`");
            let mistake = Diagnostic::at("unknown-port", &outer.source, input.name_span, message);
            loader.report(parent, mistake.may_help(near.map(|near| format!("did you mean `{near}`?"))));
        }
        let item = entry.for_each.as_ref().and_then(|_| item_input(loader, instance));
        let needed = graph.inputs.iter().filter(|(name, input)| {
            !input.optional && !entry.inputs.contains_key(*name) && item.as_ref() != Some(*name)
        });
        for (name, input) in needed {
            let list = if input.list { format!("[{}]", input.type_name) } else { input.type_name.clone() };
            let message = format!("`{node}` needs the input `{name}` ({list}) of {file}");
            let help = if entry.for_each.is_some() {
                "connect all inputs but one under `in`; the one left open receives the item".to_owned()
            } else {
                format!("add it: in: {{ \"{name}\": \"node.port\" }}")
            };
            loader.report(parent, Diagnostic::at("missing-input", &outer.source, entry.name_span, message).help(help));
        }
        for (name, declared) in &graph.inputs {
            check_nested_type(loader, (parent, instance), name, declared);
        }
    }
}

/// Whether what the nesting graph connects has the type that the nested one declares. A list may meet a single input: the
/// nodes behind it then repeat over it.
fn check_nested_type(loader: &mut Loader, (parent, instance): (usize, usize), name: &str, declared: &GraphInput) {
    let graph = Arc::clone(&loader.instances[instance].graph);
    // Kinds from elsewhere are only looked for where the linked ones do not know the type.
    let linked = crate::node::kinds().any(|(_, kind)| {
        let card = kind.card();
        card.inputs.iter().chain(&card.outputs).any(|port| port.kind.name == declared.type_name)
    });
    let kinds = if linked { crate::node::kinds().collect() } else { loader.kinds().all() };
    let known: BTreeSet<&str> = kinds
        .into_iter()
        .flat_map(|(_, kind)| kind.card().inputs.into_iter().chain(kind.card().outputs))
        .map(|port| port.kind.name)
        .collect();
    if !known.contains(declared.type_name.as_str()) {
        let near = did_you_mean(&declared.type_name, known.iter().copied());
        let help = near.map_or_else(
            || format!("the types are {}", known.iter().copied().collect::<Vec<_>>().join(", ")),
            |near| format!("did you mean `{near}`?"),
        );
        let message = format!("there is no type `{}`", declared.type_name);
        loader.report(instance, Diagnostic::at("unknown-type", &graph.source, declared.span, message).help(help));
        loader.mistyped.insert((instance, name.to_owned()));
        return;
    }
    let given = graph_input(loader, instance, name);
    let wrong = given.into_iter().find_map(|source| {
        let port = *loader.nodes[source.node].made.card.output(&source.port)?;
        (port.kind.name != declared.type_name).then_some((source, port))
    });
    let Some((source, port)) = wrong else { return };
    let outer = Arc::clone(&loader.instances[parent].graph);
    let entry = loader.instances[instance].parent.as_ref().map(|(_, node)| &outer.nodes[node]);
    let Some(entry) = entry else { return };
    let written = entry.inputs.get(name).and_then(|input| input.sources.first()).or(entry.for_each.as_ref());
    let span = written.map_or(entry.name_span, |text| text.span);
    let message = format!(
        "input `{name}` of {} takes {}, and `{}` is {}",
        graph.source.path.display(),
        type_text(&declared.type_name, declared.list),
        source.label,
        type_text(port.kind.name, port.list),
    );
    let card = Arc::clone(&loader.nodes[source.node].made.card);
    let help = super::check::conversion(loader.kinds(), &card, &port, &declared.type_name);
    let mistake = Diagnostic::at("type-mismatch", &outer.source, span, message).label(port.meaning).may_help(help);
    loader.mistyped.insert((instance, name.to_owned()));
    loader.report(parent, mistake);
}
