//! What `${…}` stands for in one use of a graph file: its parameters as given from outside, or their defaults.

mod environment;
mod overrides;
mod parameters;
mod resolved;
mod substitute;
mod wiring;

#[cfg(test)]
mod tests;

pub use environment::Environment;
pub use overrides::{Override, apply_overrides};
pub use parameters::{GivenParam, NodeParameters, Written, node_parameters};
pub use resolved::Resolved;
pub use substitute::{resolve, resolve_name};

use super::nearest::nearest_or_all;
use super::{Diagnostic, Entry, Graph, Literal, Place, Source, Span, Spanned};
use crate::node::Kinds;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// The values that texts of one graph file may refer to.
#[derive(Debug, Clone)]
pub struct Scope {
    /// The file whose texts are resolved; `None` for texts of the command line.
    source: Option<Arc<Source>>,
    /// Values by parameter; `None` for a parameter whose own mistakes have been reported.
    values: BTreeMap<String, Option<Resolved>>,
    environment: Arc<Environment>,
    /// Where each value was written.
    places: BTreeMap<String, ValuePlace>,
}

/// Where a parameter's value was written.
#[derive(Debug, Clone, PartialEq)]
pub enum ValuePlace {
    /// On the command line, as `name=value`.
    CommandLine(String),
    /// In a graph file.
    File(Place),
}

impl ValuePlace {
    /// `file:line:col`, or the option of the command line.
    pub fn text(&self) -> String {
        match self {
            Self::CommandLine(text) => format!("--set {text}"),
            Self::File(place) => place.text(),
        }
    }
}

/// What parameters are given from outside, and where that was written.
#[derive(Debug, Default)]
struct Given {
    values: BTreeMap<String, Option<Resolved>>,
    places: BTreeMap<String, ValuePlace>,
}

impl Scope {
    /// The scope of texts on the command line: no parameters, and paths relative to the working folder.
    fn command_line(environment: &Arc<Environment>) -> Self {
        Self { source: None, values: BTreeMap::new(), environment: Arc::clone(environment), places: BTreeMap::new() }
    }

    /// The scope of a file without parameters.
    pub(in crate::document) fn file(source: &Arc<Source>) -> Self {
        let (values, places) = (BTreeMap::new(), BTreeMap::new());
        Self { source: Some(Arc::clone(source)), values, environment: Arc::new(Environment::of_process()), places }
    }

    /// The scope of `graph` with the values `given` from outside in place of the defaults.
    fn open(graph: &Graph, Given { values, places }: Given, environment: &Arc<Environment>) -> (Self, Vec<Diagnostic>) {
        let (source, environment) = (Some(Arc::clone(&graph.source)), Arc::clone(environment));
        let mut scope = Self { source, values, environment, places };
        let mut mistakes = Vec::new();
        let mut waiting: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for (name, default) in graph.params.iter().filter(|(name, _)| !scope.values.contains_key(*name)) {
            let mut needs = BTreeSet::new();
            substitute::references(&default.value, &mut needs);
            waiting.insert(name, needs);
        }
        scope.values.extend(waiting.keys().map(|name| ((*name).to_owned(), None)));
        // A default may refer to other parameters; each is filled in after those it needs.
        while !waiting.is_empty() {
            let is_ready = |needs: &BTreeSet<&str>| !needs.iter().any(|name| waiting.contains_key(name));
            let ready: Vec<&str> = waiting.iter().filter(|(_, needs)| is_ready(needs)).map(|(name, _)| *name).collect();
            if ready.is_empty() {
                scope.report_circle(graph, &waiting, &mut mistakes);
                break;
            }
            for name in ready {
                waiting.remove(name);
                let default = &graph.params[name];
                let value = resolve(default, &scope).map_err(|more| mistakes.extend(more)).ok();
                scope.values.insert(name.to_owned(), value);
                scope.places.insert(name.to_owned(), scope.place_of(default, &graph.source));
            }
        }
        (scope, mistakes)
    }

