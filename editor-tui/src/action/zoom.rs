//! How much of the board shows.

use crate::model::layout::Zoom;
use crate::model::{Effect, State};

/// Boxes with ports, or a line a card.
pub fn zoom(state: &mut State) -> Vec<Effect> {
    state.zoom = match state.zoom {
        Zoom::Normal => Zoom::Compact,
        Zoom::Compact => Zoom::Normal,
    };
    state.lay_out();
    Vec::new()
}

/// Centres the board, or the selected card where the board is larger than the canvas.
pub fn centre(state: &mut State) -> Vec<Effect> {
    state.centre();
    Vec::new()
}
