//! The mouse: a click selects, a second opens, a drag moves the board, the wheel too.

use super::{open, pan, peek};
use crate::model::layout::Zoom;
use crate::model::{Effect, Focus, Overlay, PortAt, State};
use ratatui::crossterm::event::{KeyModifiers, MouseButton, MouseEvent, MouseEventKind};
use ratatui::layout::Position;

/// Takes what the mouse does.
pub fn mouse(state: &mut State, event: MouseEvent) -> Vec<Effect> {
    if state.overlay != Overlay::None || state.work.is_some() {
        return Vec::new();
    }
    let areas = crate::view::areas(state);
    let at = Position { x: event.column, y: event.row };
    let sideways = event.modifiers.contains(KeyModifiers::SHIFT);
    match event.kind {
        MouseEventKind::Down(MouseButton::Left) if areas.canvas.contains(at) => {
            state.focus = Focus::Canvas;
            state.drag = Some((event.column, event.row));
            click(state, i32::from(at.x - areas.canvas.x), i32::from(at.y - areas.canvas.y))
        }
        MouseEventKind::Down(MouseButton::Left) if areas.form.contains(at) => {
            state.focus = Focus::Form;
            Vec::new()
        }
        MouseEventKind::Down(MouseButton::Left) if areas.preview.contains(at) => {
            state.focus = Focus::Preview;
            Vec::new()
        }
        MouseEventKind::Drag(_) => {
            let Some(from) = state.drag.replace((event.column, event.row)) else { return Vec::new() };
            let by = (i32::from(from.0) - i32::from(event.column), i32::from(from.1) - i32::from(event.row));
            pan::by(state, by.0, by.1)
        }
        MouseEventKind::Up(_) => {
            state.drag = None;
            Vec::new()
        }
        MouseEventKind::ScrollUp if sideways => pan::left(state),
        MouseEventKind::ScrollDown if sideways => pan::right(state),
        MouseEventKind::ScrollUp => pan::up(state),
        MouseEventKind::ScrollDown => pan::down(state),
        MouseEventKind::ScrollLeft => pan::left(state),
        MouseEventKind::ScrollRight => pan::right(state),
        _ => Vec::new(),
    }
}

fn click(state: &mut State, column: i32, row: i32) -> Vec<Effect> {
    let level = state.level();
    let (x, y) = (column + level.pan.0, row + level.pan.1);
    let hit = level.layout.places.iter().position(|place| {
        (place.x..place.x + place.width).contains(&x) && (place.y..place.y + place.height).contains(&y)
    });
    let Some(hit) = hit else { return Vec::new() };
    let (place, card) = (level.layout.places[hit], &level.board.cards[hit]);
    let line = usize::try_from(y - place.y - 1).ok().filter(|_| state.zoom == Zoom::Normal);
    let input = x < place.x + place.width / 2;
    let ports = if input { card.inputs.len() } else { card.outputs.len() };
    let port = line.filter(|line| *line < ports).map(|at| PortAt { input, at });
    let again = level.selected.as_ref() == Some(&card.name) && line.is_none_or(|line| line >= ports);
    let name = card.name.clone();
    if again {
        return open::open(state);
    }
    state.select(&name);
    state.level_mut().port = port;
    peek(state)
}
