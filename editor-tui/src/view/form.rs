//! The panel beside the graph: how the node stands, its parameters, and the manual of the chosen one.

use super::canvas::seconds_text;
use super::theme::Theme;
use super::{cut, put, wrap};
use crate::model::board::Role;
use crate::model::fields::Field;
use crate::model::status::Standing;
use crate::model::{Focus, State};
use ratatui::buffer::Buffer;
use ratatui::layout::{Position, Rect};
use ratatui::style::{Modifier, Style};

/// Draws the panel.
pub fn draw(state: &State, theme: Theme, area: Rect, buffer: &mut Buffer) {
    buffer.set_style(area, theme.panel());
    let edge = if state.focus == Focus::Form { theme.accent() } else { theme.faint() };
    for y in area.y..area.bottom() {
        put(buffer, area, i32::from(area.x), i32::from(y), "▏", edge);
    }
    let inner = Rect { x: area.x + 2, width: area.width.saturating_sub(3), ..area };
    let mut pen = Pen { buffer, area: inner, y: i32::from(inner.y) };
    head(state, theme, &mut pen);
    let first = pen.y;
    let fields = state.fields();
    let (top, shown) = window(state, inner, first, fields.len());
    for (at, field) in fields.iter().enumerate().skip(top).take(shown) {
        row(state, theme, &mut pen, at, field);
    }
    if fields.len() > shown {
        pen.line(&format!("  {} of {}", (state.form.at + 1).min(fields.len()), fields.len()), theme.faint());
    }
    pen.y += 1;
    match fields.get(state.form.at).filter(|_| state.focus == Focus::Form) {
        Some(field) => manual(state, theme, &mut pen, field),
        None => about(state, theme, &mut pen),
    }
}

struct Pen<'a> {
    buffer: &'a mut Buffer,
    area: Rect,
    y: i32,
}

impl Pen<'_> {
    fn line(&mut self, text: &str, style: Style) {
        let text = cut(text, usize::from(self.area.width));
        put(self.buffer, self.area, i32::from(self.area.x), self.y, &text, style);
        self.y += 1;
    }

    fn text(&mut self, text: &str, style: Style, most: usize) {
        let lines = wrap(text, usize::from(self.area.width));
        for line in lines.iter().take(most) {
            self.line(line, style);
        }
    }
}

/// Name, kind and standing, in at most six lines.
fn head(state: &State, theme: Theme, pen: &mut Pen<'_>) {
    if state.form.of_graph {
        pen.line(&format!("{}: parameters", state.level().name), theme.text().add_modifier(Modifier::BOLD));
        pen.y += 1;
        return;
    }
    let Some(card) = state.card() else {
        pen.line("nothing is selected", theme.faint());
        return;
    };
    pen.line(&card.name, theme.text().add_modifier(Modifier::BOLD));
    let kind = match &card.role {
        Role::Kind(kind) => kind.clone(),
        Role::Nested(file, _) => format!("graph {file}"),
        Role::Inputs => "what this graph takes".to_owned(),
        Role::Outputs => "what this graph gives".to_owned(),
    };
    pen.line(&kind, theme.soft());
    if let Some(list) = &card.for_each {
        pen.line(&format!("for each of {list}"), theme.soft());
    }
    standing(state, theme, pen);
    pen.y += 1;
}

fn standing(state: &State, theme: Theme, pen: &mut Pen<'_>) {
    if let Some(message) = state.card_at().and_then(|at| state.mistake_of(at)) {
        pen.text(&format!("✗ {message}"), theme.bad(), 5);
        return;
    }
    let Some(path) = state.path() else { return };
    let Some((name, facts)) = state.statuses.telling(&path, state.item.as_deref()) else { return };
    let (sign, style) = theme.of_standing(facts.standing, state.beat);
    let word = match facts.standing {
        Standing::Unknown => "unknown",
        Standing::Clean => "up to date",
        Standing::Waiting => "waits",
        Standing::Stale => "stale",
        Standing::Cooking => "cooking",
        Standing::Skipped => "skipped",
        Standing::Failed => "failed",
    };
    let item = name.split_once('@').map(|(_, item)| format!(" @{item}")).unwrap_or_default();
    let time = facts.seconds.map(|seconds| format!(" · {}", seconds_text(seconds))).unwrap_or_default();
    pen.line(&format!("{sign} {word}{item}{time}"), style);
    if facts.standing == Standing::Cooking {
        let width = usize::from(pen.area.width).min(40);
        if facts.history.len() > 1 {
            pen.line(&super::chart::sparkline(&facts.history, width), theme.live());
        }
        let numbers: Vec<String> = facts.numbers.iter().map(|(name, value)| format!("{name} {value:.5}")).collect();
        pen.line(&format!("{:.0} %  {}", facts.fraction * 100.0, numbers.join("  ")), theme.live());
    }
    if !facts.because.is_empty() {
        let style = if facts.standing == Standing::Failed { theme.bad() } else { theme.faint() };
        pen.text(&facts.because, style, 6);
    }
    if let Some(tally) = state.statuses.tally(&path).filter(|tally| !tally.items.is_empty()) {
        for item in tally.items.keys().take(5) {
            let (sign, style) = theme.of_standing(tally.of_item(item), state.beat);
            let here = state.item.as_ref() == Some(item);
            put(pen.buffer, pen.area, i32::from(pen.area.x) + 2, pen.y, sign, style);
            let name = if here { theme.accent() } else { theme.soft() };
            put(pen.buffer, pen.area, i32::from(pen.area.x) + 4, pen.y, item, name);
            pen.y += 1;
        }
        if tally.items.len() > 5 {
            pen.line(&format!("  … {} items, i goes through them", tally.items.len()), theme.faint());
        }
    }
}

