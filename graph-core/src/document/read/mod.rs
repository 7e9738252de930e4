//! From RON text to a [`Graph`], with every mistake reported in one pass. Whether kinds, ports and parameters exist
//! is checked later, where they are known.

mod entry;
mod fields;

#[cfg(test)]
mod recovery;
#[cfg(test)]
mod tests;

use super::ron::parse;
use super::{Diagnostic, Entry, Graph, GraphInput, Literal, Source, Span, Spanned};
pub(super) use fields::shown;
use fields::{Fields, quoted};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The version of the graph language that this program reads.
const VERSION: i64 = 1;
const GRAPH_FIELDS: [&str; 6] = ["grimace", "doc", "params", "inputs", "outputs", "nodes"];

/// Reads a graph file's text. The graph holds whatever could be understood; it is `None` where that is nothing.
pub fn read(source: Arc<Source>) -> (Option<Graph>, Vec<Diagnostic>) {
    let parsed = parse(&source.text);
    let sound = parsed.errors.is_empty();
    let mistakes = parsed.errors.into_iter().map(|error| {
        Diagnostic::at("syntax", &source, error.span, error.message).label(error.label).may_help(error.help)
    });
    let mut reader = Reader { mistakes: mistakes.collect(), source, sound };
    let graph = parsed.value.and_then(|value| reader.graph(value));
    if let (None, [only]) = (&graph, reader.mistakes.as_mut_slice()) {
        only.help.get_or_insert_with(|| EXAMPLE.to_owned());
    }
    reader.mistakes.sort_by_key(|mistake| mistake.place.as_ref().map(|(place, _)| place.span));
    (graph, reader.mistakes)
}

/// A field's name, where that stands, and its value.
pub(super) type NamedValue = (String, Span, Spanned<Literal>);

/// The fields of a file of nothing but named fields, in the order of `known`, with all mistakes.
pub(super) fn fields_of(source: &Arc<Source>, what: &str, known: &[&str]) -> (Vec<NamedValue>, Vec<Diagnostic>) {
    let parsed = parse(&source.text);
    let mistakes = parsed.errors.into_iter().map(|error| {
        Diagnostic::at("syntax", source, error.span, error.message).label(error.label).may_help(error.help)
    });
    let mut reader = Reader { mistakes: mistakes.collect(), source: Arc::clone(source), sound: true };
    let fields = parsed.value.and_then(|value| reader.fields(value, what, known));
    let taken = fields.into_iter().flat_map(|mut fields| {
        let take = |name: &&str| {
            let span = fields.span(name)?;
            Some(((*name).to_owned(), span, fields.take(name)?))
        };
        known.iter().filter_map(take).collect::<Vec<_>>()
    });
    let taken = taken.collect();
    (taken, reader.mistakes)
}

const EXAMPLE: &str = "a graph looks like ( grimace: 1, nodes: { \"head\": (kind: \"sample_actor\") } )";

/// Collects the mistakes of one file.
struct Reader {
    source: Arc<Source>,
    mistakes: Vec<Diagnostic>,
    /// Whether the text itself is sound RON; where it is not, nothing is called missing.
    sound: bool,
}

impl Reader {
    fn report(&mut self, code: &'static str, span: Span, message: impl Into<String>) -> &mut Diagnostic {
        let index = self.mistakes.len();
        self.mistakes.push(Diagnostic::at(code, &self.source, span, message));
        &mut self.mistakes[index]
    }

    fn graph(&mut self, value: Spanned<Literal>) -> Option<Graph> {
        let span = value.span;
        let mut fields = self.fields(value, "the graph", &GRAPH_FIELDS)?;
        if let Some(version) = fields.take("grimace") {
            self.version(&version);
        }
        let doc = fields.take_some("doc").and_then(|doc| self.text(doc, "`doc`")).map(|doc| doc.value);
        let params = self.params(&mut fields);
        let inputs = self.inputs(&mut fields);
        let outputs = self.outputs(&mut fields);
        let nodes = fields.take("nodes");
        if nodes.is_none() && self.sound && !fields.has_misspelt("nodes") {
            let first = Span { start: span.start, end: span.start + 1 };
            self.report("missing-field", first, "the graph has no `nodes`").help =
                Some("add `nodes: { … }`, or `nodes: {}` for none".to_owned());
        }
        let nodes = nodes.map(|nodes| self.nodes(nodes)).unwrap_or_default();
        Some(Graph { source: Arc::clone(&self.source), doc, params, inputs, outputs, nodes })
    }

