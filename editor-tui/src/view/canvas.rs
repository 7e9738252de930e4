//! The graph: cards with ports, and the wires between them.

use super::grid::{Grid, Ink};
use super::theme::Theme;
use super::{cut, put};
use crate::model::board::{CardBox, PortBox, Role};
use crate::model::layout::{Place, Zoom};
use crate::model::status::{Standing, Statuses, Tally};
use crate::model::{Focus, State};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};

/// Draws the board.
pub fn draw(state: &State, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let level = state.level();
    if level.board.cards.is_empty() {
        let text = match state.mistakes.first() {
            Some(mistake) => mistake.message.clone(),
            None => "an empty graph: press a to add a node".to_owned(),
        };
        let style = if state.mistakes.is_empty() { theme.soft() } else { theme.bad() };
        for (line, text) in super::wrap(&text, usize::from(area.width).saturating_sub(4)).iter().enumerate() {
            let y = i32::from(area.y) + i32::from(area.height) / 2 + line as i32;
            put(buffer, area, i32::from(area.x) + 2, y, text, style);
        }
        return;
    }
    wires(state, theme, area, buffer);
    let selected = state.card_at();
    let (left, top) = (level.pan.0 - i32::from(area.x), level.pan.1 - i32::from(area.y));
    for (at, place) in level.layout.places.iter().enumerate() {
        let place = Place { x: place.x - left, y: place.y - top, ..*place };
        let shows = place.x < i32::from(area.right())
            && place.x + place.width > i32::from(area.x)
            && place.y < i32::from(area.bottom())
            && place.y + place.height > i32::from(area.y);
        if shows {
            Card { state, theme, area, at, place, selected: selected == Some(at) }.draw(buffer);
        }
    }
}

fn wires(state: &State, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let level = state.level();
    let (left, top) = level.pan;
    let mut grid = Grid::new(area);
    let selected = state.card_at();
    let (low, high) = (top, top + i32::from(area.height));
    let width = i32::from(area.width);
    for (layer, gap) in level.layout.gaps.iter().enumerate() {
        let next_left = level.layout.gaps.get(layer + 1).map_or(gap.right, |next| next.left);
        if next_left < left || gap.left > left + width {
            continue;
        }
        let ink_of = |from: (usize, usize), strong: bool| {
            let port = &level.board.cards[from.0].outputs[from.1];
            let wire = (from.0 as u32) * 64 + from.1 as u32 + 1;
            Ink { wire, colour: theme.of_type(&port.type_name), strong }
        };
        for (y, from, to) in &gap.passing {
            if (low..high).contains(y) {
                let strong = selected == Some(from.0) || selected == Some(*to);
                grid.level(gap.right - 1 - left, next_left - left, y - top, ink_of(*from, strong));
            }
        }
        for run in &gap.runs {
            let strong_run = selected == Some(run.from.0);
            for (y, to) in &run.to {
                if run.y.min(*y) >= high || run.y.max(*y) < low {
                    continue;
                }
                let ink = ink_of(run.from, strong_run || selected == Some(*to));
                let end = gap.right - 1 - left;
                grid.turning((gap.left - left, run.y - top), run.turn - left, (end, y - top), ink);
            }
        }
    }
    grid.draw(buffer);
}

struct Card<'a> {
    state: &'a State,
    theme: Theme,
    area: Rect,
    at: usize,
    place: Place,
    selected: bool,
}

