//! Drawing: from the state to character cells. Nothing here changes the state.

mod bars;
mod body;
mod canvas;
mod chart;
mod curves;
mod errors;
mod form;
mod grid;
mod help;
mod minimap;
mod overlay;
mod pixels;
mod preview;
mod theme;

pub use pixels::{Look, Pixels, look, pixels};
pub use theme::{Depth, Theme};

use crate::model::State;
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;

/// Where the parts of the screen are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Areas {
    /// The path of open graphs.
    pub top: Rect,
    /// The graph.
    pub canvas: Rect,
    /// The parameters and the manual.
    pub form: Rect,
    /// The value of the selected output; empty where it does not show.
    pub preview: Rect,
    /// The last line.
    pub bottom: Rect,
}

/// Where the parts of the screen are, for the terminal's size.
pub fn areas(state: &State) -> Areas {
    let (columns, rows) = (state.size.0.max(20), state.size.1.max(6));
    let form = (columns * 3 / 10).clamp(30, 52).min(columns / 2);
    let middle = rows - 2;
    let preview = if state.preview_open { (middle * 45 / 100).clamp(5, 26).min(middle / 2 + 1) } else { 0 };
    let left = columns - form;
    Areas {
        top: Rect::new(0, 0, columns, 1),
        canvas: Rect::new(0, 1, left, middle - preview),
        preview: Rect::new(0, 1 + middle - preview, left, preview),
        form: Rect::new(left, 1, form, middle),
        bottom: Rect::new(0, rows - 1, columns, 1),
    }
}

/// Draws everything.
pub fn draw(state: &State, theme: Theme, frame: &mut Frame<'_>) {
    let whole = frame.area();
    let buffer = frame.buffer_mut();
    let areas = areas(state);
    let fits = |area: Rect| area.intersection(whole);
    bars::top(state, theme, fits(areas.top), buffer);
    if let Some(work) = &state.work {
        let middle = Rect { y: areas.form.y, height: areas.form.height, ..areas.top };
        curves::draw(state, work, theme, fits(middle), buffer);
    } else {
        canvas::draw(state, theme, fits(areas.canvas), buffer);
        minimap::draw(state, theme, fits(areas.canvas), buffer);
        form::draw(state, theme, fits(areas.form), buffer);
        if areas.preview.height > 0 {
            preview::draw(state, theme, fits(areas.preview), buffer);
        }
    }
    bars::bottom(state, theme, fits(areas.bottom), buffer);
    let cursor = overlay::draw(state, theme, whole, buffer);
    let (ground, text) = (theme.ground(), theme.text().fg.unwrap_or(Color::Reset));
    for cell in &mut buffer.content {
        cell.bg = if cell.bg == Color::Reset { ground } else { cell.bg };
        cell.fg = if cell.fg == Color::Reset { text } else { cell.fg };
    }
    let in_form = || form::cursor(state, fits(areas.form)).filter(|_| state.work.is_none());
    if let Some(cursor) = cursor.or_else(in_form) {
        frame.set_cursor_position(cursor);
    }
}

/// Writes `text` at a place, cut where the area ends; gives the column after it.
fn put(buffer: &mut Buffer, area: Rect, x: i32, y: i32, text: &str, style: ratatui::style::Style) -> i32 {
    if y < i32::from(area.y) || y >= i32::from(area.bottom()) {
        return x + text.chars().count() as i32;
    }
    let mut at = x;
    for letter in text.chars() {
        let wide = ratatui::text::Span::raw(letter.to_string()).width() as i32;
        if at >= i32::from(area.x) && at + wide <= i32::from(area.right()) {
            let cell = &mut buffer[(at as u16, y as u16)];
            cell.set_char(letter).set_style(style);
        }
        at += wide;
    }
    at
}

/// `text` in at most `width` letters, with `…` where it is cut.
fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut out: String = text.chars().take(width.saturating_sub(1)).collect();
    out.push('…');
    out
}

/// `text` in lines of at most `width` letters, broken between words.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let width = width.max(4);
    let mut lines = Vec::new();
    for paragraph in text.split("\n\n") {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let (have, more) = (line.chars().count(), word.chars().count());
            if have > 0 && have + 1 + more > width {
                lines.push(std::mem::take(&mut line));
            }
            if !line.is_empty() {
                line.push(' ');
            }
            let mut rest = word;
            while line.chars().count() + rest.chars().count() > width {
                let room = width - line.chars().count();
                let end = rest.char_indices().nth(room).map_or(rest.len(), |(at, _)| at);
                line.push_str(&rest[..end]);
                lines.push(std::mem::take(&mut line));
                rest = &rest[end..];
            }
            line.push_str(rest);
        }
        if !line.is_empty() {
            lines.push(line);
        }
    }
    lines
}
