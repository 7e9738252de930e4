//! Reading maps and strings out of literals, with their typical mistakes reported.

use super::Reader;
use crate::document::nearest::{did_you_mean, nearest_or_all};
use crate::document::{Literal, Span, Spanned};
use std::collections::{BTreeMap, BTreeSet};

/// The fields of a graph or of a node.
pub(super) struct Fields {
    known: BTreeMap<String, (Span, Spanned<Literal>)>,
    /// Fields that unknown ones were probably meant to be.
    meant: Vec<String>,
}

impl Fields {
    /// Takes a field.
    pub fn take(&mut self, name: &str) -> Option<Spanned<Literal>> {
        self.known.remove(name).map(|(_, value)| value)
    }

    /// Where a field's name stands.
    pub fn span(&self, name: &str) -> Option<Span> {
        self.known.get(name).map(|(span, _)| *span)
    }

    /// Takes a field that may as well be `None`.
    pub fn take_some(&mut self, name: &str) -> Option<Spanned<Literal>> {
        self.take(name).filter(|value| value.value != Literal::Nothing)
    }

    /// Whether an unknown field was probably meant to be `name`.
    pub fn has_misspelt(&self, name: &str) -> bool {
        self.meant.iter().any(|meant| meant == name)
    }
}

impl Reader {
    /// The fields of `value`, all of which must be among `known`; `None` where it is no map.
    pub fn fields(&mut self, value: Spanned<Literal>, what: &str, known: &[&str]) -> Option<Fields> {
        if !matches!(value.value, Literal::Map(_) | Literal::Nothing) {
            let found = shown(&value.value);
            self.report("wrong-type", value.span, format!("{what} must be ( … ) with named fields, found {found}"));
            return None;
        }
        let mut fields = Fields { known: BTreeMap::new(), meant: Vec::new() };
        for (name, value) in self.entries(value, what, "field") {
            if known.contains(&name.value.as_str()) {
                fields.known.insert(name.value, (name.span, value));
            } else {
                fields.meant.extend(did_you_mean(&name.value, known.iter().copied()));
                let help = nearest_or_all("fields", &name.value, known.iter().copied());
                let message = format!("{what} has no field `{}`", name.value);
                self.report("unknown-field", name.span, message).help = help;
            }
        }
        Some(fields)
    }

    /// The entries of the map `value`, each name once; `thing` is what a name stands for.
    pub fn entries(
        &mut self,
        value: Spanned<Literal>,
        what: &str,
        thing: &str,
    ) -> Vec<(Spanned<String>, Spanned<Literal>)> {
        let entries = match value.value {
            Literal::Map(entries) => entries,
            Literal::Nothing => return Vec::new(),
            other => {
                let message = format!("{what} must be a map, found {}", shown(&other));
                self.report("wrong-type", value.span, message).help = Some(format!("write {{ \"{thing}\": … }}"));
                return Vec::new();
            }
        };
        let mut first: BTreeMap<String, Span> = BTreeMap::new();
        let mut once = Vec::with_capacity(entries.len());
        for (name, value) in entries {
            if let Some(before) = first.get(&name.value) {
                let (line, _) = self.source.line_column(before.start);
                let code = if thing == "node" { "duplicate-node" } else { "duplicate-field" };
                let message = format!("the {thing} `{}` stands here twice", name.value);
                let mistake = self.report(code, name.span, message).clone();
                *self.report_last() = mistake.label(format!("first in line {line}")).help("rename or remove one");
            } else {
                first.insert(name.value.clone(), name.span);
                once.push((name, value));
            }
        }
        once
    }

    /// Reports keys that stand twice within a parameter's value.
    pub fn repeated_keys(&mut self, value: &Spanned<Literal>) {
        match &value.value {
            Literal::Map(entries) => {
                let mut seen = BTreeSet::new();
                for (name, value) in entries {
                    if !seen.insert(&name.value) {
                        let message = format!("the key `{}` stands here twice", name.value);
                        self.report("duplicate-field", name.span, message).help =
                            Some("rename or remove one".to_owned());
                    }
                    self.repeated_keys(value);
                }
            }
            Literal::List(items) => items.iter().for_each(|item| self.repeated_keys(item)),
            Literal::Variant(_, content) => self.repeated_keys(content),
            _ => {}
        }
    }

    /// The string that `value` is; `what` is what it stands for.
    pub fn text(&mut self, value: Spanned<Literal>, what: &str) -> Option<Spanned<String>> {
        let Spanned { value, span } = value;
        if let Literal::Text(value) = value {
            return Some(Spanned { value, span });
        }
        self.report("wrong-type", span, format!("{what} must be a string, found {}", shown(&value)));
        None
    }

    fn report_last(&mut self) -> &mut crate::document::Diagnostic {
        let last = self.mistakes.len() - 1;
        &mut self.mistakes[last]
    }
}

/// A name as messages show it.
pub(super) fn quoted(name: &str) -> String {
    if name.is_empty() { "an empty text".to_owned() } else { format!("`{name}`") }
}

/// A value as messages name it.
pub(in crate::document) fn shown(value: &Literal) -> String {
    match value {
        Literal::Nothing => "nothing".to_owned(),
        Literal::Bool(value) => format!("`{value}`"),
        Literal::Integer(number) => format!("the number {number}"),
        Literal::Number(number) => format!("the number {number:?}"),
        Literal::Text(text) if text.chars().count() <= 40 => format!("the string {text:?}"),
        Literal::Text(_) => "a string".to_owned(),
        Literal::List(_) => "a list".to_owned(),
        Literal::Map(_) => "a map".to_owned(),
        Literal::Variant(name, _) => format!("`{name}(…)`"),
    }
}
