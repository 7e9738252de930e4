//! Saving.

use crate::model::{Effect, State};

/// Writes all files that were edited.
pub fn save(state: &mut State) -> Vec<Effect> {
    if state.texts.is_unsaved() {
        return vec![Effect::Save];
    }
    state.say("all is saved");
    Vec::new()
}
