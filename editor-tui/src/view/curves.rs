//! Curve work: the chosen channel with its keys over the solve, and beneath it, along the same frames, how far each region is off.

use super::chart::{Dots, range};
use super::theme::Theme;
use super::{cut, errors, put};
use crate::model::State;
use crate::model::curves::{CurveWork, Desk, key_text};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier};

/// The frames that show, and the columns of dots in which they do.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    /// The first frame, by its position.
    pub start: usize,
    /// How many.
    pub shown: usize,
    width: usize,
}

impl Window {
    /// As many frames as the work asks for, with its frame among them, in `columns` columns of cells.
    fn of(work: &CurveWork, frames: usize, columns: u16) -> Self {
        let shown = if work.span == 0 { frames } else { work.span.min(frames) }.max(1);
        let start = work.frame.saturating_sub(shown / 2).min(frames.saturating_sub(shown));
        Self { start, shown, width: usize::from(columns) * 2 }
    }

    /// The column of dots of a frame that shows.
    pub fn column(self, frame: usize) -> i32 {
        ((frame.saturating_sub(self.start)) * self.width.saturating_sub(1) / (self.shown - 1).max(1)) as i32
    }

    /// Whether a frame shows.
    pub fn shows(self, frame: usize) -> bool {
        (self.start..self.start + self.shown).contains(&frame)
    }
}

/// Draws it.
pub fn draw(state: &State, work: &CurveWork, theme: Theme, area: Rect, buffer: &mut Buffer) {
    for row in area.y..area.bottom() {
        for column in area.x..area.right() {
            buffer[(column, row)].reset();
        }
    }
    let (x, y, width) = (i32::from(area.x), i32::from(area.y), usize::from(area.width));
    put(buffer, area, x, y, &"─".repeat(width), theme.accent());
    let Some(desk) = &work.desk else {
        put(
            buffer,
            area,
            x + 2,
            y,
            &cut(&format!(" {}.{} ", work.of.0, work.of.1), width.saturating_sub(4)),
            theme.text(),
        );
        let waits =
            if state.cooking.is_some() { "the curves are being cooked … (x cancels)" } else { "there are no curves" };
        let text = work.problem.as_deref().unwrap_or(waits);
        let style = if work.problem.is_some() { theme.bad() } else { theme.faint() };
        for (line, text) in super::wrap(text, width.saturating_sub(4)).iter().enumerate() {
            put(buffer, area, x + 2, y + 2 + line as i32, text, style);
        }
        return;
    };
    let keys: usize = work.edits.as_ref().map_or(0, |edits| edits.keys.values().map(Vec::len).sum());
    let file = desk.file.file_name().unwrap_or_default().to_string_lossy();
    let title = format!(" {}  {keys} keys, {} anchors in {file} ", desk.take, work.anchors().len());
    put(buffer, area, x + 2, y, &cut(&title, width.saturating_sub(4)), theme.text());
    if area.height < 4 {
        return;
    }
    let inner = Rect { x: area.x + 1, y: area.y + 1, width: area.width.saturating_sub(2), height: area.height - 1 };
    let names = (inner.width / 4).clamp(8, 24);
    let rows = errors::rows(desk, inner.height);
    let left = Rect { width: names, height: inner.height - rows, ..inner };
    channels(work, desk, theme, left, buffer);
    let right = Rect { x: inner.x + names + 1, width: inner.width.saturating_sub(names + 1), ..inner };
    let plot = Rect { height: right.height.saturating_sub(rows + 2), ..right };
    if plot.width < 2 || plot.height == 0 {
        return;
    }
    let window = Window::of(work, desk.edited.frames(), plot.width);
    chart(work, desk, theme, window, plot, buffer);
    facts(state, work, theme, Rect { y: plot.bottom(), height: 2, ..right }, buffer);
    let strip = Rect { y: plot.bottom() + 2, height: rows, x: inner.x, width: inner.width };
    errors::draw(work, desk, theme, window, strip, names + 1, buffer);
}

