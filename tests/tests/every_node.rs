//! What must hold for every kind of node, whoever writes it: its name, its card, its manual, its defaults.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use graph_core::document::{
    Diagnostic, Source, apply_overrides, build_node, canonical_parameters, node_parameters, read,
};
use graph_core::node::{
    ChoiceDescription, Kind, KindDescription, Node, ParameterDescription, PortFacts, describe, kinds,
};
use nodes as _;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::sync::Arc;

/// Folders of nodes, in the order in which data flows through them.
const FOLDERS: [&str; 10] = ["load", "clean", "rig", "solve", "curate", "fake", "texture", "capture", "strain", "save"];

#[test]
fn tags_are_unique() {
    let mut seen = BTreeSet::new();
    for kind in graph_core::inventory::iter::<Kind> {
        assert!(seen.insert(kind.name()), "two kinds are called `{}`", kind.name());
    }
    assert!(!seen.is_empty(), "no kinds are linked");
}

#[test]
fn tags_are_a_verb_and_its_object_in_a_file_of_that_name() {
    for (name, kind) in kinds() {
        let words = name
            .split('_')
            .all(|word| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()));
        assert!(words && name.contains('_'), "`{name}` is not a verb and its object");
        let folder = kind.card().folder;
        assert!(FOLDERS.contains(&folder), "`{name}` stands in the folder `{folder}`, which is not on the way of data");
        let file = whole_system::root().join(format!("nodes/src/{folder}/{name}.rs"));
        assert!(file.is_file(), "`{name}` says that it stands in {}", file.display());
    }
}

#[test]
fn nodes_are_written_and_read_back_under_their_tag() {
    for (name, kind) in kinds() {
        let written = serde_json::to_value(kind.default_node()).unwrap();
        let tagged = written.as_object().unwrap();
        assert!(tagged.len() == 1 && tagged.contains_key(name), "`{name}` is written as {written}");
        let read: Box<dyn Node> = serde_json::from_value(written.clone()).unwrap();
        assert_eq!((read.typetag_name(), serde_json::to_value(&read).unwrap()), (name, written));
        let strange = serde_json::json!({ name: { "no_such_parameter": 1 } });
        assert!(serde_json::from_value::<Box<dyn Node>>(strange).is_err(), "`{name}` takes any parameter");
    }
}

#[test]
fn cards_are_sound() {
    for (name, kind) in kinds() {
        let card = kind.card();
        assert!(card.version >= 1, "`{name}` has version 0");
        assert!(!card.outputs.is_empty(), "`{name}` gives nothing");
        for (side, ports) in [("inputs", &card.inputs), ("outputs", &card.outputs)] {
            check_ports(name, side, ports);
        }
        let parameters: BTreeSet<String> = describe(kind).parameters.into_iter().map(|one| one.name).collect();
        for file in card.reads.into_iter().chain(card.writes) {
            assert!(parameters.contains(file), "the card of `{name}` names a parameter `{file}` that it has not");
        }
    }
}

fn check_ports(kind: &str, side: &str, ports: &[PortFacts]) {
    let mut names = BTreeSet::new();
    for port in ports {
        assert!(names.insert(port.name), "two {side} of `{kind}` are called `{}`", port.name);
        let meaning = port.meaning.trim();
        assert!(!meaning.is_empty() && meaning == port.meaning, "`{kind}` does not say what `{}` means", port.name);
        assert!(!meaning.ends_with('.'), "the meaning of `{kind}.{}` stands in tables, without a full stop", port.name);
    }
}

#[test]
fn the_manual_is_complete() {
    let mut gaps = Vec::new();
    for (name, kind) in kinds() {
        let KindDescription { doc, parameters, .. } = describe(kind);
        if !is_sentence(&doc) {
            gaps.push(format!("`{name}` does not say what it does: {doc:?}"));
        }
        note_gaps(name, &parameters, &mut gaps);
    }
    assert!(gaps.is_empty(), "\n{}", gaps.join("\n"));
}

fn note_gaps(within: &str, parameters: &[ParameterDescription], gaps: &mut Vec<String>) {
    for ParameterDescription { name, doc, choices, fields, .. } in parameters {
        let path = format!("{within}.{name}");
        if !is_sentence(doc) {
            gaps.push(format!("`{path}` does not say what it means: {doc:?}"));
        }
        for ChoiceDescription { name, doc, fields } in choices {
            // What a choice means may well be a formula.
            if !doc.ends_with('.') {
                gaps.push(format!("the choice `{name}` of `{path}` does not say what it means: {doc:?}"));
            }
            note_gaps(&format!("{path}.{name}"), fields, gaps);
        }
        note_gaps(&path, fields, gaps);
    }
}

fn is_sentence(doc: &str) -> bool {
    doc.starts_with(|first: char| !first.is_lowercase()) && doc.ends_with(['.', '`', ')', '|'])
}

/// Makes a node of `kind` from a graph that writes the parameters `with`.
fn made(kind: &str, with: &BTreeMap<String, String>) -> Result<Box<dyn Node>, Vec<Diagnostic>> {
    let mut written = String::new();
    for (name, value) in with {
        let _ = write!(written, "{name}: {value}, ");
    }
    let text = format!("(grimace: 1, nodes: {{ \"node\": (kind: \"{kind}\", with: ({written})) }})");
    let source = Arc::new(Source::new("graph.ron", text));
    let (graph, mistakes) = read(Arc::clone(&source));
    let graph = graph.filter(|_| mistakes.is_empty()).ok_or(mistakes)?;
    let (scope, _) = apply_overrides(&graph, &[], &std::sync::Arc::default());
    let entry = &graph.nodes["node"];
    let given = node_parameters(&graph, entry, &scope, None, &[], "node")?;
    let graph_core::document::Body::Kind(kind) = &entry.body else { unreachable!("the entry names a kind") };
    build_node(&graph_core::node::Kinds::default(), kind, &given.parameters, &source)
}

/// The defaults of a kind as its manual writes them.
fn defaults(kind: &Kind) -> BTreeMap<String, String> {
    describe(kind).parameters.into_iter().filter_map(|one| Some((one.name, one.default?))).collect()
}

#[test]
fn defaults_as_the_manual_writes_them_make_the_default_node() {
    for (name, kind) in kinds() {
        let node = made(name, &defaults(kind)).unwrap_or_else(|mistakes| panic!("`{name}`: {mistakes:#?}"));
        let default = kind.default_node();
        assert_eq!(canonical_parameters(node.as_ref(), &[]), canonical_parameters(default.as_ref(), &[]), "`{name}`");
    }
}

#[test]
fn numbers_out_of_their_range_are_refused() {
    for (name, kind) in kinds() {
        for ParameterDescription { name: parameter, least, most, .. } in describe(kind).parameters {
            let beyond = [least.map(|least| least - 1.0), most.map(|most| most + 1.0)];
            for number in beyond.into_iter().flatten().filter(|number| number.abs() < 1e15) {
                let mut with = defaults(kind);
                with.insert(parameter.clone(), format!("{number}"));
                let Err(mistakes) = made(name, &with) else { panic!("`{name}` takes {number} as its `{parameter}`") };
                let codes: Vec<_> = mistakes.iter().map(|mistake| mistake.code).collect();
                assert_eq!(codes, ["out-of-range"], "`{name}`, `{parameter}`: {mistakes:#?}");
            }
        }
    }
}
