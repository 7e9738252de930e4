//! Choosing a port of the selected card: inputs first, then outputs, then none.

use super::select::to_port;
use crate::model::{Effect, PortAt, State};

/// The next port.
pub fn next(state: &mut State) -> Vec<Effect> {
    step(state, 1)
}

/// The previous port.
pub fn previous(state: &mut State) -> Vec<Effect> {
    step(state, -1)
}

fn step(state: &mut State, by: isize) -> Vec<Effect> {
    let Some(card) = state.card() else { return Vec::new() };
    let (inputs, outputs) = (card.inputs.len(), card.outputs.len());
    let now = match state.level().port {
        None => 0,
        Some(PortAt { input: true, at }) => at + 1,
        Some(PortAt { input: false, at }) => inputs + at + 1,
    };
    let count = inputs + outputs + 1;
    let then = (now + count).saturating_add_signed(by) % count;
    let port = match then {
        0 => None,
        at if at <= inputs => Some(PortAt { input: true, at: at - 1 }),
        at => Some(PortAt { input: false, at: at - 1 - inputs }),
    };
    to_port(state, port)
}
