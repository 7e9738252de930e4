//! How far each region is off along the frames that show: a row of bars each, all on one scale.

use super::curves::Window;
use super::theme::Theme;
use super::{cut, put};
use crate::model::curves::{CurveWork, Desk, region_title, regions};
use crate::model::status::Standing;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;

const BARS: [&str; 8] = ["▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"];

/// The rows that errors take of a part of the screen.
pub fn rows(desk: &Desk, height: u16) -> u16 {
    let all = regions(desk).len() as u16;
    if all == 0 { 0 } else { (all + 1).min(height * 2 / 5) }
}

/// Draws them, beginning with a line that says what they are; the bars begin after `names` columns.
pub fn draw(work: &CurveWork, desk: &Desk, theme: Theme, window: Window, area: Rect, names: u16, buffer: &mut Buffer) {
    let (Some(errors), true) = (&desk.errors, area.height > 1) else { return };
    let rows = regions(desk);
    let (x, y) = (i32::from(area.x), i32::from(area.y));
    let columns: Vec<Option<usize>> = rows.iter().map(|name| errors.index(name)).collect();
    let all =
        (0..errors.frames()).flat_map(|frame| columns.iter().flatten().map(move |column| errors.frame(frame)[*column]));
    let most = all.filter(|error| error.is_finite()).fold(f32::MIN_POSITIVE, f32::max);
    let title = format!(
        "mm off by region, at most {most:.2}; n goes to the worst of `{}`",
        work.region_name().map_or("", region_title)
    );
    put(buffer, area, x, y, &cut(&title, usize::from(area.width)), theme.faint());
    let room = usize::from(area.height) - 1;
    let top = (work.region + 1).saturating_sub(room);
    let mut cells: Vec<Vec<usize>> = vec![Vec::new(); usize::from(area.width - names)];
    for frame in window.start..(window.start + window.shown).min(errors.frames()) {
        if let Some(cell) = cells.get_mut((window.column(frame) / 2) as usize) {
            cell.push(frame);
        }
    }
    for (at, name) in rows.iter().enumerate().skip(top).take(room) {
        let y = y + 1 + (at - top) as i32;
        let Some(column) = columns[at] else { continue };
        let style = if at == work.region { theme.accent() } else { theme.soft() };
        put(buffer, area, x, y, if at == work.region { "›" } else { " " }, style);
        let here = errors.frame(work.frame)[column];
        let number = if here < 10.0 { format!("{here:.2}") } else { format!("{here:.1}") };
        put(buffer, area, x + 1, y, &cut(region_title(name), usize::from(names) - 7), style);
        put(buffer, area, x + i32::from(names) - 5, y, &number, theme.text());
        let mut last = f32::NAN;
        for (place, frames) in cells.iter().enumerate() {
            // Where frames are farther apart than cells, what is between looks as the one before.
            let worst = frames.iter().map(|frame| errors.frame(*frame)[column]).fold(f32::NAN, f32::max);
            let shown = if frames.is_empty() { last } else { worst };
            last = shown;
            if !shown.is_finite() {
                continue;
            }
            let share = (shown / most).clamp(0.0, 1.0);
            let standing = match share {
                share if share < 0.4 => Standing::Clean,
                share if share < 0.7 => Standing::Stale,
                _ => Standing::Failed,
            };
            let style = if frames.contains(&work.frame) { theme.accent() } else { theme.of_standing(standing, 0).1 };
            let bar = BARS[((share * 7.0).round() as usize).min(7)];
            put(buffer, area, x + i32::from(names) + place as i32, y, bar, style);
        }
    }
}
