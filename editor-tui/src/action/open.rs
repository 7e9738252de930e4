//! Into nested graphs and out of them again.

use super::{peek, place, unread};
use crate::model::board::Role;
use crate::model::{Effect, Level, State};
use std::sync::Arc;

/// Opens the nested graph in place, or the parameters of a node.
pub fn open(state: &mut State) -> Vec<Effect> {
    let Some(card) = state.card().cloned() else { return Vec::new() };
    let file = match &card.role {
        Role::Nested(_, Some(file)) => file.clone(),
        Role::Nested(text, None) => {
            state.complain(format!("`{text}` depends on parameters, so its file is not known here"));
            return Vec::new();
        }
        Role::Kind(_) => return place::form(state),
        Role::Inputs | Role::Outputs => return Vec::new(),
    };
    let mut effects = Vec::new();
    if state.texts.get(&file).is_none() {
        state.complain(format!("{} is not read yet, or cannot be", file.display()));
        effects.push(Effect::Read(file.clone()));
        return effects;
    }
    let prefix = format!("{}{}/", state.level().prefix, card.name);
    let (board, layout) = (Arc::default(), Arc::default());
    let (selected, port) = (None, None);
    state.trail.push(Level { file, name: card.name, prefix, selected, port, pan: (0, 0), board, layout, other: None });
    state.refresh();
    state.select_first();
    state.centre();
    effects.extend(unread(state));
    effects.extend(peek(state));
    effects
}

/// Back to the graph around; out of a selected port first.
pub fn leave(state: &mut State) -> Vec<Effect> {
    if state.level().port.is_some() {
        state.level_mut().port = None;
    } else if state.trail.len() > 1 {
        state.trail.pop();
        state.form = crate::model::Form::default();
        state.show_selected();
    }
    peek(state)
}
