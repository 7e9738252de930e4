//! Holds parameters against a kind's schema, part by part, and gives them as JSON.

use super::found;
use super::schema::Schema;
use crate::document::nearest::nearest_or_all;
use crate::document::{Diagnostic, Literal, Resolved, Source, Span, Spanned};
use serde_json::{Map, Value};
use std::sync::Arc;

/// A part of a parameter's value: what it is, and how and where it is written.
pub(super) struct Part<'a> {
    pub value: &'a Resolved,
    /// As written; `None` where it came in through `${…}` or the command line.
    pub written: Option<&'a Spanned<Literal>>,
    /// Where it is written, or what holds it.
    pub span: Span,
}

impl<'a> Part<'a> {
    /// A part of this part; `written` is where it is written, where that is known.
    pub fn inner(&self, value: &'a Resolved, written: Option<&'a Spanned<Literal>>) -> Self {
        Part { value, written, span: written.map_or(self.span, |written| written.span) }
    }
}

/// Walks a value and its schema side by side.
pub(super) struct Checker<'a> {
    schema: &'a Value,
    source: &'a Arc<Source>,
    /// The text of `--set` that the checked value comes from.
    pub command_line: Option<String>,
    /// All mistakes so far.
    pub mistakes: Vec<Diagnostic>,
}

impl<'a> Checker<'a> {
    /// A checker against the schema of a kind; `source` is where parameters are written.
    pub fn new(schema: &'a Value, source: &'a Arc<Source>) -> Self {
        Self { schema, source, command_line: None, mistakes: Vec::new() }
    }

