//! From a kind and parameters to a node: the parameters are held against the kind's schema, so that each mistake is
//! reported at its place, and then handed to serde.

mod check;
mod choice;
mod schema;

#[cfg(test)]
mod tests;

use super::nearest::nearest_or_all;
use super::scope::{GivenParam, Resolved, Written};
use super::{Diagnostic, Literal, Source, Spanned};
use crate::node::{Kind, Kinds, NoKind, Node};
use check::{Checker, Part};
pub(crate) use schema::Schema;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Makes a node of the kind `kind_name`, one of `kinds`, which stands in `source`, with the parameters `with`. Parameters that are not
/// given take their defaults.
///
/// # Errors
/// Every mistake: an unknown kind, unknown parameters, values of a wrong type or out of range, unknown variants,
/// missing parameters.
pub fn build_node(
    kinds: &Kinds,
    kind_name: &Spanned<String>,
    with: &BTreeMap<String, GivenParam<'_>>,
    source: &Arc<Source>,
) -> Result<Box<dyn Node>, Vec<Diagnostic>> {
    let name = kind_name.value.as_str();
    let kind = kinds.find(name).map_err(|problem| vec![unknown(problem, kinds, kind_name, source)])?;
    let mut checker = Checker::new(Kinds::schema(kind), source);
    let parameters = parameters(&mut checker, kind_name, with);
    missing(&mut checker, kind_name, with);
    if !checker.mistakes.is_empty() {
        return Err(in_order(checker.mistakes));
    }
    kind.node(&parameters).map_err(|error| vec![residual(kind, &error, kind_name, with, &parameters, source)])
}

/// A kind that there is not, or that cannot be had.
fn unknown(problem: Option<NoKind>, kinds: &Kinds, kind_name: &Spanned<String>, source: &Arc<Source>) -> Diagnostic {
    let name = kind_name.value.as_str();
    if let Some(NoKind { code, message, help }) = problem {
        return Diagnostic::at(code, source, kind_name.span, message).may_help(help);
    }
    let help = super::did_you_mean(name, kinds.names()).map_or_else(
        || "`grimace nodes` lists all kinds".to_owned(),
        |near| format!("did you mean `{near}`? `grimace nodes` lists all kinds"),
    );
    Diagnostic::at("unknown-kind", source, kind_name.span, format!("there is no node kind `{name}`")).help(help)
}

/// The mistakes in the parameters `with` of the kind `kind_name`, where others could not even be resolved, so that a
/// node cannot be made.
pub(super) fn check_parameters(
    kinds: &Kinds,
    kind_name: &Spanned<String>,
    with: &BTreeMap<String, GivenParam<'_>>,
    source: &Arc<Source>,
) -> Vec<Diagnostic> {
    let Some(kind) = kinds.get(kind_name.value.as_str()) else {
        return build_node(kinds, kind_name, with, source).err().unwrap_or_default();
    };
    let mut checker = Checker::new(Kinds::schema(kind), source);
    parameters(&mut checker, kind_name, with);
    in_order(checker.mistakes)
}

/// Mistakes in the order of the file, those of the command line first.
fn in_order(mut mistakes: Vec<Diagnostic>) -> Vec<Diagnostic> {
    mistakes.sort_by_key(|mistake| mistake.place.as_ref().map(|(place, _)| place.span));
    mistakes
}

/// Checks all parameters and gives them as JSON.
fn parameters(
    checker: &mut Checker<'_>,
    kind: &Spanned<String>,
    with: &BTreeMap<String, GivenParam<'_>>,
) -> Map<String, Value> {
    let schema = checker.root();
    let known = schema.properties();
    let mut values = Map::new();
    for (name, given) in with {
        let (key, written, set) = match given.written {
            Written::Graph(param) => (param.name_span, Some(&param.value), None),
            Written::CommandLine(text) => (kind.span, None, Some(text)),
        };
        checker.command_line = set.map(str::to_owned);
        if let Some((_, property)) = known.iter().find(|(known, _)| known == name) {
            let span = written.map_or(key, |value| value.span);
            let part = Part { value: &given.value, written, span };
            let value = checker.check(*property, &part, name);
            values.insert(name.clone(), value);
        } else {
            let names = known.iter().map(|(name, _)| *name);
            let help = nearest_or_all("parameters", name, names)
                .unwrap_or_else(|| format!("`{}` takes no parameters", kind.value));
            checker.report("unknown-parameter", key, format!("`{}` has no parameter `{name}`", kind.value)).help =
                Some(help);
        }
    }
    checker.command_line = None;
    values
}

