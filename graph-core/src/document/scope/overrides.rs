//! Parameters set on the command line: `--set name=value`, `--set node.param=value`.

use super::{Environment, Given, Resolved, Scope, ValuePlace, resolve};
use crate::document::nearest::nearest_or_all;
use crate::document::ron;
use crate::document::{Diagnostic, Graph, Literal, Span, Spanned};
use std::sync::Arc;

/// One parameter set on the command line.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    /// The node through all nesting, one name a part; empty for a parameter of the graph itself.
    pub path: Vec<String>,
    /// The parameter.
    pub name: String,
    /// The value: RON where it reads as a number, truth value, list, map, variant or quoted string, else the text.
    pub value: Literal,
    /// The value's text as written.
    pub raw: String,
    /// The whole as written: `name=value`.
    pub text: String,
}

impl Override {
    /// Reads `name=value`, `node.param=value` or, nested, `outer.inner.param=value` (`/` does as well as `.`).
    ///
    /// # Errors
    /// Where there is no `=`, or a name is empty.
    #[allow(clippy::result_large_err, reason = "it fails at most once a file or argument")]
    pub fn parse(text: &str) -> Result<Self, Diagnostic> {
        let wrong = |message: &str| {
            Diagnostic::new("bad-override", format!("`--set {text}`: {message}"))
                .help("write `--set name=value` for the graph's parameters, `--set node.param=value` for a node's")
        };
        let (key, raw) = text.split_once('=').ok_or_else(|| wrong("there is no `=`"))?;
        let mut path: Vec<String> = key.split(['.', '/']).map(|part| part.trim().to_owned()).collect();
        let name = path.pop().unwrap_or_default();
        if name.is_empty() || path.iter().any(String::is_empty) {
            return Err(wrong("a name is empty"));
        }
        let (value, raw) = (value(raw), raw.to_owned());
        Ok(Self { path, name, value, raw, text: text.to_owned() })
    }

    /// The value for a parameter that takes a text (`wants_text`), or anything else.
    pub fn value_for(&self, wants_text: bool) -> Literal {
        match &self.value {
            Literal::Text(text) => Literal::Text(text.clone()),
            _ if wants_text => Literal::Text(self.raw.clone()),
            other => other.clone(),
        }
    }

    /// The value with `~` and `${ENV:NAME}` filled in; relative paths start from the working folder.
    pub(super) fn resolved(
        &self,
        wants_text: bool,
        environment: &Arc<Environment>,
    ) -> Result<Resolved, Vec<Diagnostic>> {
        let value = Spanned { value: self.value_for(wants_text), span: Span::default() };
        resolve(&value, &Scope::command_line(environment)).map_err(|mistakes| {
            let named = |mistake: Diagnostic| {
                let message = format!("`--set {}`: {}", self.text, mistake.message);
                Diagnostic { message, ..mistake }
            };
            mistakes.into_iter().map(named).collect()
        })
    }
}

fn value(raw: &str) -> Literal {
    let parsed = ron::parse(raw);
    let quoted = ["\"", "r\"", "r#"].iter().any(|quote| raw.trim_start().starts_with(quote));
    match parsed.value {
        Some(Spanned { value: Literal::Text(text), .. }) if quoted && parsed.errors.is_empty() => Literal::Text(text),
        Some(Spanned { value: Literal::Text(_), .. }) | None => Literal::Text(raw.to_owned()),
        Some(_) if !parsed.errors.is_empty() => Literal::Text(raw.to_owned()),
        Some(Spanned { value, .. }) => value,
    }
}

/// The scope of a graph that is cooked itself, with `overrides` in place of its defaults. Overrides of nodes are left
/// to where the nodes are made.
pub fn apply_overrides(
    graph: &Graph,
    overrides: &[Override],
    environment: &Arc<Environment>,
) -> (Scope, Vec<Diagnostic>) {
    let (mut given, mut mistakes) = (Given::default(), Vec::new());
    set_parameters(graph, overrides, "", environment, &mut given, &mut mistakes);
    let (scope, more) = Scope::open(graph, given, environment);
    mistakes.extend(more);
    (scope, mistakes)
}

/// Puts the overrides for the graph nested as `path` into `given`.
pub(super) fn set_parameters(
    graph: &Graph,
    overrides: &[Override],
    path: &str,
    environment: &Arc<Environment>,
    given: &mut Given,
    mistakes: &mut Vec<Diagnostic>,
) {
    for set in overrides.iter().filter(|set| set.path.join("/") == path) {
        if let Some(default) = graph.params.get(&set.name) {
            let wants_text = matches!(default.value, Literal::Text(_));
            let value = set.resolved(wants_text, environment).map_err(|more| mistakes.extend(more)).ok();
            given.values.insert(set.name.clone(), value);
            given.places.insert(set.name.clone(), ValuePlace::CommandLine(set.text.clone()));
        } else {
            let shown = graph.source.path.display();
            let message = format!("`--set {}`: {shown} has no parameter `{}`", set.text, set.name);
            let help = nearest_or_all("parameters", &set.name, graph.params.keys().map(String::as_str));
            let is_node = graph.nodes.contains_key(&set.name);
            let node = || Some(format!("`{0}` is a node; write `--set {0}.param=value`", set.name));
            let help = if is_node { node() } else { help };
            mistakes.push(Diagnostic::new("unknown-parameter", message).may_help(help));
        }
    }
}
