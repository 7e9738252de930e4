//! Deleting a node.

use super::edit;
use crate::model::{Effect, State};

/// Deletes the selected node with all wires to it.
pub fn delete(state: &mut State) -> Vec<Effect> {
    let Some(name) = state.entry().and(state.level().selected.clone()) else { return Vec::new() };
    let neighbour = {
        let level = state.level();
        let at = state.card_at();
        at.and_then(|at| level.board.before(at).map(|wire| wire.from.0).next())
            .map(|card| level.board.cards[card].name.clone())
    };
    match edit(state, format!("delete {name}"), |draft| draft.delete_node(&name)) {
        Ok(effects) => {
            state.say(format!("deleted {name}"));
            if let Some(neighbour) = neighbour {
                state.select(&neighbour);
            }
            state.select_first();
            effects
        }
        Err(fault) => {
            state.complain(fault.to_string());
            Vec::new()
        }
    }
}