/// Reports the parameters that must be given and are not.
fn missing(checker: &mut Checker<'_>, kind: &Spanned<String>, with: &BTreeMap<String, GivenParam<'_>>) {
    let schema = checker.root();
    let known = schema.properties();
    for name in schema.required().filter(|name| !with.contains_key(*name)) {
        let expected = known.iter().find(|(known, _)| *known == name).map(|(_, property)| property.expected(name));
        let message = format!("`{}` needs the parameter `{name}`", kind.value);
        let mistake = checker.report("missing-parameter", kind.span, message);
        mistake.help = Some(match expected {
            Some(expected) => format!("add `{name}` to `with`: {expected}"),
            None => format!("add `{name}` to `with`"),
        });
    }
}

/// What serde found wrong that the schema does not say, at the parameter that is wrong by itself, where one is.
fn residual(
    of: &Kind,
    error: &str,
    kind: &Spanned<String>,
    with: &BTreeMap<String, GivenParam<'_>>,
    values: &Map<String, Value>,
    source: &Arc<Source>,
) -> Diagnostic {
    for (name, value) in values {
        let alone = Map::from_iter([(name.clone(), value.clone())]);
        let Err(error) = of.node(&alone) else { continue };
        let message = format!("parameter `{name}`: {error}");
        match with.get(name).map(|given| given.written) {
            Some(Written::Graph(param)) if !error.contains("missing field") => {
                return Diagnostic::at("bad-parameter", source, param.value.span, message);
            }
            Some(Written::CommandLine(text)) => {
                return Diagnostic::new("bad-parameter", format!("`--set {text}`: {message}"));
            }
            _ => {}
        }
    }
    let message = format!("the parameters of `{}` do not fit: {error}", kind.value);
    Diagnostic::at("bad-parameter", source, kind.span, message)
}

/// Whether the parameter `name` of `kind` takes `value`, as read from a command line, as plain text all the same.
pub(super) fn takes_text(kinds: &Kinds, kind: &str, name: &str, value: &Literal) -> bool {
    let Some(schema) = kinds.get(kind).map(|kind| Schema::root(Kinds::schema(kind))) else { return false };
    let property = schema.properties().into_iter().find(|(known, _)| *known == name);
    property.is_some_and(|(_, property)| {
        let allows = |name| property.allows(name);
        let nothing = allows("null") && *value == Literal::Nothing;
        allows("string") && !nothing && !["number", "integer", "boolean", "array", "object"].into_iter().any(allows)
    })
}

/// The parameters of `node` as canonical JSON: maps in the order of their keys, floats in their shortest form,
/// defaults included. Those named in `skip` (files, whose content counts instead) are left out.
///
/// A node whose parameters are no JSON object (no kind's are) gets its debug text under the empty name, so that nodes
/// that differ still differ here.
pub fn canonical_parameters(node: &dyn Node, skip: &[&str]) -> BTreeMap<String, String> {
    let tagged = serde_json::to_value(node).ok();
    let Some(Value::Object(parameters)) = tagged.as_ref().and_then(|tagged| tagged.get(node.typetag_name())) else {
        return BTreeMap::from([(String::new(), format!("{node:?}"))]);
    };
    let counted = parameters.iter().filter(|(name, _)| !skip.contains(&name.as_str()));
    counted.map(|(name, value)| (name.clone(), canonical(value))).collect()
}

fn canonical(value: &Value) -> String {
    match value {
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(canonical).collect();
            format!("[{}]", items.join(","))
        }
        Value::Object(entries) => {
            let sorted: BTreeMap<_, _> = entries.iter().collect();
            let entry =
                |(name, value): (&String, &Value)| format!("{}:{}", Value::from(name.as_str()), canonical(value));
            format!("{{{}}}", sorted.into_iter().map(entry).collect::<Vec<_>>().join(","))
        }
        plain => plain.to_string(),
    }
}

/// The value as a message shows it.
fn found(value: &Resolved) -> String {
    value.shown()
}
