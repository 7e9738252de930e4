//! `${name}`, `${ENV:NAME}` and `~` in strings: cutting a text into pieces, and putting what they stand for in place.

use super::{Resolved, Scope};
use crate::document::nearest::nearest_or_all;
use crate::document::{Diagnostic, Literal, Span, Spanned};
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;

/// A part of a text.
enum Piece<'a> {
    /// Text to be taken as it stands.
    Verbatim(&'a str),
    /// `${name}`, with where it stands in the text.
    Reference(&'a str, Range<usize>),
    /// `${` without its `}`, at this byte.
    Open(usize),
}

/// Cuts `text` at each `${…}`; `$${` is an escaped `${`.
fn pieces(text: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let mut rest = 0;
    while let Some(offset) = text[rest..].find("${") {
        let start = rest + offset;
        if text[rest..start].ends_with('$') {
            pieces.push(Piece::Verbatim(&text[rest..start - 1]));
            pieces.push(Piece::Verbatim("${"));
            rest = start + 2;
            continue;
        }
        pieces.push(Piece::Verbatim(&text[rest..start]));
        let Some(length) = text[start..].find('}') else {
            pieces.push(Piece::Open(start));
            return pieces;
        };
        rest = start + length + 1;
        pieces.push(Piece::Reference(&text[start + 2..rest - 1], start..rest));
    }
    pieces.push(Piece::Verbatim(&text[rest..]));
    pieces.retain(|piece| !matches!(piece, Piece::Verbatim("")));
    pieces
}

/// The parameters that `text` refers to.
fn named(text: &str) -> impl Iterator<Item = &str> {
    pieces(text).into_iter().filter_map(|piece| match piece {
        Piece::Reference(name, _) if !name.starts_with("ENV:") => Some(name),
        _ => None,
    })
}

/// The parameters that texts within `value` refer to.
pub(super) fn references<'a>(value: &'a Literal, found: &mut BTreeSet<&'a str>) {
    match value {
        Literal::Text(text) => found.extend(named(text)),
        Literal::List(items) => items.iter().for_each(|item| references(&item.value, found)),
        Literal::Map(entries) => entries.iter().for_each(|(name, value)| {
            found.extend(named(&name.value));
            references(&value.value, found);
        }),
        Literal::Variant(_, content) => references(&content.value, found),
        Literal::Nothing | Literal::Bool(_) | Literal::Integer(_) | Literal::Number(_) => {}
    }
}

/// Fills in everything that texts within `value` refer to. A text that is exactly `${name}` takes the parameter's
/// value with its type.
///
/// # Errors
/// Every unknown parameter, unset variable and malformed `${`. The list is empty where the value depends only on
/// parameters whose own mistakes are reported elsewhere.
pub fn resolve(value: &Spanned<Literal>, scope: &Scope) -> Result<Resolved, Vec<Diagnostic>> {
    Ok(match &value.value {
        Literal::Nothing => Resolved::Nothing,
        Literal::Bool(value) => Resolved::Bool(*value),
        Literal::Integer(number) => Resolved::Integer(*number),
        Literal::Number(number) => Resolved::Number(*number),
        Literal::Text(text) => return resolve_text(text, value.span, scope),
        Literal::List(items) => Resolved::List(all(items.iter().map(|item| resolve(item, scope)).collect())?),
        Literal::Map(entries) => {
            let names = all(entries.iter().map(|(name, _)| resolve_name(name, scope)).collect());
            let values = all(entries.iter().map(|(_, value)| resolve(value, scope)).collect());
            match (names, values) {
                (Ok(names), Ok(values)) => Resolved::Map(names.into_iter().map(|(name, _)| name).zip(values).collect()),
                (names, values) => return Err([names.err(), values.err()].into_iter().flatten().flatten().collect()),
            }
        }
        Literal::Variant(name, content) => Resolved::Variant(name.clone(), Box::new(resolve(content, scope)?)),
    })
}

/// All values, or all mistakes.
fn all<T>(values: Vec<Result<T, Vec<Diagnostic>>>) -> Result<Vec<T>, Vec<Diagnostic>> {
    let mut mistakes = Vec::new();
    let (mut good, mut sound) = (Vec::with_capacity(values.len()), true);
    for value in values {
        match value {
            Ok(value) => good.push(value),
            Err(more) => {
                sound = false;
                mistakes.extend(more);
            }
        }
    }
    if sound { Ok(good) } else { Err(mistakes) }
}