/// Which fields show.
fn window(state: &State, area: Rect, first: i32, count: usize) -> (usize, usize) {
    let room = (i32::from(area.bottom()) - first - 7).max(3) as usize;
    let shown = room.min(count.max(1));
    (state.form.at.saturating_sub(shown.saturating_sub(1)).min(count.saturating_sub(shown)), shown)
}

fn row(state: &State, theme: Theme, pen: &mut Pen<'_>, at: usize, field: &Field) {
    let chosen = state.focus == Focus::Form && state.form.at == at;
    let x = i32::from(pen.area.x);
    let width = usize::from(pen.area.width);
    let names = (width * 9 / 20).clamp(10, 22);
    if chosen {
        let line =
            Rect { x: pen.area.x.saturating_sub(1), y: pen.y.max(0) as u16, width: pen.area.width + 1, height: 1 };
        pen.buffer.set_style(line.intersection(*pen.buffer.area()), theme.chosen());
    }
    let name_style = match (&field.mistake, &field.written) {
        (Some(_), _) => theme.bad(),
        (None, Some(_)) => theme.text(),
        (None, None) => theme.soft(),
    };
    put(pen.buffer, pen.area, x, pen.y, &cut(&field.name, names - 1), name_style);
    let editing = state.form.editing.as_ref().filter(|_| chosen);
    let value_x = x + names as i32;
    let room = width.saturating_sub(names);
    if let Some(line) = editing {
        let text = tail(&line.text, line.cursor, room);
        put(pen.buffer, pen.area, value_x, pen.y, &text, theme.accent().add_modifier(Modifier::UNDERLINED));
    } else {
        let style = match (&field.mistake, &field.written) {
            (Some(_), _) => theme.bad(),
            (None, Some(_)) => theme.accent(),
            (None, None) => theme.faint(),
        };
        let text = field.value().split_whitespace().collect::<Vec<_>>().join(" ");
        put(pen.buffer, pen.area, value_x, pen.y, &cut(&text, room), style);
    }
    pen.y += 1;
}

/// The part of a line that shows in `room` letters with the cursor in it.
fn tail(text: &str, cursor: usize, room: usize) -> String {
    let before = text[..cursor].chars().count();
    text.chars().skip((before + 1).saturating_sub(room)).take(room).collect()
}

fn manual(state: &State, theme: Theme, pen: &mut Pen<'_>, field: &Field) {
    let error = state.form.error.as_ref().or(field.mistake.as_ref());
    if let Some(error) = error {
        pen.text(&format!("✗ {error}"), theme.bad(), 5);
    }
    if !field.type_text.is_empty() {
        pen.text(&field.type_text, theme.soft(), 3);
    }
    if let Some(default) = field.default.as_ref().filter(|_| field.written.is_some()) {
        pen.line(&format!("default {default}"), theme.faint());
    }
    if !field.choices.is_empty() {
        pen.text(&field.choices.join(" · "), theme.soft(), 2);
    }
    pen.y += 1;
    pen.text(&field.doc, theme.soft(), 20);
}

/// What the kind does, its ports, and what stands on its outputs.
fn about(state: &State, theme: Theme, pen: &mut Pen<'_>) {
    let Some(card) = state.card() else { return };
    if let Some(port) = state.level().port {
        let ports = if port.input { &card.inputs } else { &card.outputs };
        if let Some(port_box) = ports.get(port.at) {
            let way = if port.input { "takes" } else { "gives" };
            let list = if port_box.list { format!("[{}]", port_box.type_name) } else { port_box.type_name.clone() };
            pen.line(&format!("{} {way} {list}", port_box.name), Style::new().fg(theme.of_type(&port_box.type_name)));
            pen.text(&meaning(state, card.role.clone(), port.input, &port_box.name), theme.soft(), 4);
            pen.y += 1;
        }
    }
    let path = state.path().unwrap_or_default();
    if let Some((_, facts)) = state.statuses.telling(&path, state.item.as_deref()) {
        for (name, summary) in &facts.outputs {
            pen.text(&format!("{name}: {summary}"), theme.soft(), 2);
        }
    }
    if let Role::Kind(kind) = &card.role
        && let Some(facts) = state.catalogue.get(kind)
    {
        pen.text(&facts.manual.doc, theme.faint(), 12);
    }
}

fn meaning(state: &State, role: Role, input: bool, name: &str) -> String {
    let Role::Kind(kind) = role else { return String::new() };
    let Some(facts) = state.catalogue.get(&kind) else { return String::new() };
    let ports = if input { &facts.manual.inputs } else { &facts.manual.outputs };
    ports.iter().find(|port| port.name == name).map(|port| port.meaning.clone()).unwrap_or_default()
}

/// Where the cursor stands while a value is typed.
pub fn cursor(state: &State, area: Rect) -> Option<Position> {
    let line = state.form.editing.as_ref()?;
    let inner = Rect { x: area.x + 2, width: area.width.saturating_sub(3), ..area };
    // The rows before the fields are as many as are drawn: drawn once more, into nothing.
    let mut nothing = Buffer::empty(area);
    let mut pen = Pen { buffer: &mut nothing, area: inner, y: i32::from(inner.y) };
    head(state, Theme::default(), &mut pen);
    let (top, _) = window(state, inner, pen.y, state.fields().len());
    let width = usize::from(inner.width);
    let names = (width * 9 / 20).clamp(10, 22);
    let before = line.text[..line.cursor].chars().count().min(width.saturating_sub(names + 1));
    let y = pen.y + (state.form.at - top.min(state.form.at)) as i32;
    Some(Position { x: inner.x + (names + before) as u16, y: u16::try_from(y).ok()? })
}
