//! The order in which a node's parameters are declared: its JSON text keeps it, JSON maps do not.

use crate::node::Node;
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// The names of a node's parameters in the order in which they are declared.
pub(super) fn declared(node: &dyn Node) -> Keys {
    let tagged: Option<Keys> = serde_json::to_string(node).ok().and_then(|text| serde_json::from_str(&text).ok());
    tagged.and_then(|tagged| tagged.0.into_iter().next()).map(|(_, keys)| keys).unwrap_or_default()
}

/// The keys of a JSON object in the order of its text, with those of the objects in it.
#[derive(Debug, Default)]
pub(super) struct Keys(Vec<(String, Keys)>);

static NO_KEYS: Keys = Keys(Vec::new());

impl Keys {
    /// No keys.
    pub fn none() -> &'static Self {
        &NO_KEYS
    }

    /// Position of `name`; unknown names come last.
    pub fn position(&self, name: &str) -> usize {
        self.0.iter().position(|(key, _)| key == name).unwrap_or(usize::MAX)
    }

    /// The keys within `name`.
    pub fn of(&self, name: &str) -> &Self {
        self.0.iter().find(|(key, _)| key == name).map_or(&NO_KEYS, |(_, keys)| keys)
    }
}

impl<'de> Deserialize<'de> for Keys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(KeysVisitor)
    }
}

struct KeysVisitor;

impl<'de> Visitor<'de> for KeysVisitor {
    type Value = Keys;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Keys, A::Error> {
        let mut keys = Vec::new();
        while let Some(entry) = map.next_entry()? {
            keys.push(entry);
        }
        Ok(Keys(keys))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Keys, A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Keys::default())
    }

    fn visit_bool<E>(self, _: bool) -> Result<Keys, E> {
        Ok(Keys::default())
    }

    fn visit_i64<E>(self, _: i64) -> Result<Keys, E> {
        Ok(Keys::default())
    }

    fn visit_u64<E>(self, _: u64) -> Result<Keys, E> {
        Ok(Keys::default())
    }

    fn visit_f64<E>(self, _: f64) -> Result<Keys, E> {
        Ok(Keys::default())
    }

    fn visit_str<E>(self, _: &str) -> Result<Keys, E> {
        Ok(Keys::default())
    }

    fn visit_unit<E>(self) -> Result<Keys, E> {
        Ok(Keys::default())
    }
}