fn resolve_text(text: &str, span: Span, scope: &Scope) -> Result<Resolved, Vec<Diagnostic>> {
    let mut folder = scope.folder();
    let pieces = pieces(text);
    if let [Piece::Reference(name, place)] = pieces.as_slice()
        && !name.starts_with("ENV:")
    {
        return parameter(name, place, span, scope).cloned();
    }
    let (mut filled, mut mistakes, mut sound) = (String::with_capacity(text.len()), Vec::new(), true);
    for (index, piece) in pieces.iter().enumerate() {
        let part = match piece {
            Piece::Verbatim(part) if index == 0 => home(part, span, scope),
            Piece::Verbatim(part) => Ok((*part).to_owned()),
            Piece::Open(at) => {
                let place = scope.within(span, &(*at..*at + 2));
                let mistake = scope.mistake("bad-reference", place, "this `${` is never closed".to_owned());
                Err(vec![mistake.help("close it with `}`, or write `$${` for a plain `${`")])
            }
            Piece::Reference(name, place) => match name.strip_prefix("ENV:") {
                Some(variable) => environment(variable, place, span, scope),
                None => parameter(name, place, span, scope).and_then(|value| {
                    if let (0, Resolved::Text { folder: theirs, .. }) = (index, value) {
                        folder.clone_from(theirs);
                    }
                    part_of_text(value).ok_or_else(|| {
                        let message = format!("`${{{name}}}` is {} and cannot stand within a text", value.shown());
                        vec![scope.mistake("wrong-type", scope.within(span, place), message)]
                    })
                }),
            },
        };
        match part {
            Ok(part) => filled.push_str(&part),
            Err(more) => {
                sound = false;
                mistakes.extend(more);
            }
        }
    }
    if sound { Ok(Resolved::Text { text: filled, folder }) } else { Err(mistakes) }
}

fn parameter<'a>(
    name: &str,
    place: &Range<usize>,
    span: Span,
    scope: &'a Scope,
) -> Result<&'a Resolved, Vec<Diagnostic>> {
    match scope.values.get(name) {
        Some(Some(value)) => Ok(value),
        Some(None) => Err(Vec::new()),
        None => {
            let known = scope.values.keys().map(String::as_str);
            let help = nearest_or_all("parameters of this graph", name, known)
                .unwrap_or_else(|| "this graph has no `params`; write `$${` for a plain `${`".to_owned());
            let message = format!("there is no parameter `{name}`");
            Err(vec![scope.mistake("unknown-parameter", scope.within(span, place), message).help(help)])
        }
    }
}

fn environment(name: &str, place: &Range<usize>, span: Span, scope: &Scope) -> Result<String, Vec<Diagnostic>> {
    if let Some(value) = scope.environment.get(name) {
        return Ok(value.to_owned());
    }
    let near = crate::document::did_you_mean(name, scope.environment.names());
    let help = near.map_or_else(|| format!("set it: export {name}=…"), |near| format!("did you mean `{near}`?"));
    let message = format!("the environment variable `{name}` is not set");
    Err(vec![scope.mistake("unset-variable", scope.within(span, place), message).help(help)])
}

/// The beginning of a text, with `~` or `~/` as the home folder.
fn home(beginning: &str, span: Span, scope: &Scope) -> Result<String, Vec<Diagnostic>> {
    match beginning.strip_prefix('~') {
        Some(rest) if rest.is_empty() || rest.starts_with('/') => {
            environment("HOME", &(0..1), span, scope).map(|home| home.trim_end_matches('/').to_owned() + rest)
        }
        _ => Ok(beginning.to_owned()),
    }
}

/// A value as part of a longer text; `None` for lists, maps and the like.
fn part_of_text(value: &Resolved) -> Option<String> {
    match value {
        Resolved::Text { text, .. } => Some(text.clone()),
        Resolved::Integer(number) => Some(number.to_string()),
        Resolved::Number(number) => Some(number.to_string()),
        Resolved::Bool(value) => Some(value.to_string()),
        Resolved::Nothing | Resolved::List(_) | Resolved::Map(_) | Resolved::Variant(..) => None,
    }
}

/// Fills in a text that must stay one, such as the file of a nested graph: the text, and the folder it is relative to.
///
/// # Errors
/// As [`resolve`], and where it becomes something else than a text.
pub fn resolve_name(text: &Spanned<String>, scope: &Scope) -> Result<(String, PathBuf), Vec<Diagnostic>> {
    match resolve_text(&text.value, text.span, scope)? {
        Resolved::Text { text, folder } => Ok((text, folder)),
        other => {
            let message = format!("expected a string, found {}", other.shown());
            Err(vec![scope.mistake("wrong-type", Some(text.span), message)])
        }
    }
}