    fn version(&mut self, version: &Spanned<Literal>) {
        if version.value == Literal::Integer(VERSION) {
            return;
        }
        let found = shown(&version.value);
        let help = match version.value {
            Literal::Integer(newer) if newer > VERSION => "update grimace, or write the graph for version 1",
            _ => "write `grimace: 1`",
        };
        let message = format!("this program reads version {VERSION} of the graph language, found {found}");
        self.report("unsupported-version", version.span, message).help = Some(help.to_owned());
    }

    fn params(&mut self, fields: &mut Fields) -> BTreeMap<String, Spanned<Literal>> {
        let Some(params) = fields.take("params") else { return BTreeMap::new() };
        let entries = self.entries(params, "`params`", "parameter");
        let mut known = BTreeMap::new();
        for (name, value) in entries {
            if name.value.is_empty() || name.value.contains(['}', '{', '.', '=']) || name.value.starts_with("ENV:") {
                let message = format!("{} cannot name a parameter", quoted(&name.value));
                self.report("bad-name", name.span, message).help = Some("use letters, digits, `_` and `-`".to_owned());
            }
            self.repeated_keys(&value);
            known.insert(name.value, value);
        }
        known
    }

    fn inputs(&mut self, fields: &mut Fields) -> BTreeMap<String, GraphInput> {
        let Some(inputs) = fields.take("inputs") else { return BTreeMap::new() };
        let mut known = BTreeMap::new();
        for (name, value) in self.entries(inputs, "`inputs`", "input") {
            let Some(text) = self.text(value, &format!("the type of input `{}`", name.value)) else { continue };
            if let Some(input) = graph_input(&text) {
                known.insert(name.value, input);
            } else {
                let message = format!("`{}` is not a type", text.value);
                self.report("bad-type", text.span, message).help =
                    Some("write \"Markers\", \"[Markers]\" for a list, \"Markers?\" where it may be left open".into());
            }
        }
        known
    }

    fn outputs(&mut self, fields: &mut Fields) -> BTreeMap<String, Spanned<String>> {
        let Some(outputs) = fields.take("outputs") else { return BTreeMap::new() };
        let mut known = BTreeMap::new();
        for (name, value) in self.entries(outputs, "`outputs`", "output") {
            if let Some(from) = self.text(value, &format!("output `{}`", name.value)) {
                known.insert(name.value, from);
            }
        }
        known
    }

    fn nodes(&mut self, nodes: Spanned<Literal>) -> BTreeMap<String, Entry> {
        let mut known = BTreeMap::new();
        for (name, value) in self.entries(nodes, "`nodes`", "node") {
            let reserved = |c: char| c.is_whitespace() || c.is_control() || "./@,:={}$\"'*?[]#".contains(c);
            if name.value.is_empty() || name.value.contains(reserved) {
                let message = format!("{} cannot name a node", quoted(&name.value));
                self.report("bad-name", name.span, message).help =
                    Some("use letters, digits, `_` and `-`; `.` goes before ports and `/` before nested nodes".into());
            }
            if let Some(entry) = self.entry(&name, value) {
                known.insert(name.value, entry);
            }
        }
        known
    }
}

/// `Markers`, `[Markers]`, `Markers?`, `[Markers]?`.
fn graph_input(text: &Spanned<String>) -> Option<GraphInput> {
    let written = text.value.trim();
    let (written, optional) = written.strip_suffix('?').map_or((written, false), |rest| (rest.trim_end(), true));
    let (name, list) = match written.strip_prefix('[') {
        Some(rest) => (rest.strip_suffix(']')?.trim(), true),
        None => (written, false),
    };
    let is_name = name.starts_with(char::is_alphabetic) && name.chars().all(|c| c.is_alphanumeric() || c == '_');
    is_name.then(|| GraphInput { span: text.span, type_name: name.to_owned(), list, optional })
}
