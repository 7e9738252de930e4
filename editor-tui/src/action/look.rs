//! The preview: shown or hidden, and how its bodies are looked at.

use super::peek;
use crate::model::{Effect, Focus, State};

/// Shows the preview of the selected output, or hides it.
pub fn preview(state: &mut State) -> Vec<Effect> {
    state.preview_open = !state.preview_open;
    if !state.preview_open && state.focus == Focus::Preview {
        state.focus = Focus::Canvas;
    }
    state.show_selected();
    peek(state)
}

fn turn(state: &mut State, yaw: f32, pitch: f32) -> Vec<Effect> {
    state.preview.yaw_rad += yaw;
    state.preview.pitch_rad = (state.preview.pitch_rad + pitch).clamp(-1.5, 1.5);
    Vec::new()
}

/// Turns what is shown to the left.
pub fn turn_left(state: &mut State) -> Vec<Effect> {
    turn(state, -0.2, 0.0)
}

/// Turns what is shown to the right.
pub fn turn_right(state: &mut State) -> Vec<Effect> {
    turn(state, 0.2, 0.0)
}

/// Tilts what is shown up.
pub fn turn_up(state: &mut State) -> Vec<Effect> {
    turn(state, 0.0, -0.15)
}

/// Tilts what is shown down.
pub fn turn_down(state: &mut State) -> Vec<Effect> {
    turn(state, 0.0, 0.15)
}

/// Comes nearer.
pub fn nearer(state: &mut State) -> Vec<Effect> {
    state.preview.zoom = (state.preview.zoom * 1.2).min(8.0);
    Vec::new()
}

/// Goes farther away.
pub fn farther(state: &mut State) -> Vec<Effect> {
    state.preview.zoom = (state.preview.zoom / 1.2).max(0.3);
    Vec::new()
}
