//! The keys, as the keymap has them.

use super::theme::Theme;
use super::{cut, put};
use crate::action::{columns, listed_keys};
use crate::model::State;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Modifier;

/// Draws the keys into `area`, from line `top` on.
pub fn draw(state: &State, theme: Theme, area: Rect, top: usize, buffer: &mut Buffer) {
    let lines = listed_keys(state);
    let (columns, per_column, last) = columns(lines.len(), (area.width, area.height));
    let (room, top) = (usize::from(area.height), top.min(last));
    let width = i32::from(area.width) / columns as i32;
    for (at, (keys, does)) in lines.iter().enumerate() {
        let (column, row) = (at / per_column, at % per_column);
        if row < top || row - top >= room {
            continue;
        }
        let (x, y) = (i32::from(area.x) + column as i32 * width, i32::from(area.y) + (row - top) as i32);
        put(buffer, area, x, y, &cut(keys, 18), theme.accent().add_modifier(Modifier::BOLD));
        put(buffer, area, x + 19, y, &cut(does, (width - 20).max(4) as usize), theme.soft());
    }
}