    /// The schema of the kind.
    pub fn root(&self) -> Schema<'a> {
        Schema::root(self.schema)
    }

    /// Notes a mistake at `span`, or at the command line's text.
    pub fn report(&mut self, code: &'static str, span: Span, message: String) -> &mut Diagnostic {
        let mistake = match &self.command_line {
            Some(text) => Diagnostic::new(code, format!("`--set {text}`: {message}")),
            None => Diagnostic::at(code, self.source, span, message),
        };
        let index = self.mistakes.len();
        self.mistakes.push(mistake);
        &mut self.mistakes[index]
    }

    /// Notes that `part` is not what is expected of the parameter `name`.
    pub fn wrong(&mut self, code: &'static str, part: &Part<'_>, name: &str, expected: &str) -> &mut Diagnostic {
        let message = format!("`{name}` must be {expected}, found {}", found(part.value));
        let stands_for = match part.written.map(|written| &written.value) {
            Some(Literal::Text(text)) if !matches!(part.value, Resolved::Text { text: same, .. } if same == text) => {
                Some(format!("{text} stands for {}", found(part.value)))
            }
            _ => None,
        };
        let mistake = self.report(code, part.span, message);
        if let (Some(label), Some((_, text))) = (stands_for, &mut mistake.place) {
            *text = label;
        }
        mistake
    }

    /// What `check` finds, kept apart from the mistakes so far.
    pub fn attempt(&mut self, schema: Schema<'_>, part: &Part<'_>, name: &str) -> (Value, Vec<Diagnostic>) {
        let before = std::mem::take(&mut self.mistakes);
        let value = self.check(schema, part, name);
        (value, std::mem::replace(&mut self.mistakes, before))
    }

    /// Checks `part`, the value of the parameter `name`, and gives it as JSON. Where mistakes were noted, the JSON is
    /// of no use.
    pub fn check(&mut self, schema: Schema<'_>, part: &Part<'_>, name: &str) -> Value {
        if !schema.alternatives().is_empty() && schema.properties().is_empty() {
            return self.choice(&schema.alternatives(), part, name);
        }
        if !schema.names().is_empty() {
            return self.choice(&[schema], part, name);
        }
        if let [one] = schema.list("allOf").as_slice() {
            return self.check(*one, part, name);
        }
        let types = schema.types();
        let allows = |name: &str| types.is_empty() || types.contains(&name);
        match part.value {
            Resolved::Number(number) if !number.is_finite() => {
                self.wrong("out-of-range", part, name, "a finite number");
            }
            _ if types.is_empty() && schema.properties().is_empty() => {}
            Resolved::Nothing if allows("null") => {}
            Resolved::Nothing if allows("object") && self.is_unit(part) => {
                let empty = Part { value: &Resolved::Map(Vec::new()), ..*part };
                return self.object(schema, &empty, name);
            }
            Resolved::Nothing if allows("array") && self.is_unit(part) => {
                return self.array(schema, &Part { value: &Resolved::List(Vec::new()), ..*part }, name);
            }
            Resolved::Bool(_) if allows("boolean") => {}
            Resolved::Integer(number) if allows("integer") || allows("number") => {
                self.range(schema, *number as f64, part, name);
            }
            Resolved::Number(number) if allows("number") => self.range(schema, *number, part, name),
            Resolved::Text { text, .. } if allows("string") => {
                let count = text.chars().count() as u64;
                let bound = |key: &str| schema.get(key).and_then(Value::as_u64);
                let fits = bound("minLength").is_none_or(|least| count >= least)
                    && bound("maxLength").is_none_or(|most| count <= most);
                if !fits {
                    let expected = schema.expected(name);
                    self.wrong("out-of-range", part, name, &expected);
                }
            }
            Resolved::List(_) if allows("array") => return self.array(schema, part, name),
            Resolved::Map(_) if allows("object") => return self.object(schema, part, name),
            _ => self.wrong_type(schema, part, name),
        }
        part.value.to_json()
    }

    /// Notes a value of a wrong type, with the cure where it is near.
    pub fn wrong_type(&mut self, schema: Schema<'_>, part: &Part<'_>, name: &str) {
        let help = match part.value {
            Resolved::Number(number) if schema.allows("integer") => {
                Some(format!("write {} or {}", number.floor(), number.ceil()))
                    .filter(|_| number.fract() != 0.0)
                    .or_else(|| Some(format!("write {number}")))
            }
            Resolved::Text { text, .. } if schema.allows("number") && text.parse::<f64>().is_ok() => {
                Some(format!("write {text} without quotes"))
            }
            Resolved::Text { text, .. } if schema.allows("boolean") && text.parse::<bool>().is_ok() => {
                Some(format!("write {text} without quotes"))
            }
            Resolved::Integer(number) if schema.allows("string") => Some(format!("write \"{number}\"")),
            _ if schema.allows("array") => Some("write [ ] around it for a list of one".to_owned())
                .filter(|_| !matches!(part.value, Resolved::Map(_) | Resolved::Nothing | Resolved::Variant(..))),
            _ => None,
        };
        let expected = schema.expected(name);
        self.wrong("wrong-type", part, name, &expected).help = help;
    }

    /// Whether `part` is written as `()`, which may be a struct or a list without anything in it.
    pub fn is_unit(&self, part: &Part<'_>) -> bool {
        let text = self.source.text.get(part.span.start..);
        part.written.is_some() && text.is_some_and(|text| text.starts_with('('))
    }

    fn range(&mut self, schema: Schema<'_>, number: f64, part: &Part<'_>, name: &str) {
        let (least, most) = schema.bounds();
        let too_small = least.is_some_and(|(least, open)| number < least || (open && number <= least));
        let too_large = most.is_some_and(|(most, open)| number > most || (open && number >= most));
        if too_small || too_large {
            let expected = schema.expected(name);
            self.wrong("out-of-range", part, name, &expected);
        }
    }

    fn array(&mut self, schema: Schema<'_>, part: &Part<'_>, name: &str) -> Value {
        let Resolved::List(items) = part.value else { return Value::Null };
        let written = match part.written.map(|written| &written.value) {
            Some(Literal::List(written)) if written.len() == items.len() => Some(written),
            _ => None,
        };
        let bound = |key: &str| schema.get(key).and_then(Value::as_u64);
        let count = items.len() as u64;
        if bound("minItems").is_some_and(|least| count < least) || bound("maxItems").is_some_and(|most| count > most) {
            let message = format!("`{name}` must be {}, found {count}", schema.expected(name));
            self.report("out-of-range", part.span, message);
        }
        let first = schema.list("prefixItems");
        let rest = schema.inner("items");
        let checked = items.iter().enumerate().map(|(index, item)| {
            let inner = part.inner(item, written.map(|written| &written[index]));
            match first.get(index).copied().or(rest) {
                Some(schema) => self.check(schema, &inner, &format!("{name}[{index}]")),
                None => item.to_json(),
            }
        });
        checked.collect()
    }

    fn object(&mut self, schema: Schema<'_>, part: &Part<'_>, name: &str) -> Value {
        let Resolved::Map(entries) = part.value else { return Value::Null };
        let written = match part.written.map(|written| &written.value) {
            Some(Literal::Map(written)) if written.len() == entries.len() => Some(written),
            _ => None,
        };
        let known = schema.properties();
        let of_pattern = schema.get("patternProperties").and_then(Value::as_object).and_then(|p| p.values().next());
        let others = schema.inner("additionalProperties").filter(|schema| schema.get("not").is_none());
        let others = of_pattern.map(|pattern| schema.at(pattern)).or(others);
        let is_closed = schema.get("additionalProperties").is_none_or(|more| more.as_bool() == Some(false))
            && of_pattern.is_none()
            && (!known.is_empty() || schema.get("additionalProperties").is_some());
        let mut values = Map::new();
        for (index, (key, value)) in entries.iter().enumerate() {
            let (key_span, value_written) =
                written.map_or((part.span, None), |written| (written[index].0.span, Some(&written[index].1)));
            let inner = part.inner(value, value_written);
            let inner_name = format!("{name}.{key}");
            if let Some(names) = schema.inner("propertyNames").map(Schema::names).filter(|names| !names.is_empty())
                && !names.contains(&key.as_str())
            {
                let help = nearest_or_all("names", key, names);
                self.report("unknown-name", key_span, format!("`{name}` knows no `{key}`")).help = help;
            }
            let property = known.iter().find(|(known, _)| known == key).map(|(_, property)| *property);
            let value = match property.or(others.filter(|_| !is_closed)) {
                Some(property) => self.check(property, &inner, &inner_name),
                None if is_closed => {
                    let help = nearest_or_all("fields", key, known.iter().map(|(name, _)| *name));
                    self.report("unknown-parameter", key_span, format!("`{name}` has no field `{key}`")).help = help;
                    continue;
                }
                None => value.to_json(),
            };
            values.insert(key.clone(), value);
        }
        for missing in schema.required().filter(|name| !entries.iter().any(|(key, _)| key == name)) {
            let expected = known.iter().find(|(known, _)| *known == missing).map(|(_, field)| field.expected(missing));
            self.report("missing-parameter", part.span, format!("`{name}` needs the field `{missing}`")).help =
                expected.map(|expected| format!("add `{missing}`: {expected}"));
        }
        Value::Object(values)
    }
}
