//! Taking operations back, and making them again.

use super::changed;
use crate::model::{Effect, State};

/// Undoes the last operation, in whatever file it was made.
pub fn undo(state: &mut State) -> Vec<Effect> {
    let done = state.texts.undo();
    tell(state, done, "there is nothing to undo")
}

/// Makes the operation again that was undone last.
pub fn redo(state: &mut State) -> Vec<Effect> {
    let done = state.texts.redo();
    tell(state, done, "there is nothing to redo")
}

fn tell(state: &mut State, done: Option<crate::model::texts::Operation>, nothing: &str) -> Vec<Effect> {
    match &done {
        Some(operation) => state.say(operation.label.clone()),
        None => state.complain(nothing),
    }
    changed(state, done)
}
