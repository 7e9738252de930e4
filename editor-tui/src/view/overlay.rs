//! What lies over everything: the palette, wiring, prompts, questions, help.

use super::theme::Theme;
use super::{cut, help, put, wrap};
use crate::action::{HELP_SIZE, listed_channels, listed_kinds, listed_nodes, listed_wires};
use crate::model::line::Line;
use crate::model::wiring::Fit;
use crate::model::{Ask, Overlay, Question, State};
use graph_core::node::first_sentence;
use ratatui::buffer::Buffer;
use ratatui::layout::{Position, Rect};
use ratatui::style::{Modifier, Style};

/// Draws it; gives where the cursor stands.
pub fn draw(state: &State, theme: Theme, whole: Rect, buffer: &mut Buffer) -> Option<Position> {
    match &state.overlay {
        Overlay::None => None,
        Overlay::Help(top) => {
            let area = window(theme, whole, HELP_SIZE, "keys – esc closes", buffer);
            help::draw(state, theme, area, *top, buffer);
            None
        }
        Overlay::Palette { line, at, fit } => Some(palette(state, theme, whole, (line, *at, fit.as_ref()), buffer)),
        Overlay::Wiring { fit, line, choices, at } => {
            let way = if fit.input { "takes from" } else { "gives to" };
            let title = format!("{}.{} ({}) {way}", fit.card, fit.port.name, fit.port.type_name);
            let rows: Vec<Row> = listed_wires(choices, &line.text)
                .into_iter()
                .map(|choice| Row {
                    name: format!("{}.{}", choice.card, choice.port.name),
                    text: choice.against.clone().unwrap_or_else(|| choice.port.type_name.clone()),
                    style: Style::new().fg(theme.of_type(&choice.port.type_name)),
                    dim: choice.against.is_some(),
                })
                .collect();
            Some(list(theme, whole, &title, line, &rows, *at, "nothing here fits that port", buffer))
        }
        Overlay::Prompt { ask: Ask::Find, line, .. } => {
            let names = listed_nodes(state, &line.text);
            let row =
                |name: &&str| Row { name: (*name).to_owned(), text: String::new(), style: theme.text(), dim: false };
            let rows: Vec<Row> = names.iter().map(row).collect();
            Some(list(theme, whole, "find a node", line, &rows, 0, "no node here is called so", buffer))
        }
        Overlay::Prompt { ask: Ask::Channel, line, .. } => {
            let names = listed_channels(state, &line.text);
            let row =
                |name: &&str| Row { name: (*name).to_owned(), text: String::new(), style: theme.text(), dim: false };
            let rows: Vec<Row> = names.iter().map(row).collect();
            Some(list(theme, whole, "find a channel", line, &rows, 0, "no channel is called so", buffer))
        }
        Overlay::Prompt { ask, line, error } => {
            let title = match ask {
                Ask::Rename(name) => format!("a new name for {name}"),
                Ask::NewName(kind, _) => format!("a name for the new {kind}"),
                Ask::Key => "a weight, or +0.1 to add to the solve".to_owned(),
                Ask::Find | Ask::Channel => String::new(),
            };
            let area = window(theme, whole, (50, 4), &title, buffer);
            let cursor = typed(theme, area, line, buffer);
            if let Some(error) = error {
                put(
                    buffer,
                    area,
                    i32::from(area.x),
                    i32::from(area.y) + 1,
                    &cut(error, usize::from(area.width)),
                    theme.bad(),
                );
            }
            Some(cursor)
        }
        Overlay::Question(question) => {
            ask(theme, whole, question, buffer);
            None
        }
    }
}

struct Row {
    name: String,
    text: String,
    style: Style,
    dim: bool,
}

/// A window amid the screen; gives what is within.
fn window(theme: Theme, whole: Rect, size: (u16, u16), title: &str, buffer: &mut Buffer) -> Rect {
    let (width, height) = (size.0.min(whole.width.saturating_sub(2)), size.1.min(whole.height.saturating_sub(2)));
    let x = whole.x + (whole.width - width) / 2;
    let y = whole.y + (whole.height - height) / 3;
    let area = Rect { x, y, width, height };
    for row in area.y..area.bottom() {
        for column in area.x..area.right() {
            buffer[(column, row)].reset();
        }
    }
    buffer.set_style(area, theme.panel());
    let inner = usize::from(width.saturating_sub(2));
    let edge = theme.accent();
    let (left, top) = (i32::from(x), i32::from(y));
    put(buffer, area, left, top, &format!("╭{}╮", "─".repeat(inner)), edge);
    for row in 1..i32::from(height) - 1 {
        put(buffer, area, left, top + row, "│", edge);
        put(buffer, area, left + i32::from(width) - 1, top + row, "│", edge);
    }
    put(buffer, area, left, top + i32::from(height) - 1, &format!("╰{}╯", "─".repeat(inner)), edge);
    let title = format!(" {} ", cut(title, inner.saturating_sub(4)));
    put(buffer, area, left + 2, top, &title, theme.text().add_modifier(Modifier::BOLD));
    Rect { x: x + 2, y: y + 1, width: width.saturating_sub(4), height: height.saturating_sub(2) }
}

