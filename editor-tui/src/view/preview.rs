//! The value of the selected output.

use super::theme::Theme;
use super::{body, chart, cut, put};
use crate::model::{Focus, State};
use crate::preview::{Picture, Table};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;

/// Draws it.
pub fn draw(state: &State, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let edge = if state.focus == Focus::Preview { theme.accent() } else { theme.faint() };
    let (x, y) = (i32::from(area.x), i32::from(area.y));
    for row in area.y..area.bottom() {
        for column in area.x..area.right() {
            buffer[(column, row)].reset();
        }
    }
    put(buffer, area, x, y, &"─".repeat(usize::from(area.width)), edge);
    let preview = &state.preview;
    let title = preview.of().map_or_else(String::new, |(cell, port)| format!(" {cell}.{port} "));
    let after = put(buffer, area, x + 2, y, &cut(&title, usize::from(area.width) - 4), theme.text());
    let (inner, in_pixels) = (inner(area), super::pixels::look(state, theme).is_some());
    match &preview.value {
        None => {
            let text = match (preview.of(), &state.cooking) {
                (None, _) => "nothing to show",
                (Some(_), None) => "reading …",
                (Some(_), Some(_)) => "shown when the cook is over",
            };
            put(buffer, inner, i32::from(inner.x), i32::from(inner.y) + 1, text, theme.faint());
        }
        Some(Err(problem)) => {
            for (line, text) in super::wrap(problem, usize::from(inner.width)).iter().enumerate() {
                put(buffer, inner, i32::from(inner.x), i32::from(inner.y) + 1 + line as i32, text, theme.soft());
            }
        }
        Some(Ok(picture)) => match &**picture {
            Picture::Curves { first, channels, .. } => chart::curves(preview, (*first, channels), theme, inner, buffer),
            Picture::Body(shown) => {
                if !in_pixels {
                    body::draw(shown, preview, theme, inner, buffer);
                }
                let name = shown.names.get(preview.row).map(|name| format!("{name}  ")).unwrap_or_default();
                let frame = shown.first + preview.frame as i64;
                let text = format!(" {name}frame {frame} of {} ", shown.frames.len());
                put(buffer, area, after + 1, y, &text, theme.faint());
            }
            Picture::Image(_) if in_pixels => {}
            Picture::Image(image) => body::image(image, theme, inner, buffer),
            Picture::Table(shown) => table(shown, preview.row, theme, inner, buffer),
        },
    }
}

/// Where the value itself is drawn.
pub fn inner(area: Rect) -> Rect {
    Rect { x: area.x + 1, y: area.y + 1, width: area.width.saturating_sub(2), height: area.height.saturating_sub(1) }
}

fn table(table: &Table, row: usize, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let (x, y) = (i32::from(area.x), i32::from(area.y));
    put(buffer, area, x, y, &cut(&table.title, usize::from(area.width)), theme.text());
    let room = usize::from(area.height.saturating_sub(1));
    let top = (row + 1).saturating_sub(room);
    let names = table.rows.iter().map(|(name, _, _)| name.chars().count()).max().unwrap_or(0).min(30) as i32;
    for (at, (name, text, share)) in table.rows.iter().enumerate().skip(top).take(room) {
        let y = y + 1 + (at - top) as i32;
        let style = if at == row { theme.accent() } else { theme.soft() };
        put(buffer, area, x, y, &cut(name, 30), style);
        let after = put(buffer, area, x + names + 2, y, text, theme.text());
        if let Some(share) = share {
            let bar = "▆".repeat((share.clamp(0.0, 1.0) * 24.0).round() as usize);
            put(
                buffer,
                area,
                (after + 2).max(x + names + 14),
                y,
                &bar,
                theme.of_standing(crate::model::status::Standing::Clean, 0).1,
            );
        }
    }
}
