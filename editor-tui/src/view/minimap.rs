//! The whole board in a corner, where it is larger than the canvas.

use super::theme::Theme;
use crate::model::State;
use crate::model::status::{Standing, Tally};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

/// Draws it: two rows of the map in one of the screen, the shown part light.
pub fn draw(state: &State, theme: Theme, area: Rect, buffer: &mut Buffer) {
    let level = state.level();
    let layout = &level.layout;
    let fits = layout.width <= i32::from(area.width) && layout.height <= i32::from(area.height);
    if fits || area.width < 44 || area.height < 14 {
        return;
    }
    let (width, height) = ((area.width / 4).min(30), (area.height / 5).clamp(3, 7));
    let map = Rect::new(area.right() - width - 1, area.bottom() - height - 1, width, height);
    // It gives way to the selected card.
    let covered = state.place().is_some_and(|place| {
        let right = place.x + place.width - level.pan.0 + i32::from(area.x);
        let bottom = place.y + place.height - level.pan.1 + i32::from(area.y);
        right >= i32::from(map.x) && bottom >= i32::from(map.y)
    });
    let map = if covered { Rect { x: area.x + 1, ..map } } else { map };
    let (columns, rows) = (f64::from(width), f64::from(height) * 2.0);
    let (whole_x, whole_y) = (f64::from(layout.width.max(1)), f64::from(layout.height.max(1)));
    let spot = |x: i32, y: i32| {
        let x = (f64::from(x) / whole_x * columns).clamp(0.0, columns - 1.0) as usize;
        (x, (f64::from(y) / whole_y * rows).clamp(0.0, rows - 1.0) as usize)
    };
    let shown = (
        spot(level.pan.0, level.pan.1),
        spot(level.pan.0 + i32::from(area.width), level.pan.1 + i32::from(area.height)),
    );
    let (light, dark) = (theme.rgb(58, 60, 82), theme.rgb(30, 30, 46));
    let mut dots = vec![None; usize::from(width) * usize::from(height) * 2];
    let selected = state.card_at();
    for (at, place) in layout.places.iter().enumerate() {
        let (x, y) = spot(place.x + place.width / 2, place.y + place.height / 2);
        let standing = state.statuses.tally(&state.path_of(&level.board.cards[at].name));
        let standing = standing.map_or(Standing::Unknown, Tally::standing);
        let style = if selected == Some(at) { theme.accent() } else { theme.of_standing(standing, 0).1 };
        let dot = &mut dots[y * usize::from(width) + x];
        if dot.is_none() || selected == Some(at) || standing > Standing::Stale {
            *dot = style.fg;
        }
    }
    for row in 0..height {
        for column in 0..width {
            let ground = |half: usize| {
                let y = usize::from(row) * 2 + half;
                let within =
                    (shown.0.0..=shown.1.0).contains(&usize::from(column)) && (shown.0.1..=shown.1.1).contains(&y);
                dots[y * usize::from(width) + usize::from(column)].unwrap_or(if within { light } else { dark })
            };
            let cell = &mut buffer[(map.x + column, map.y + row)];
            cell.set_char('▀').set_style(Style::new().fg(ground(0)).bg(ground(1)));
        }
    }
}
