//! The keys.

use super::ACTIONS;
use crate::model::{Effect, Overlay, State};
use ratatui::crossterm::event::{KeyCode, KeyEvent};

/// Columns and rows of the help's window at most; its frame takes four and two of them.
pub const HELP_SIZE: (u16, u16) = (92, u16::MAX);
const FRAME: (u16, u16) = (4, 2);
/// Columns that a key and what it does take at least.
const LEAST_WIDTH: u16 = 44;

/// Shows the keys.
pub fn help(state: &mut State) -> Vec<Effect> {
    state.overlay = Overlay::Help(0);
    Vec::new()
}

/// A key while the keys are shown from line `top` on.
pub fn scroll(state: &mut State, top: usize, key: &KeyEvent) {
    let top = match key.code {
        KeyCode::Down | KeyCode::Char('j') => top + 1,
        KeyCode::Up | KeyCode::Char('k') => top.saturating_sub(1),
        KeyCode::PageDown | KeyCode::Char(' ') => top + 10,
        KeyCode::PageUp => top.saturating_sub(10),
        _ => return,
    };
    let room = |of: u16, most: u16, frame: u16| of.saturating_sub(2).min(most).saturating_sub(frame);
    let (width, height) = state.size;
    let (width, height) = (room(width, HELP_SIZE.0, FRAME.0), room(height, HELP_SIZE.1, FRAME.1));
    let (_, _, last) = columns(listed_keys(state).len(), (width, height));
    state.overlay = Overlay::Help(top.min(last));
}

/// In how many columns so many keys stand side by side, how many in each, and the last line that is shown as the first.
pub fn columns(keys: usize, (width, height): (u16, u16)) -> (usize, usize, usize) {
    let columns = usize::from((width / LEAST_WIDTH).max(1));
    let in_each = keys.div_ceil(columns);
    (columns, in_each, in_each.saturating_sub(usize::from(height)))
}

/// The keys that do something here, up to three for each action, and what that is.
pub fn listed_keys(state: &State) -> Vec<(String, &'static str)> {
    // Keys of curve work show there, and all others elsewhere.
    let here = |place: &str| place == "anywhere" || (place == "curves") == state.work.is_some();
    let line = |action: &super::Action| {
        let keys = state.keymap.keys_of(action.name).into_iter().filter(|(place, _)| here(place));
        let mut keys: Vec<&str> = keys.map(|(_, key)| key).collect();
        keys.dedup();
        keys.sort_by_key(|key| key.len());
        keys.dedup();
        (!keys.is_empty()).then(|| (keys[..keys.len().min(3)].join("  "), action.does))
    };
    ACTIONS.iter().filter_map(line).collect()
}
