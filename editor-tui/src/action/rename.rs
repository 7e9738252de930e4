//! Renaming a node.

use super::edit;
use crate::model::line::Line;
use crate::model::{Ask, Effect, Overlay, State};

/// Asks for a new name.
pub fn rename(state: &mut State) -> Vec<Effect> {
    if let Some(name) = state.entry().and(state.level().selected.clone()) {
        state.overlay = Overlay::Prompt { line: Line::new(name.clone()), ask: Ask::Rename(name), error: None };
    }
    Vec::new()
}

/// Gives the node its new name, in every wire too.
pub fn done(state: &mut State, from: &str, to: &str) -> Result<Vec<Effect>, String> {
    if from == to {
        return Ok(Vec::new());
    }
    let effects = edit(state, format!("rename {from} to {to}"), |draft| draft.rename_node(from, to));
    let effects = effects.map_err(|fault| fault.to_string())?;
    state.select(to);
    Ok(effects)
}