/// The line that is typed, in the first row of `area`.
fn typed(theme: Theme, area: Rect, line: &Line, buffer: &mut Buffer) -> Position {
    let x = put(buffer, area, i32::from(area.x), i32::from(area.y), "› ", theme.accent());
    let before = line.text[..line.cursor].chars().count();
    let room = usize::from(area.width).saturating_sub(3);
    let skip = before.saturating_sub(room);
    let shown: String = line.text.chars().skip(skip).take(room).collect();
    put(buffer, area, x, i32::from(area.y), &shown, theme.text());
    Position { x: (x as u16) + (before - skip) as u16, y: area.y }
}

#[allow(clippy::too_many_arguments, reason = "a list is drawn in one way from all of these")]
fn list(
    theme: Theme,
    whole: Rect,
    title: &str,
    line: &Line,
    rows: &[Row],
    at: usize,
    none: &str,
    buffer: &mut Buffer,
) -> Position {
    let area = window(theme, whole, (78, 18), title, buffer);
    let cursor = typed(theme, area, line, buffer);
    let room = usize::from(area.height.saturating_sub(2));
    let top = (at + 1).saturating_sub(room);
    if rows.is_empty() {
        put(buffer, area, i32::from(area.x), i32::from(area.y) + 2, none, theme.faint());
    }
    for (position, row) in rows.iter().enumerate().skip(top).take(room) {
        let y = area.y + 2 + (position - top) as u16;
        if position == at {
            buffer.set_style(Rect { y, height: 1, ..area }, theme.chosen());
        }
        let style = if row.dim { theme.faint() } else { row.style };
        let x = put(buffer, area, i32::from(area.x), i32::from(y), &cut(&row.name, 34), style);
        let x = (x + 2).max(i32::from(area.x) + 26);
        let room = (i32::from(area.right()) - x).max(0) as usize;
        put(buffer, area, x, i32::from(y), &cut(&row.text, room), theme.faint());
    }
    cursor
}

fn palette(
    state: &State,
    theme: Theme,
    whole: Rect,
    (line, at, fit): (&Line, usize, Option<&Fit>),
    buffer: &mut Buffer,
) -> Position {
    let title = match fit {
        Some(fit) if fit.input => format!("add a node that gives {}", fit.port.type_name),
        Some(fit) => format!("add a node that takes {}", fit.port.type_name),
        None => "add a node".to_owned(),
    };
    let kinds = listed_kinds(state, &line.text, fit);
    let rows: Vec<Row> = kinds
        .iter()
        .map(|kind| {
            let gives = kind.outputs.first().map(|port| theme.of_type(port.kind.name));
            let style = gives.map_or(theme.text(), |colour| Style::new().fg(colour));
            Row { name: kind.manual.name.clone(), text: first_sentence(&kind.manual.doc), style, dim: false }
        })
        .collect();
    list(theme, whole, &title, line, &rows, at, "no kind is called so", buffer)
}

fn ask(theme: Theme, whole: Rect, question: &Question, buffer: &mut Buffer) {
    let (title, text, answers): (&str, String, &[(&str, &str)]) = match question {
        Question::Quit => (
            "unsaved edits",
            "Some files were edited and not saved.".to_owned(),
            &[("s", "save and leave"), ("d", "leave without them"), ("c", "stay")],
        ),
        Question::Conflict { file, .. } => (
            "changed on disk",
            format!("{} changed on disk, in lines that were edited here too.", file.display()),
            &[("m", "keep mine, over what is on disk"), ("t", "take theirs; u undoes that")],
        ),
        Question::Journal { operations, .. } => (
            "edits of an editor that was not closed",
            format!(
                "{} edits were not saved, the last: {}.",
                operations.len(),
                operations.last().map_or("", |operation| operation.label.as_str())
            ),
            &[("r", "bring them back"), ("d", "throw them away")],
        ),
    };
    let lines = wrap(&text, 52);
    let area = window(theme, whole, (58, (lines.len() + answers.len() + 3) as u16), title, buffer);
    let (x, mut y) = (i32::from(area.x), i32::from(area.y));
    for line in &lines {
        put(buffer, area, x, y, line, theme.text());
        y += 1;
    }
    y += 1;
    for (key, does) in answers {
        put(buffer, area, x, y, key, theme.accent().add_modifier(Modifier::BOLD));
        put(buffer, area, x + 3, y, does, theme.soft());
        y += 1;
    }
}
