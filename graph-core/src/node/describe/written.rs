//! Defaults as a graph would write them.

use super::keys::Keys;
use crate::document::Schema;
use serde_json::Value;

/// A default as a graph would write it; the fields of structures in the order of `declared`.
pub(super) fn written(value: &Value, schema: Schema<'_>, declared: &Keys) -> String {
    match value {
        Value::Null => "None".to_owned(),
        Value::Bool(value) => value.to_string(),
        Value::Number(number) => written_number(number),
        Value::String(text) if names(schema).contains(&text.as_str()) => text.clone(),
        Value::String(text) => format!("{text:?}"),
        Value::Array(items) => {
            let of = schema.inner("items").unwrap_or(schema);
            format!("[{}]", items.iter().map(|item| written(item, of, Keys::none())).collect::<Vec<_>>().join(", "))
        }
        Value::Object(entries) => written_object(entries, schema, declared),
    }
}

/// A number that came from 32 bits is written with the digits it was declared with.
fn written_number(number: &serde_json::Number) -> String {
    let wide = number.as_f64().filter(|_| number.is_f64());
    let narrow = wide.map(|wide| wide as f32).filter(|narrow| Some(f64::from(*narrow)) == wide);
    narrow.map_or_else(|| number.to_string(), |narrow| format!("{narrow:?}"))
}

fn written_object(entries: &serde_json::Map<String, Value>, schema: Schema<'_>, declared: &Keys) -> String {
    let variants = schema.alternatives();
    let mut variants = variants.iter().filter_map(|one| one.variant());
    if let (1, Some((name, content))) = (entries.len(), entries.iter().next())
        && let Some((_, inner)) = variants.find(|(variant, _)| variant == name)
    {
        let content = written(content, inner, declared.of(name));
        return if content.starts_with('(') { format!("{name}{content}") } else { format!("{name}({content})") };
    }
    let known = schema.properties();
    let field = |(name, value): (&String, &Value)| {
        let inner = known.iter().find(|(known, _)| known == name).map_or(schema, |(_, inner)| *inner);
        let key = if known.is_empty() { format!("{name:?}") } else { name.clone() };
        format!("{key}: {}", written(value, inner, declared.of(name)))
    };
    let mut entries: Vec<_> = entries.iter().collect();
    entries.sort_by_key(|(name, _)| declared.position(name));
    let fields = entries.into_iter().map(field).collect::<Vec<_>>().join(", ");
    if known.is_empty() { format!("{{{fields}}}") } else { format!("({fields})") }
}

/// The plain variants that a value may name.
fn names(schema: Schema<'_>) -> Vec<&str> {
    let alternatives = schema.alternatives();
    schema.names().into_iter().chain(alternatives.iter().flat_map(|one| one.names())).collect()
}
