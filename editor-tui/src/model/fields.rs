//! The fields of the parameter form: what the schema says of each parameter, what is written, and what is wrong with it.

use super::State;
use super::board::{Role, nested_file};
use graph_core::document::{Body, Entry, Graph, Span};
use graph_core::node::ParameterDescription;

/// A parameter as the form shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// What may be given, in words.
    pub type_text: String,
    /// What holds where nothing is written.
    pub default: Option<String>,
    /// Whether it must be written.
    pub required: bool,
    /// What is written.
    pub written: Option<String>,
    /// The plain variants, where it is a choice or a switch.
    pub choices: Vec<String>,
    /// What is wrong with what is written.
    pub mistake: Option<String>,
}

impl Field {
    /// What holds, as text.
    pub fn value(&self) -> &str {
        self.written.as_deref().or(self.default.as_deref()).unwrap_or("")
    }
}

impl State {
    /// The fields of the form.
    pub fn fields(&self) -> Vec<Field> {
        let Some(text) = self.texts.get(&self.level().file) else { return Vec::new() };
        let Some(graph) = &text.graph else { return Vec::new() };
        if self.form.of_graph {
            return graph_fields(graph, &text.now, None, self);
        }
        let Some(entry) = self.entry() else { return Vec::new() };
        match &entry.body {
            Body::Kind(kind) => {
                let parameters = self.catalogue.get(&kind.value).map(|facts| facts.manual.parameters.as_slice());
                let known = parameters.unwrap_or_default();
                let mut fields: Vec<Field> = known.iter().map(|known| self.field(known, entry, &text.now)).collect();
                // What the kind does not have stands in the file all the same.
                for (name, param) in
                    entry.with.iter().filter(|(name, _)| known.iter().all(|known| known.name != **name))
                {
                    fields.push(Field {
                        name: name.clone(),
                        doc: String::new(),
                        type_text: format!("`{}` has no such parameter", kind.value),
                        default: None,
                        required: false,
                        written: text.now.get(param.value.span.start..param.value.span.end).map(str::to_owned),
                        choices: Vec::new(),
                        mistake: self.mistake_within(param.name_span).or(Some("there is no such parameter".into())),
                    });
                }
                fields
            }
            Body::Graph(file) => {
                let nested = nested_file(&self.level().file, &file.value);
                let nested = nested.and_then(|nested| self.texts.get(&nested));
                let Some((inner, inner_text)) = nested.and_then(|text| Some((text.graph.as_ref()?, &text.now))) else {
                    return Vec::new();
                };
                graph_fields(inner, inner_text, Some((entry, &text.now)), self)
            }
        }
    }

    fn field(&self, known: &ParameterDescription, entry: &Entry, text: &str) -> Field {
        let given = entry.with.get(&known.name);
        let mut choices: Vec<String> = known
            .choices
            .iter()
            .filter(|choice| !choice.name.contains('('))
            .map(|choice| choice.name.clone())
            .collect();
        if choices.is_empty() && matches!(known.default.as_deref(), Some("true" | "false")) {
            choices = vec!["false".into(), "true".into()];
        }
        let missing = (known.required && given.is_none()).then(|| "must be given".to_owned());
        Field {
            name: known.name.clone(),
            doc: known.doc.clone(),
            type_text: known.type_text.clone(),
            default: known.default.clone(),
            required: known.required,
            written: given.and_then(|given| text.get(given.value.span.start..given.value.span.end)).map(str::to_owned),
            choices,
            mistake: given.and_then(|given| self.mistake_within(given.value.span)).or(missing),
        }
    }

    /// What was found wrong at a place of the open file.
    pub fn mistake_within(&self, span: Span) -> Option<String> {
        let file = &self.level().file;
        let found = self.mistakes.iter().find(|mistake| {
            mistake.place.as_ref().is_some_and(|(place, _)| {
                place.source.path == *file && place.span.start >= span.start && place.span.end <= span.end
            })
        });
        found.map(|mistake| match &mistake.help {
            Some(help) => format!("{} – {help}", mistake.message),
            None => mistake.message.clone(),
        })
    }

    /// What was found wrong with the card at `at`: within its entry, or in the file that it nests.
    pub fn mistake_of(&self, at: usize) -> Option<String> {
        let level = self.level();
        let card = &level.board.cards[at];
        let graph = self.texts.get(&level.file)?.graph.as_ref()?;
        let entry = graph.nodes.get(&card.name)?;
        let kind = match &entry.body {
            Body::Kind(name) | Body::Graph(name) => name.span,
        };
        let mut spans = vec![entry.name_span, kind];
        spans.extend(entry.for_each.iter().map(|list| list.span));
        for input in entry.inputs.values() {
            spans.push(input.name_span);
            spans.extend(input.sources.iter().map(|source| source.span));
        }
        for param in entry.with.values() {
            spans.extend([param.name_span, param.value.span]);
        }
        let own = spans.into_iter().find_map(|span| self.mistake_within(span));
        own.or_else(|| match &card.role {
            Role::Nested(_, Some(file)) => {
                let inner = |mistake: &&graph_core::document::Diagnostic| {
                    mistake.place.as_ref().is_some_and(|(place, _)| place.source.path == *file)
                };
                self.mistakes.iter().find(inner).map(|mistake| mistake.message.clone())
            }
            _ => None,
        })
    }
}

/// The parameters of a graph; where it is nested, with what the nesting node gives.
fn graph_fields(graph: &Graph, text: &str, given: Option<(&Entry, &str)>, state: &State) -> Vec<Field> {
    let written_in = |text: &str, span: Span| text.get(span.start..span.end).map(str::to_owned);
    let fields = graph.params.iter().map(|(name, value)| {
        let own = written_in(text, value.span);
        let (default, written, span) = match given {
            None => (None, own, Some(value.span)),
            Some((entry, outer)) => {
                let param = entry.with.get(name);
                let span = param.map(|param| param.value.span);
                (own, span.and_then(|span| written_in(outer, span)), span)
            }
        };
        Field {
            name: name.clone(),
            doc: comment_before(text, value.span.start),
            type_text: String::new(),
            default,
            required: false,
            written,
            choices: Vec::new(),
            mistake: span.and_then(|span| state.mistake_within(span)),
        }
    });
    fields.collect()
}

/// The comment lines that stand before the line of `at`.
fn comment_before(text: &str, at: usize) -> String {
    let line_start = text[..at].rfind('\n').map_or(0, |at| at + 1);
    let mut lines: Vec<&str> =
        text[..line_start].lines().rev().map_while(|line| line.trim().strip_prefix("//")).map(str::trim).collect();
    lines.reverse();
    lines.join(" ")
}
