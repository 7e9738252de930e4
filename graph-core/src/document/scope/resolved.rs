//! Values whose `${…}` have been filled in, each text with the folder it is relative to should it name a file.

use crate::document::Literal;
use serde_json::{Map, Value};
use std::path::PathBuf;

/// A parameter's value with everything filled in, except the name of an item (see [`Resolved::for_item`]).
#[derive(Debug, Clone, PartialEq)]
pub enum Resolved {
    /// `None` or `()`.
    Nothing,
    /// `true`, `false`.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// Any other number.
    Number(f64),
    /// A string, or a bare enum variant.
    Text {
        /// The text.
        text: String,
        /// Where a relative path begins: the folder of the graph file that wrote its beginning; empty for the
        /// folder that the program runs in.
        folder: PathBuf,
    },
    /// A list.
    List(Vec<Resolved>),
    /// A map, in the order of the file.
    Map(Vec<(String, Resolved)>),
    /// An enum variant with content.
    Variant(String, Box<Resolved>),
}

impl Resolved {
    /// The value as JSON; a variant is `{"name": content}`, and folders are left out.
    pub fn to_json(&self) -> Value {
        match self {
            Self::Nothing => Value::Null,
            Self::Bool(value) => Value::from(*value),
            Self::Integer(number) => Value::from(*number),
            Self::Number(number) => Value::from(*number),
            Self::Text { text, .. } => Value::from(text.as_str()),
            Self::List(items) => items.iter().map(Self::to_json).collect(),
            Self::Map(entries) => entries.iter().map(|(name, value)| (name.clone(), value.to_json())).collect(),
            Self::Variant(name, content) => Value::Object(Map::from_iter([(name.clone(), content.to_json())])),
        }
    }

    /// The file that a text names.
    pub fn path(&self) -> Option<PathBuf> {
        match self {
            Self::Text { text, folder } => Some(folder.join(text)),
            _ => None,
        }
    }

    /// Whether a text in the value mentions the item's name.
    pub fn mentions_item(&self) -> bool {
        match self {
            Self::Text { text, .. } => mentions_item(text),
            Self::List(items) => items.iter().any(Self::mentions_item),
            Self::Map(entries) => entries.iter().any(|(name, value)| mentions_item(name) || value.mentions_item()),
            Self::Variant(_, content) => content.mentions_item(),
            Self::Nothing | Self::Bool(_) | Self::Integer(_) | Self::Number(_) => false,
        }
    }

    /// The same with `{take}` and `{item}` replaced by the item's name. Other braces (`{a,b}` in patterns) stay.
    #[must_use]
    pub fn for_item(&self, item: &str) -> Self {
        match self {
            Self::Text { text, folder } => Self::Text { text: fill_item(text, item), folder: folder.clone() },
            Self::List(items) => Self::List(items.iter().map(|value| value.for_item(item)).collect()),
            Self::Map(entries) => {
                let filled = |(name, value): &(String, Self)| (fill_item(name, item), value.for_item(item));
                Self::Map(entries.iter().map(filled).collect())
            }
            Self::Variant(name, content) => Self::Variant(name.clone(), Box::new(content.for_item(item))),
            Self::Nothing | Self::Bool(_) | Self::Integer(_) | Self::Number(_) => self.clone(),
        }
    }

    /// The value as messages name it.
    pub fn shown(&self) -> String {
        crate::document::read::shown(&match self {
            Self::Nothing => Literal::Nothing,
            Self::Bool(value) => Literal::Bool(*value),
            Self::Integer(number) => Literal::Integer(*number),
            Self::Number(number) => Literal::Number(*number),
            Self::Text { text, .. } => Literal::Text(text.clone()),
            Self::List(_) => Literal::List(Vec::new()),
            Self::Map(_) => Literal::Map(Vec::new()),
            Self::Variant(name, _) => return format!("`{name}(…)`"),
        })
    }
}

const ITEM_NAMES: [&str; 2] = ["{take}", "{item}"];

fn mentions_item(text: &str) -> bool {
    ITEM_NAMES.iter().any(|name| text.contains(name))
}

fn fill_item(text: &str, item: &str) -> String {
    let mut filled = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = ITEM_NAMES.iter().filter_map(|name| rest.find(name)).min() {
        filled.push_str(&rest[..start]);
        filled.push_str(item);
        rest = &rest[start + ITEM_NAMES[0].len()..];
    }
    filled + rest
}

#[cfg(test)]
mod tests {
    use super::{Resolved, fill_item};
    use serde_json::json;

    #[test]
    fn items_are_filled_once() {
        assert_eq!(fill_item("out/{take}.{item}.csv", "a{take}"), "out/a{take}.a{take}.csv");
        assert_eq!(fill_item("takes/{a,b}/{Take}.c3d", "x"), "takes/{a,b}/{Take}.c3d");
    }

    #[test]
    fn json_of_values() {
        let text = Resolved::Text { text: "x".to_owned(), folder: "/graphs".into() };
        assert_eq!(text.path(), Some("/graphs/x".into()));
        let map = Resolved::Map(vec![("b".to_owned(), text), ("a".to_owned(), Resolved::Nothing)]);
        let value = Resolved::List(vec![Resolved::Variant("v".to_owned(), Box::new(map)), Resolved::Number(0.5)]);
        assert_eq!(value.to_json(), json!([{"v": {"a": null, "b": "x"}}, 0.5]));
    }
}