/// The channels, with the weight that each has in this frame, and a mark where it has keys.
fn channels(work: &CurveWork, desk: &Desk, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let (names, rows) = (desk.edited.channels(), usize::from(area.height));
    let top = work.channel.saturating_sub(rows / 2).min(names.len().saturating_sub(rows));
    let here = desk.edited.frame(work.frame);
    for (at, name) in names.iter().enumerate().skip(top).take(rows) {
        let (x, y) = (i32::from(area.x), i32::from(area.y) + (at - top) as i32);
        let chosen = at == work.channel;
        let style = if chosen { theme.accent().add_modifier(Modifier::BOLD) } else { theme.soft() };
        put(buffer, area, x, y, if chosen { "›" } else { " " }, style);
        put(buffer, area, x + 1, y, &cut(name, usize::from(area.width) - 6), style);
        if !work.keys_of(name).is_empty() {
            put(buffer, area, x + i32::from(area.width) - 5, y, "◆", theme.key());
        }
        let bar = (here.get(at).copied().unwrap_or(0.0).clamp(0.0, 1.0) * 3.0).round() as usize;
        put(buffer, area, x + i32::from(area.width) - 3, y, &"▪".repeat(bar), style);
    }
}

/// The chosen channel: as it was solved, as it is with its keys, and the keys themselves.
fn chart(work: &CurveWork, desk: &Desk, theme: Theme, window: Window, area: Rect, buffer: &mut Buffer) {
    let mut dots = Dots::new(area);
    let (_, height) = dots.size();
    let frames = window.start..window.start + window.shown;
    let edited = |frame: usize| desk.edited.frame(frame)[work.channel];
    let column = work.channel_name().and_then(|name| desk.solved.index(name));
    let solved = |frame: usize| column.map_or(f32::NAN, |column| desk.solved.frame(frame)[column]);
    let number = |frame: usize| desk.edited.frame_axis().first + frame as i64;
    let both = frames.clone().flat_map(|frame| [f64::from(edited(frame)), f64::from(solved(frame))]);
    let (low, high) = range(both);
    let (low, high) = if high - low < 0.02 { (low - 0.05, low + 0.05) } else { (low, high) };
    let row = |value: f64| ((high - value) / (high - low) * f64::from(height - 1)).round() as i32;
    let point = |frame: usize, value: f32| value.is_finite().then(|| (window.column(frame), row(f64::from(value))));
    dots.upright(window.column(work.frame), theme.accent().fg.unwrap_or(Color::Reset));
    dots.line(frames.clone().map(|frame| point(frame, solved(frame))), theme.faint().fg.unwrap_or(Color::Reset));
    dots.line(frames.map(|frame| point(frame, edited(frame))), theme.of_type("Curves"));
    dots.draw(buffer);
    let (x, y) = (i32::from(area.x), i32::from(area.y));
    let place = |frame: i64| usize::try_from(frame - number(0)).ok().filter(|frame| window.shows(*frame));
    for anchor in work.anchors() {
        if let Some(frame) = place(anchor.frame) {
            put(buffer, area, x + window.column(frame) / 2, i32::from(area.bottom()) - 1, "▲", theme.live());
        }
    }
    for key in work.keys() {
        if let Some(frame) = place(key.frame) {
            let style = if frame == work.frame { theme.key().add_modifier(Modifier::REVERSED) } else { theme.key() };
            let at = row(f64::from(edited(frame))).clamp(0, height - 1);
            put(buffer, area, x + window.column(frame) / 2, y + at / 4, "◆", style);
        }
    }
    let label = |value: f64| format!("{value:.2}");
    put(buffer, area, x, y, &label(high), theme.faint());
    put(buffer, area, x, i32::from(area.bottom()) - 1, &label(low), theme.faint());
}

/// The weight in this frame, as it was solved, and the key; what is wrong, or which frames show.
fn facts(state: &State, work: &CurveWork, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let (x, y, width) = (i32::from(area.x), i32::from(area.y), usize::from(area.width));
    let (edited, solved) = work.weights().unwrap_or((f32::NAN, f32::NAN));
    let name = work.channel_name().unwrap_or_default();
    let key = work.key().map_or_else(String::new, |key| format!("  ◆ {}", key_text(key)));
    let text = format!("{name} {edited:.3} (solved {solved:.3})  frame {}{key}", work.frame_number());
    put(buffer, area, x, y, &cut(&text, width), theme.text());
    let fresh = work.made_of == state.texts.revision;
    let (text, style) = match (&work.edits, &work.problem) {
        (Err(problem), _) | (_, Some(problem)) => (problem.clone(), theme.bad()),
        _ if !fresh => ("the keys are newer than the curves …".to_owned(), theme.live()),
        _ if work.anchors().iter().any(|anchor| anchor.frame == work.frame_number()) => {
            ("▲ this frame is an anchor".to_owned(), theme.live())
        }
        _ => {
            let frames = if work.span == 0 { "all frames".to_owned() } else { format!("{} frames", work.span) };
            (format!("{frames} (z)"), theme.faint())
        }
    };
    put(buffer, area, x, y + 1, &cut(&text, width), style);
}
