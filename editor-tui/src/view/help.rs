//! The keys, as the keymap has them.

use super::theme::Theme;
use super::{cut, put};
use crate::action::ACTIONS;
use crate::model::State;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Modifier;

/// Draws the keys into `area`, from line `top` on.
pub fn draw(state: &State, theme: Theme, area: Rect, top: usize, buffer: &mut Buffer) {
    let mut lines: Vec<(String, &str)> = Vec::new();
    // Keys of curve work show there, and all others elsewhere.
    let here = |place: &str| place == "anywhere" || (place == "curves") == state.work.is_some();
    for action in ACTIONS {
        let keys = state.keymap.keys_of(action.name).into_iter().filter(|(place, _)| here(place));
        let mut keys: Vec<&str> = keys.map(|(_, key)| key).collect();
        keys.dedup();
        keys.sort_by_key(|key| key.len());
        keys.dedup();
        if !keys.is_empty() {
            lines.push((cut(&keys[..keys.len().min(3)].join("  "), 18), action.does));
        }
    }
    let columns = usize::from((area.width / 44).max(1));
    let per_column = lines.len().div_ceil(columns);
    let room = usize::from(area.height);
    let top = top.min(per_column.saturating_sub(room));
    let width = i32::from(area.width) / columns as i32;
    for (at, (keys, does)) in lines.iter().enumerate() {
        let (column, row) = (at / per_column, at % per_column);
        if row < top || row - top >= room {
            continue;
        }
        let (x, y) = (i32::from(area.x) + column as i32 * width, i32::from(area.y) + (row - top) as i32);
        put(buffer, area, x, y, keys, theme.accent().add_modifier(Modifier::BOLD));
        put(buffer, area, x + 19, y, &cut(does, (width - 20).max(4) as usize), theme.soft());
    }
}