    fn report_circle(&self, graph: &Graph, waiting: &BTreeMap<&str, BTreeSet<&str>>, mistakes: &mut Vec<Diagnostic>) {
        let Some(first) = waiting.keys().next() else { return };
        let mut walk = vec![*first];
        while let Some(next) = waiting[walk[walk.len() - 1]].iter().find(|name| waiting.contains_key(*name)) {
            let seen = walk.iter().position(|name| name == next);
            walk.push(next);
            if let Some(start) = seen {
                walk.drain(..start);
                break;
            }
        }
        let message = format!("parameters refer to each other in a circle: {}", walk.join(" → "));
        let span = graph.params[walk[0]].span;
        mistakes.push(self.mistake("parameter-cycle", Some(span), message).help("give one of them a plain value"));
    }

    /// The scope of `graph` where `entry` of the file `source` nests it; `outer` is the scope of that file.
    /// `overrides` for the node called `path` through all nesting stand above what the entry says.
    ///
    /// The mistakes are of the outer file (a parameter that the nested graph has not) and of the nested one.
    pub fn nested(
        graph: &Graph,
        entry: &Entry,
        source: &Arc<Source>,
        outer: &Self,
        overrides: &[Override],
        path: &str,
    ) -> (Self, Vec<Diagnostic>) {
        let mut mistakes = Vec::new();
        let mut given = Given::default();
        for (name, param) in &entry.with {
            if !graph.params.contains_key(name) {
                let help = nearest_or_all("parameters", name, graph.params.keys().map(String::as_str));
                let message = format!("`{}` has no parameter `{name}`", graph.source.path.display());
                mistakes.push(Diagnostic::at("unknown-parameter", source, param.name_span, message).may_help(help));
                continue;
            }
            let value = resolve(&param.value, outer).map_err(|more| mistakes.extend(more)).ok();
            given.values.insert(name.clone(), value);
            given.places.insert(name.clone(), outer.place_of(&param.value, source));
        }
        overrides::set_parameters(graph, overrides, path, &outer.environment, &mut given, &mut mistakes);
        let (scope, more) = Self::open(graph, given, &outer.environment);
        mistakes.extend(more);
        (scope, mistakes)
    }

    /// Where a value of the file `source` really comes from: where it stands, or, where it refers to a parameter, where that
    /// has its value from.
    pub fn place_of(&self, value: &Spanned<Literal>, source: &Arc<Source>) -> ValuePlace {
        let mut names = BTreeSet::new();
        substitute::references(&value.value, &mut names);
        let referred = names.into_iter().find_map(|name| self.places.get(name)).cloned();
        referred.unwrap_or_else(|| ValuePlace::File(Place { source: Arc::clone(source), span: value.span }))
    }

    /// The kinds of nodes that the file may name.
    pub fn kinds(&self) -> &Kinds {
        self.environment.kinds()
    }

    /// The folder that relative paths of this file start from.
    fn folder(&self) -> PathBuf {
        self.source.as_ref().map(|source| source.folder().to_owned()).unwrap_or_default()
    }

    /// Where the bytes `part` of the text of a string stand, whose literal is at `span`.
    fn within(&self, span: Span, part: &Range<usize>) -> Option<Span> {
        let source = self.source.as_ref()?;
        let written = source.text.get(span.start..span.end)?;
        let quote = written.find('"')? + 1;
        // Where escapes come before the part, it stands elsewhere; then the whole string is shown.
        let plain = !written[quote..].contains('\\') || written.starts_with('r');
        let place = Span { start: span.start + quote + part.start, end: span.start + quote + part.end };
        Some(if plain && place.end < span.end && source.text.is_char_boundary(place.start) { place } else { span })
    }

    /// A mistake at `span` of this file, or of the command line.
    fn mistake(&self, code: &'static str, span: Option<Span>, message: String) -> Diagnostic {
        match (&self.source, span) {
            (Some(source), Some(span)) => Diagnostic::at(code, source, span, message),
            _ => Diagnostic::new(code, message),
        }
    }
}
