//! Moving the board under the canvas.

use crate::model::{Effect, State};

fn pan(state: &mut State, x: i32, y: i32) -> Vec<Effect> {
    let (width, height) = state.canvas_size();
    let level = state.level_mut();
    // Something of the board always shows.
    level.pan.0 = (level.pan.0 + x).clamp(4 - width, (level.layout.width - 4).max(4 - width));
    level.pan.1 = (level.pan.1 + y).clamp(2 - height, (level.layout.height - 2).max(2 - height));
    Vec::new()
}

/// Shows more of what is to the left.
pub fn left(state: &mut State) -> Vec<Effect> {
    pan(state, -8, 0)
}

/// Shows more of what is to the right.
pub fn right(state: &mut State) -> Vec<Effect> {
    pan(state, 8, 0)
}

/// Shows more of what is above.
pub fn up(state: &mut State) -> Vec<Effect> {
    pan(state, 0, -3)
}

/// Shows more of what is below.
pub fn down(state: &mut State) -> Vec<Effect> {
    pan(state, 0, 3)
}

/// Moves the board with the mouse.
pub fn by(state: &mut State, x: i32, y: i32) -> Vec<Effect> {
    pan(state, x, y)
}
