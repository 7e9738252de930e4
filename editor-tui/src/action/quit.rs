//! Leaving.

use crate::model::{Effect, Overlay, Question, State};

/// Leaves, or asks first where something is unsaved.
pub fn quit(state: &mut State) -> Vec<Effect> {
    if state.texts.is_unsaved() {
        state.overlay = Overlay::Question(Question::Quit);
        return Vec::new();
    }
    vec![Effect::DropJournal, Effect::Quit]
}
