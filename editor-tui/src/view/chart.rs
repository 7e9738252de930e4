//! Charts in braille dots, two to four in a cell.

use super::put;
use super::theme::Theme;
use crate::preview::Preview;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};

/// A line of bars for a few numbers.
pub fn sparkline(values: &[f64], width: usize) -> String {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let (low, high) = range(values.iter().copied());
    let span = (high - low).max(f64::MIN_POSITIVE);
    let count = values.len().min(width).max(1);
    (0..count)
        .map(|at| {
            let value = values[at * values.len() / count];
            BARS[(((value - low) / span * 7.0).round() as usize).min(7)]
        })
        .collect()
}

/// The least and the greatest number.
pub fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// Dots: two columns and four rows in a cell, with one colour a cell.
pub struct Dots {
    area: Rect,
    cells: Vec<(u8, Color)>,
}

impl Dots {
    /// No dots.
    pub fn new(area: Rect) -> Self {
        Self { area, cells: vec![(0, Color::Reset); usize::from(area.width) * usize::from(area.height)] }
    }

    /// Columns and rows of dots.
    pub fn size(&self) -> (i32, i32) {
        (i32::from(self.area.width) * 2, i32::from(self.area.height) * 4)
    }

    /// Sets a dot.
    pub fn set(&mut self, x: i32, y: i32, colour: Color) {
        const BITS: [[u8; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];
        let (width, height) = self.size();
        if (0..width).contains(&x) && (0..height).contains(&y) {
            let cell = &mut self.cells[(y / 4 * i32::from(self.area.width) + x / 2) as usize];
            cell.0 |= BITS[(x % 2) as usize][(y % 4) as usize];
            cell.1 = colour;
        }
    }

    /// Draws lines through points, broken where there is none.
    pub fn line(&mut self, points: impl Iterator<Item = Option<(i32, i32)>>, colour: Color) {
        let mut last: Option<(i32, i32)> = None;
        for point in points {
            if let Some((x, y)) = point {
                let (from_x, from_y) = last.unwrap_or((x, y));
                let steps = (x - from_x).abs().max((y - from_y).abs()).max(1);
                for step in 0..=steps {
                    self.set(from_x + (x - from_x) * step / steps, from_y + (y - from_y) * step / steps, colour);
                }
            }
            last = point;
        }
    }

    /// Draws a dotted upright line.
    pub fn upright(&mut self, x: i32, colour: Color) {
        for y in (0..self.size().1).step_by(2) {
            self.set(x, y, colour);
        }
    }

    /// Draws the cells that have dots.
    pub fn draw(&self, buffer: &mut Buffer) {
        for (at, (bits, colour)) in self.cells.iter().enumerate().filter(|(_, cell)| cell.0 != 0) {
            let x = self.area.x + (at % usize::from(self.area.width)) as u16;
            let y = self.area.y + (at / usize::from(self.area.width)) as u16;
            let sign = char::from_u32(0x2800 + u32::from(*bits)).unwrap_or(' ');
            buffer[(x, y)].set_char(sign).set_style(Style::new().fg(*colour));
        }
    }
}

/// Channels over frames, the chosen one last and strong, with a playhead.
pub fn curves(
    preview: &Preview,
    (first, channels): (i64, &[(String, Vec<f32>)]),
    theme: Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    let names = (area.width / 4).clamp(8, 22);
    let plot = Rect {
        x: area.x + names + 1,
        width: area.width.saturating_sub(names + 2),
        height: area.height.saturating_sub(1),
        ..area
    };
    let Some((chosen_name, chosen)) = channels.get(preview.row) else { return };
    let rows = usize::from(area.height);
    let top = (preview.row + 1)
        .saturating_sub(rows)
        .max(preview.row.saturating_sub(rows / 2).min(channels.len().saturating_sub(rows)));
    for (at, (name, values)) in channels.iter().enumerate().skip(top).take(rows) {
        let y = i32::from(area.y) + (at - top) as i32;
        let style = if at == preview.row { theme.accent() } else { theme.faint() };
        let here = values.get(preview.frame).copied().unwrap_or(f32::NAN);
        let bar = (here.clamp(0.0, 1.0) * 3.0).round() as usize;
        put(buffer, area, i32::from(area.x), y, &super::cut(name, usize::from(names) - 4), style);
        put(buffer, area, i32::from(area.x) + i32::from(names) - 3, y, &"▪".repeat(bar), style);
    }
    let frames = channels.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    let mut dots = Dots::new(plot);
    let (width, height) = dots.size();
    if width < 4 || frames == 0 {
        return;
    }
    // The chart scrolls where there are more frames than dots.
    let shown = frames.min(width as usize * 2);
    let start = preview.frame.saturating_sub(shown / 2).min(frames - shown);
    let column = |frame: usize| ((frame - start) * (width as usize - 1) / shown.max(2).saturating_sub(1)) as i32;
    let (low, high) = range(chosen.iter().map(|value| f64::from(*value)));
    let (low, high) = if high - low < 1e-9 { (low - 0.5, low + 0.5) } else { (low, high) };
    let row = |value: f32| ((high - f64::from(value)) / (high - low) * f64::from(height - 1)).round() as i32;
    let faint = theme.rgb(69, 71, 90);
    for (_, values) in
        channels.iter().enumerate().filter(|(at, _)| *at != preview.row).take(60).map(|(_, channel)| channel)
    {
        for (frame, value) in values.iter().enumerate().take(start + shown).skip(start) {
            dots.set(column(frame), row(*value).clamp(0, height - 1), faint);
        }
    }
    dots.upright(column(preview.frame.clamp(start, start + shown - 1)), theme.accent().fg.unwrap_or(Color::Reset));
    let point = |(frame, value): (usize, &f32)| value.is_finite().then(|| (column(frame), row(*value)));
    dots.line(chosen.iter().enumerate().take(start + shown).skip(start).map(point), theme.of_type("Curves"));
    dots.draw(buffer);
    let here = chosen.get(preview.frame).copied().unwrap_or(f32::NAN);
    let text = format!("{chosen_name} {here:.3}  frame {}  [{low:.2}, {high:.2}]", first + preview.frame as i64);
    let y = i32::from(area.bottom()) - 1;
    put(buffer, area, i32::from(plot.x), y, &super::cut(&text, usize::from(plot.width)), theme.soft());
}
