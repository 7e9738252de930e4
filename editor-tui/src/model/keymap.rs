//! Which key does what: a RON file of names of keys, by where they are pressed.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use std::collections::BTreeMap;

/// The keys that the editor comes with.
pub const DEFAULT: &str = include_str!("keymap.ron");

/// A key with its modifiers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key {
    code: KeyCode,
    modifiers: KeyModifiers,
}

impl Key {
    /// The key of an event; Shift counts only where the letter does not tell it.
    pub fn of(event: &KeyEvent) -> Self {
        let mut modifiers = event.modifiers;
        if matches!(event.code, KeyCode::Char(_)) || event.code == KeyCode::BackTab {
            modifiers.remove(KeyModifiers::SHIFT);
        }
        Self { code: event.code, modifiers }
    }

    /// Reads `h`, `ctrl-s`, `left`, `space`.
    fn read(text: &str) -> Option<Self> {
        let (modifiers, name) = match text.split_once('-') {
            Some(("ctrl", name)) => (KeyModifiers::CONTROL, name),
            Some(("alt", name)) => (KeyModifiers::ALT, name),
            Some(("shift", name)) => (KeyModifiers::SHIFT, name),
            _ => (KeyModifiers::NONE, text),
        };
        let code = match name {
            "left" => KeyCode::Left,
            "right" => KeyCode::Right,
            "up" => KeyCode::Up,
            "down" => KeyCode::Down,
            "enter" => KeyCode::Enter,
            "esc" => KeyCode::Esc,
            "tab" => KeyCode::Tab,
            "backtab" => KeyCode::BackTab,
            "backspace" => KeyCode::Backspace,
            "delete" => KeyCode::Delete,
            "space" => KeyCode::Char(' '),
            "home" => KeyCode::Home,
            "end" => KeyCode::End,
            "pageup" => KeyCode::PageUp,
            "pagedown" => KeyCode::PageDown,
            _ => {
                let mut letters = name.chars();
                KeyCode::Char(letters.next().filter(|_| letters.next().is_none())?)
            }
        };
        Some(Self { code, modifiers })
    }
}

/// Why a keymap cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum KeymapError {
    /// The text is not what it should be.
    #[error("the keymap cannot be read: {0}")]
    Text(String),
    /// A key has no such name.
    #[error(
        "the keymap names a key `{0}`; write a letter, a name such as `left` or `enter`, or `ctrl-` and one of these"
    )]
    Key(String),
    /// There is no such action.
    #[error("the keymap names an action `{0}`; `?` in the editor lists all of them")]
    Action(String),
}

/// The keys of each place: `canvas`, `form`, `preview`, `curves`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Keymap {
    places: BTreeMap<String, Vec<(Key, String, String)>>,
}

impl Keymap {
    /// The keys that the editor comes with, with those of `own` in their places.
    ///
    /// # Errors
    /// Where `own` cannot be read or names what there is not; `known` are the names of all actions.
    pub fn read(own: Option<&str>, known: &[&str]) -> Result<Self, KeymapError> {
        let mut map = Self::default();
        for text in [Some(DEFAULT), own].into_iter().flatten() {
            let places: BTreeMap<String, BTreeMap<String, String>> =
                ron::from_str(text).map_err(|error| KeymapError::Text(error.to_string()))?;
            for (place, keys) in places {
                let bound = map.places.entry(place).or_default();
                for (name, action) in keys {
                    let key = Key::read(&name).ok_or_else(|| KeymapError::Key(name.clone()))?;
                    if !known.contains(&action.as_str()) {
                        return Err(KeymapError::Action(action));
                    }
                    bound.retain(|(other, _, _)| *other != key);
                    bound.push((key, name, action));
                }
            }
        }
        Ok(map)
    }

    /// The action of `key` at `place`.
    pub fn action(&self, place: &str, key: Key) -> Option<&str> {
        let found = |place: &str| self.places.get(place)?.iter().find(|(known, _, _)| *known == key);
        found(place).or_else(|| found("anywhere")).map(|(_, _, action)| action.as_str())
    }

    /// The names of the keys that do `action`, by place.
    pub fn keys_of(&self, action: &str) -> Vec<(&str, &str)> {
        let mut found = Vec::new();
        for (place, keys) in &self.places {
            found.extend(
                keys.iter().filter(|(_, _, known)| known == action).map(|(_, name, _)| (place.as_str(), name.as_str())),
            );
        }
        found
    }
}
