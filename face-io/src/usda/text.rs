//! Values as the text of USD layers spells them.

use glam::Vec3;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write;

/// The shortest number that reads back as the same 32 bits.
pub(super) fn float(number: f32) -> String {
    // Rust writes small numbers out in full, others with an exponent; USD reads both.
    if number != 0.0 && (number.abs() < 1e-4 || number.abs() >= 1e15) {
        format!("{number:e}")
    } else {
        format!("{number}")
    }
}

pub(super) fn point(point: Vec3) -> String {
    let [x, y, z] = point.to_array().map(float);
    format!("({x}, {y}, {z})")
}

pub(super) fn points(points: &[Vec3]) -> String {
    list(points.iter(), |one| point(*one))
}

/// Items with commas between them.
pub(super) fn list<T, S: AsRef<str>>(items: impl Iterator<Item = T>, text: impl Fn(T) -> S) -> String {
    let mut out = String::new();
    for (index, item) in items.enumerate() {
        if index > 0 {
            out.push_str(", ");
        }
        out.push_str(text(item).as_ref());
    }
    out
}

/// The matrix of a joint that stands at a place, unturned. USD writes matrices for row vectors: the place comes last.
pub(super) fn standing_at(place: Vec3) -> String {
    let [x, y, z] = place.to_array().map(float);
    format!("( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), ({x}, {y}, {z}, 1) )")
}

/// A text in quotes.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for letter in text.chars() {
        match letter {
            '"' | '\\' => {
                out.push('\\');
                out.push(letter);
            }
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            letter if letter.is_control() => out.push(' '),
            letter => out.push(letter),
        }
    }
    out.push('"');
    out
}

/// A name that a prim may have, and that none of `taken` has yet: letters, digits and `_`.
pub(super) fn identifier(name: &str, taken: &mut BTreeSet<String>) -> String {
    let mut plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.is_empty() || plain.starts_with(|first: char| first.is_ascii_digit()) {
        plain.insert(0, '_');
    }
    let numbered = (2..).map(|number| format!("{plain}_{number}"));
    let free = std::iter::once(plain.clone()).chain(numbered).find(|name| !taken.contains(name)).unwrap_or(plain);
    taken.insert(free.clone());
    free
}

/// The entries of a JSON object as those of a dictionary, `depth` levels in. What USD has no type for is kept as JSON
/// text.
pub(super) fn dictionary(value: &Value, depth: usize) -> String {
    let mut out = String::new();
    let indent = "    ".repeat(depth);
    for (name, value) in value.as_object().into_iter().flatten() {
        let name = quoted(name);
        let _ = match value {
            Value::Null => Ok(()),
            Value::Bool(yes) => writeln!(out, "{indent}bool {name} = {}", u8::from(*yes)),
            Value::Number(number) if number.is_i64() => writeln!(out, "{indent}int64 {name} = {number}"),
            Value::Number(number) => writeln!(out, "{indent}double {name} = {number}"),
            Value::String(text) => writeln!(out, "{indent}string {name} = {}", quoted(text)),
            Value::Array(items) if items.iter().all(Value::is_string) => {
                let items = list(items.iter().filter_map(Value::as_str), quoted);
                writeln!(out, "{indent}string[] {name} = [{items}]")
            }
            Value::Array(_) => writeln!(out, "{indent}string {name} = {}", quoted(&value.to_string())),
            Value::Object(_) => {
                writeln!(out, "{indent}dictionary {name} = {{\n{}{indent}}}", dictionary(value, depth + 1))
            }
        };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names_become_identifiers_that_differ() {
        let mut taken = BTreeSet::new();
        let names = ["a+b", "a_b", "a@0.5", "2nd", "", "é"].map(|name| identifier(name, &mut taken));
        assert_eq!(names, ["a_b", "a_b_2", "a_0_5", "_2nd", "_", "__2"]);
    }

    #[test]
    fn dictionaries_keep_what_they_can() {
        let value = serde_json::json!({"a": 1, "b": "x\"y\n", "c": [1, 2], "d": {"e": 0.5, "f": ["g"]}, "h": null});
        let expected = "int64 \"a\" = 1\nstring \"b\" = \"x\\\"y\\n\"\nstring \"c\" = \"[1,2]\"\ndictionary \"d\" = {\n    \
                        double \"e\" = 0.5\n    string[] \"f\" = [\"g\"]\n}\n";
        assert_eq!(dictionary(&value, 0), expected);
    }

    proptest! {
        #[test]
        fn numbers_read_back(number in prop::num::f32::NORMAL | prop::num::f32::SUBNORMAL | prop::num::f32::ZERO) {
            prop_assert_eq!(float(number).parse::<f32>().unwrap().to_bits(), number.to_bits());
        }
    }
}
