//! Reading one node of a graph file: its kind or nested graph, inputs and parameters.

use super::Reader;
use super::fields::{Fields, quoted, shown};
use crate::document::{Body, Entry, EntryInput, EntryParam, Literal, Spanned};
use std::collections::BTreeMap;

const ENTRY_FIELDS: [&str; 5] = ["kind", "graph", "for_each", "in", "with"];

impl Reader {
    /// One node; `None` where it does not say what it is.
    pub fn entry(&mut self, name: &Spanned<String>, value: Spanned<Literal>) -> Option<Entry> {
        let what = format!("the node `{}`", name.value);
        let mut fields = self.fields(value, &what, &ENTRY_FIELDS)?;
        let body = self.body(&mut fields, name);
        let for_each = fields.take_some("for_each").and_then(|list| self.text(list, "`for_each`"));
        let inputs = self.entry_inputs(&mut fields, &name.value);
        let with = self.entry_params(&mut fields);
        Some(Entry { name_span: name.span, body: body?, for_each, inputs, with })
    }

    fn body(&mut self, fields: &mut Fields, name: &Spanned<String>) -> Option<Body> {
        let graph_span = fields.span("graph").unwrap_or(name.span);
        match (fields.take_some("kind"), fields.take_some("graph")) {
            (Some(kind), None) => self.text(kind, "`kind`").map(Body::Kind),
            (None, Some(graph)) => self.text(graph, "`graph`").map(Body::Graph),
            (Some(kind), Some(_)) => {
                let message = format!("the node `{}` has both `kind` and `graph`", name.value);
                self.report("kind-or-graph", graph_span, message).help =
                    Some("keep `kind` for a node, or `graph` for a nested graph file".to_owned());
                self.text(kind, "`kind`").map(Body::Kind)
            }
            (None, None) => {
                if self.sound && !fields.has_misspelt("kind") && !fields.has_misspelt("graph") {
                    let message = format!("the node `{}` has neither `kind` nor `graph`", name.value);
                    self.report("kind-or-graph", name.span, message).help =
                        Some("add `kind: \"…\"` for a node, or `graph: \"….ron\"` for a nested graph file".to_owned());
                }
                None
            }
        }
    }

    fn entry_inputs(&mut self, fields: &mut Fields, node: &str) -> BTreeMap<String, EntryInput> {
        let Some(inputs) = fields.take("in") else { return BTreeMap::new() };
        let mut known = BTreeMap::new();
        for (name, value) in self.entries(inputs, "`in`", "input") {
            let what = format!("input `{}` of `{node}`", name.value);
            let values = match value.value {
                Literal::List(items) => items,
                Literal::Text(_) => vec![value],
                other => {
                    let message = format!("{what} must be \"node.port\" or a list of these, found {}", shown(&other));
                    self.report("wrong-type", value.span, message);
                    continue;
                }
            };
            let sources = values.into_iter().filter_map(|value| self.connection(value, &what)).collect();
            known.insert(name.value, EntryInput { name_span: name.span, sources });
        }
        known
    }

    /// `node.port` or `node`.
    fn connection(&mut self, value: Spanned<Literal>, what: &str) -> Option<Spanned<String>> {
        let text = self.text(value, what)?;
        let parts: Vec<&str> = text.value.split('.').collect();
        if parts.len() > 2 || parts.iter().any(|part| part.is_empty()) {
            let message = format!("{what}: {} names no output", quoted(&text.value));
            self.report("bad-connection", text.span, message).help =
                Some("write \"node.port\", or \"node\" where the node has one output".to_owned());
            return None;
        }
        Some(text)
    }

    fn entry_params(&mut self, fields: &mut Fields) -> BTreeMap<String, EntryParam> {
        let Some(with) = fields.take("with") else { return BTreeMap::new() };
        let mut known = BTreeMap::new();
        for (name, value) in self.entries(with, "`with`", "parameter") {
            self.repeated_keys(&value);
            known.insert(name.value, EntryParam { name_span: name.span, value });
        }
        known
    }
}
