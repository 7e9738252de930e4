//! Checks values that may be one of several things: variants of an enum, `None` or a value, untagged alternatives.

use super::check::{Checker, Part};
use super::found;
use super::schema::Schema;
use crate::document::nearest::nearest_or_all;
use crate::document::{Literal, Resolved};
use serde_json::{Map, Value};

impl Checker<'_> {
    /// Checks `part` against `alternatives`, and gives it as JSON.
    pub fn choice(&mut self, alternatives: &[Schema<'_>], part: &Part<'_>, name: &str) -> Value {
        let allows_nothing = alternatives.iter().any(|schema| schema.types().contains(&"null"));
        let is_empty_struct = self.is_unit(part) && alternatives.iter().any(|schema| schema.allows("object"));
        if allows_nothing && *part.value == Resolved::Nothing && !is_empty_struct {
            return Value::Null;
        }
        let plain: Vec<&str> = alternatives.iter().flat_map(|schema| schema.names()).collect();
        let with_content: Vec<_> = alternatives.iter().filter_map(|schema| schema.variant()).collect();
        let others: Vec<_> = alternatives
            .iter()
            .copied()
            .filter(|schema| schema.names().is_empty() && schema.variant().is_none() && schema.types() != ["null"])
            .collect();
        if plain.is_empty() && with_content.is_empty() {
            return self.untagged(&others, part, name);
        }
        let content_of = |variant: &str| with_content.iter().find(|(known, _)| *known == variant);
        match part.value {
            Resolved::Text { text, .. } if plain.contains(&text.as_str()) => Value::from(text.as_str()),
            Resolved::Text { text, .. } if content_of(text).is_some() => {
                let expected = content_of(text).map_or(String::new(), |(_, content)| content.expected(""));
                let message = format!("`{name}`: the variant `{text}` needs content");
                self.report("wrong-type", part.span, message).help = Some(format!("write {text}(…) with {expected}"));
                Value::Null
            }
            Resolved::Variant(variant, content) => {
                let written = match part.written.map(|written| &written.value) {
                    Some(Literal::Variant(_, written)) => Some(&**written),
                    _ => None,
                };
                if let Some((_, schema)) = content_of(variant) {
                    let inner = part.inner(content, written);
                    let content = self.check(*schema, &inner, &format!("{name}.{variant}"));
                    return Value::Object(Map::from_iter([(variant.clone(), content)]));
                }
                if plain.contains(&variant.as_str()) {
                    if **content != Resolved::Nothing {
                        let message = format!("`{name}`: the variant `{variant}` takes no content");
                        self.report("wrong-type", part.span, message).help = Some(format!("write {variant}"));
                    }
                    return Value::from(variant.as_str());
                }
                self.unknown_variant(&plain, &with_content, variant, part, name)
            }
            Resolved::Map(entries) if matches!(entries.as_slice(), [(key, _)] if content_of(key).is_some()) => {
                let written = match part.written.map(|written| &written.value) {
                    Some(Literal::Map(written)) => written.first().map(|(_, value)| value),
                    _ => None,
                };
                let (variant, content) = &entries[0];
                let Some((_, schema)) = content_of(variant) else { return Value::Null };
                let content = self.check(*schema, &part.inner(content, written), &format!("{name}.{variant}"));
                Value::Object(Map::from_iter([(variant.clone(), content)]))
            }
            Resolved::Text { text, .. } if !others.iter().any(|schema| schema.allows("string")) => {
                self.unknown_variant(&plain, &with_content, text, part, name)
            }
            _ if others.iter().any(|schema| may_fit(*schema, part.value)) => self.untagged(&others, part, name),
            _ => self.none_fits(alternatives, part, name),
        }
    }

    fn unknown_variant(
        &mut self,
        plain: &[&str],
        with_content: &[(&str, Schema<'_>)],
        variant: &str,
        part: &Part<'_>,
        name: &str,
    ) -> Value {
        let names = plain.iter().copied().chain(with_content.iter().map(|(name, _)| *name));
        let help = nearest_or_all("variants", variant, names);
        self.report("unknown-variant", part.span, format!("`{name}` has no variant `{variant}`")).help = help;
        Value::Null
    }

    /// Alternatives without names: the first that fits. Where none does, the mistakes of the nearest are noted.
    fn untagged(&mut self, alternatives: &[Schema<'_>], part: &Part<'_>, name: &str) -> Value {
        let mut nearest = None;
        for schema in alternatives.iter().filter(|schema| may_fit(**schema, part.value)) {
            let (value, mistakes) = self.attempt(*schema, part, name);
            if mistakes.is_empty() {
                return value;
            }
            let is_nearer = nearest.as_ref().is_none_or(|least: &Vec<_>| mistakes.len() < least.len());
            if is_nearer {
                nearest = Some(mistakes);
            }
        }
        match (nearest, alternatives) {
            (Some(mistakes), _) => {
                self.mistakes.extend(mistakes);
                Value::Null
            }
            (None, [one]) => {
                self.wrong_type(*one, part, name);
                Value::Null
            }
            (None, _) => self.none_fits(alternatives, part, name),
        }
    }

    fn none_fits(&mut self, alternatives: &[Schema<'_>], part: &Part<'_>, name: &str) -> Value {
        let expected = super::schema::expected_choice(alternatives, name);
        let message = format!("`{name}` must be {expected}, found {}", found(part.value));
        self.report("wrong-type", part.span, message);
        Value::Null
    }
}

/// Whether `value` is of a type that `schema` allows.
fn may_fit(schema: Schema<'_>, value: &Resolved) -> bool {
    match value {
        Resolved::Nothing => ["null", "object", "array"].into_iter().any(|name| schema.allows(name)),
        Resolved::Bool(_) => schema.allows("boolean"),
        Resolved::Integer(_) => schema.allows("integer") || schema.allows("number"),
        Resolved::Number(_) => schema.allows("number"),
        Resolved::Text { .. } => schema.allows("string"),
        Resolved::List(_) => schema.allows("array"),
        Resolved::Map(_) | Resolved::Variant(..) => schema.allows("object"),
    }
}
