//! The keys.

use crate::model::{Effect, Overlay, State};

/// Shows the keys.
pub fn help(state: &mut State) -> Vec<Effect> {
    state.overlay = Overlay::Help(0);
    Vec::new()
}
