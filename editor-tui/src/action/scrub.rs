//! Moving through the frames and channels of what the preview shows.

use crate::model::{Effect, State};

/// A frame back.
pub fn back(state: &mut State) -> Vec<Effect> {
    state.preview.scrub(-1);
    Vec::new()
}

/// A frame on.
pub fn on(state: &mut State) -> Vec<Effect> {
    state.preview.scrub(1);
    Vec::new()
}

/// Plays, or stops.
pub fn play(state: &mut State) -> Vec<Effect> {
    state.preview.playing = !state.preview.playing;
    Vec::new()
}

/// The next channel or row.
pub fn next_row(state: &mut State) -> Vec<Effect> {
    state.preview.step_row(1);
    Vec::new()
}

/// The previous channel or row.
pub fn previous_row(state: &mut State) -> Vec<Effect> {
    state.preview.step_row(-1);
    Vec::new()
}