impl Card<'_> {
    fn draw(&self, buffer: &mut Buffer) {
        let card = &self.state.level().board.cards[self.at];
        match self.state.zoom {
            Zoom::Compact => self.line(card, buffer),
            Zoom::Normal => self.full(card, buffer),
        }
    }

    fn standing(&self, card: &CardBox) -> (Standing, Option<&Tally>) {
        let tally = self.state.statuses.tally(&self.state.path_of(&card.name));
        if self.state.mistake_of(self.at).is_some() {
            return (Standing::Failed, tally);
        }
        let standing = match (&self.state.item, tally) {
            (Some(item), Some(tally)) if tally.items.contains_key(item) => tally.of_item(item),
            (_, tally) => tally.map_or(Standing::Unknown, Tally::standing),
        };
        (standing, tally)
    }

    fn frame_style(&self, standing: Standing) -> Style {
        let focused = self.state.focus == Focus::Canvas;
        match standing {
            _ if self.selected && focused => self.theme.accent().add_modifier(Modifier::BOLD),
            _ if self.selected => self.theme.accent(),
            Standing::Failed => self.theme.bad(),
            Standing::Cooking => self.theme.live(),
            _ => self.theme.faint(),
        }
    }

    fn line(&self, card: &CardBox, buffer: &mut Buffer) {
        let (standing, _) = self.standing(card);
        let (sign, style) = self.theme.of_standing(standing, self.state.beat);
        let name = if self.selected {
            self.theme.accent().add_modifier(Modifier::BOLD | Modifier::REVERSED)
        } else {
            self.theme.text()
        };
        let Place { x, y, width, .. } = self.place;
        let blank = " ".repeat(width as usize);
        put(buffer, self.area, x, y, &blank, Style::new());
        put(buffer, self.area, x + 1, y, sign, style);
        let mark = if matches!(card.role, Role::Nested(..)) { "▸" } else { "" };
        let text = cut(&format!("{}{mark}", card.name), width as usize - 4);
        put(buffer, self.area, x + 3, y, &text, name);
    }

    fn full(&self, card: &CardBox, buffer: &mut Buffer) {
        let (theme, area) = (self.theme, self.area);
        let Place { x, y, width, height, .. } = self.place;
        let (standing, tally) = self.standing(card);
        let own = !matches!(card.role, Role::Inputs | Role::Outputs);
        let frame = self.frame_style(standing);
        let inner = width as usize - 2;
        let blank = " ".repeat(inner);
        let (corner, side) = if card.for_each.is_some() { ("╮", "║") } else { ("╮", "│") };
        put(buffer, area, x, y, &format!("╭{}{corner}", "─".repeat(inner)), frame);
        for row in 1..height - 1 {
            put(buffer, area, x, y + row, "│", frame);
            put(buffer, area, x + 1, y + row, &blank, Style::new());
            put(buffer, area, x + width - 1, y + row, side, frame);
        }
        put(buffer, area, x, y + height - 1, &format!("╰{}╯", "─".repeat(inner)), frame);
        let title = if self.selected { theme.accent() } else { theme.text() }.add_modifier(Modifier::BOLD);
        let mut at = x + 1;
        if own {
            let (sign, style) = theme.of_standing(standing, self.state.beat);
            at = put(buffer, area, at, y, " ", frame);
            at = put(buffer, area, at, y, sign, style);
        }
        let name = match card.role {
            Role::Inputs => "takes".to_owned(),
            Role::Outputs => "gives".to_owned(),
            Role::Nested(..) => format!("{} ▸", card.name),
            Role::Kind(_) => card.name.clone(),
        };
        put(buffer, area, at, y, &format!(" {} ", cut(&name, inner - 5)), title);
        let telling = self.telling(card, standing, tally);
        if !telling.is_empty() {
            let text = format!(" {} ", cut(&telling, inner - 4));
            let style = match standing {
                Standing::Failed => theme.bad(),
                Standing::Cooking => theme.live(),
                _ => theme.faint(),
            };
            put(buffer, area, x + 2, y + height - 1, &text, style);
        }
        self.ports(card, buffer);
    }

    fn ports(&self, card: &CardBox, buffer: &mut Buffer) {
        let (theme, area) = (self.theme, self.area);
        let Place { x, y, width, .. } = self.place;
        let chosen = self.state.level().port.filter(|_| self.selected);
        let rows = card.inputs.len().max(card.outputs.len());
        for row in 0..rows {
            let (input, output) = (card.inputs.get(row), card.outputs.get(row));
            let room = width as usize - 4;
            let lengths = (port_text(input).chars().count(), port_text(output).chars().count());
            // Both names share the row; the longer gives way.
            let left_room = room.saturating_sub(lengths.1 + 1).max(room / 2);
            let left = cut(&port_text(input), if lengths.1 == 0 { room } else { left_room });
            let right = cut(&port_text(output), room.saturating_sub(left.chars().count() + 1));
            let line = y + 1 + row as i32;
            let is_chosen = |input: bool| chosen.is_some_and(|port| port.input == input && port.at == row);
            let name = |input: bool, port: &PortBox| {
                if is_chosen(input) {
                    return theme.accent().add_modifier(Modifier::REVERSED | Modifier::BOLD);
                }
                if port.wired || !input { theme.soft() } else { theme.faint() }
            };
            if let Some(port) = input {
                let open = !port.wired && !port.optional;
                let style = Style::new().fg(theme.of_type(&port.type_name));
                let (sign, style) = match (port.wired, open) {
                    (true, _) => ("●", style),
                    (false, true) => ("○", theme.bad()),
                    (false, false) => ("○", theme.faint()),
                };
                put(buffer, area, x, line, sign, style);
                put(buffer, area, x + 2, line, &left, name(true, port));
            }
            if let Some(port) = output {
                let style = Style::new().fg(theme.of_type(&port.type_name));
                put(buffer, area, x + width - 1, line, if port.wired { "●" } else { "○" }, style);
                let start = x + width - 2 - right.chars().count() as i32;
                put(buffer, area, start, line, &right, name(false, port));
            }
        }
        if rows == 0
            && let Role::Nested(text, _) = &card.role
        {
            put(buffer, area, x + 2, y + 1, &cut(text, width as usize - 4), theme.faint());
        }
    }

    /// What the lower edge tells: progress, the failure, items, the time it took.
    fn telling(&self, card: &CardBox, standing: Standing, tally: Option<&Tally>) -> String {
        let path = self.state.path_of(&card.name);
        let told = self.state.statuses.telling(&path, self.state.item.as_deref()).map(|(_, facts)| facts);
        if standing == Standing::Cooking
            && let Some(facts) = told.filter(|facts| facts.standing == Standing::Cooking)
        {
            let filled = (facts.fraction * 5.0).round().clamp(0.0, 5.0) as usize;
            let bar = format!("{}{}", "━".repeat(filled), "╌".repeat(5 - filled));
            let number = facts.numbers.get("loss").map(|loss| format!(" loss {loss:.4}")).unwrap_or_default();
            return format!("{bar} {:.0}%{number}", facts.fraction * 100.0);
        }
        let total = tally.map_or(0, Tally::total);
        if let (Some(tally), true) = (tally, total > 1) {
            let shares: Vec<String> = Statuses::shares(tally)
                .map(|(standing, count)| format!("{count}{}", self.theme.of_standing(standing, self.state.beat).0))
                .collect();
            let items = tally.items.len();
            let items = if items > 0 { format!("{items} items  ") } else { String::new() };
            return format!("{items}{}", shares.join(" "));
        }
        let kind = match &card.role {
            Role::Kind(kind) => kind.as_str(),
            Role::Nested(file, _) => file.as_str(),
            Role::Inputs | Role::Outputs => return String::new(),
        };
        let seconds = told.and_then(|facts| facts.seconds).map(seconds_text);
        match seconds {
            Some(seconds) if kind.chars().count() + seconds.len() < 19 => format!("{kind} · {seconds}"),
            _ => kind.to_owned(),
        }
    }
}

fn port_text(port: Option<&PortBox>) -> String {
    match port {
        Some(port) if port.list => format!("{}…", port.name),
        Some(port) => port.name.clone(),
        None => String::new(),
    }
}

/// Seconds as people read them.
pub fn seconds_text(seconds: f64) -> String {
    match seconds {
        s if s < 0.0095 => format!("{:.1} ms", s * 1e3),
        s if s < 0.95 => format!("{:.0} ms", s * 1e3),
        s if s < 100.0 => format!("{s:.1} s"),
        s => format!("{:.0} min", s / 60.0),
    }
}
