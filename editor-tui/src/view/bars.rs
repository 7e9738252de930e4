//! The first line: where one is. The last: how things go, and the keys for what is next.

use super::put;
use super::theme::Theme;
use crate::model::{Focus, State};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Modifier;

/// The path of open graphs, unsaved edits, mistakes, the item.
pub fn top(state: &State, theme: Theme, area: Rect, buffer: &mut Buffer) {
    buffer.set_style(area, theme.panel());
    let y = i32::from(area.y);
    let mut x = put(buffer, area, 1, y, "grimace ", theme.faint());
    for (at, level) in state.trail.iter().enumerate() {
        if at > 0 {
            x = put(buffer, area, x, y, " › ", theme.faint());
        }
        let last = at + 1 == state.trail.len();
        let style = if last { theme.accent().add_modifier(Modifier::BOLD) } else { theme.soft() };
        x = put(buffer, area, x, y, &level.name, style);
    }
    if state.texts.is_unsaved() {
        x = put(buffer, area, x, y, " ●", theme.of_standing(crate::model::status::Standing::Stale, 0).1);
        x = put(buffer, area, x, y, " unsaved", theme.faint());
    }
    if let Some(item) = &state.item {
        x = put(buffer, area, x, y, &format!("  @{item}"), theme.live());
    }
    let right = match state.mistakes.len() {
        0 => format!("{} nodes ", state.level().board.cards.len()),
        1 => "1 mistake (m) ".to_owned(),
        count => format!("{count} mistakes (m) "),
    };
    let start = i32::from(area.right()) - right.chars().count() as i32;
    if start > x {
        put(buffer, area, start, y, &right, if state.mistakes.is_empty() { theme.faint() } else { theme.bad() });
    }
}

/// The cook, the note, or the keys.
pub fn bottom(state: &State, theme: Theme, area: Rect, buffer: &mut Buffer) {
    buffer.set_style(area, theme.panel());
    let y = i32::from(area.y);
    let mut x = 1;
    if let Some(cooking) = &state.cooking {
        let share = cooking.done as f64 / cooking.cells.max(1) as f64;
        let filled = (share * 10.0).clamp(0.0, 10.0) as usize;
        let bar = format!("{}{}", "━".repeat(filled), "╌".repeat(10 - filled));
        let word = if cooking.cancelled { "ending" } else { "cooking" };
        x = put(buffer, area, x, y, &format!("{word} {bar} {}/{}  ", cooking.done, cooking.cells), theme.live());
    }
    if let Some(note) = &state.note {
        let room = usize::from(area.width).saturating_sub(x as usize + 1);
        let text = super::cut(&note.text.replace('\n', " "), room);
        put(buffer, area, x, y, &text, if note.bad { theme.bad() } else { theme.soft() });
        return;
    }
    let hints: &[(&str, &str)] = match state.focus {
        _ if state.form.editing.is_some() => &[("enter", "take"), ("esc", "leave as it was")],
        Focus::Canvas => &[
            ("hjkl", "go"),
            ("enter", "open"),
            ("e", "edit"),
            ("a", "add"),
            ("w", "wire"),
            ("p", "preview"),
            ("r", "cook"),
            ("s", "save"),
            ("?", "keys"),
        ],
        Focus::Form => {
            &[("jk", "go"), ("enter", "edit"), ("space", "switch"), ("d", "default"), ("esc", "graph"), ("?", "keys")]
        }
        Focus::Preview => {
            &[("hl", "scrub"), ("jk", "channel"), ("HJKL", "turn"), ("space", "play"), ("esc", "graph"), ("?", "keys")]
        }
        Focus::Curves => &[
            ("hl", "scrub"),
            ("jk/", "channel"),
            ("+-", "key"),
            ("enter", "type"),
            ("<>", "move"),
            ("d", "del"),
            ("a", "anchor"),
            ("n", "worst"),
            ("esc", "graph"),
            ("?", "keys"),
        ],
    };
    for (key, does) in hints {
        x = put(buffer, area, x, y, key, theme.accent());
        x = put(buffer, area, x, y, &format!(" {does}  "), theme.faint());
    }
}
