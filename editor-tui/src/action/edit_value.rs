//! Editing parameters: exactly the value's bytes in the file are replaced.

use super::edit;
use crate::model::fields::Field;
use crate::model::line::Line;
use crate::model::{Effect, State};
use graph_core::document::edit::check_value;

/// The next parameter.
pub fn next(state: &mut State) -> Vec<Effect> {
    let count = state.fields().len();
    state.form.at = (state.form.at + 1).min(count.saturating_sub(1));
    Vec::new()
}

/// The previous parameter.
pub fn previous(state: &mut State) -> Vec<Effect> {
    state.form.at = state.form.at.saturating_sub(1);
    Vec::new()
}

fn chosen(state: &State) -> Option<Field> {
    state.fields().into_iter().nth(state.form.at)
}

/// Begins to type a value.
pub fn begin(state: &mut State) -> Vec<Effect> {
    if let Some(field) = chosen(state) {
        state.form.editing = Some(Line::new(field.value()));
        state.form.error = None;
    }
    Vec::new()
}

/// Takes what was typed: written into the file where it is a value, else told what is wrong.
pub fn done(state: &mut State) -> Vec<Effect> {
    let (Some(field), Some(line)) = (chosen(state), state.form.editing.clone()) else { return Vec::new() };
    let typed = line.text.trim();
    if typed.is_empty() {
        state.form.editing = None;
        return reset(state);
    }
    match write(state, &field, typed) {
        Ok(effects) => {
            (state.form.editing, state.form.error) = (None, None);
            effects
        }
        Err(message) => {
            state.form.error = Some(message);
            Vec::new()
        }
    }
}

fn write(state: &mut State, field: &Field, value: &str) -> Result<Vec<Effect>, String> {
    check_value(value).map_err(|fault| fault.to_string())?;
    if field.written.as_deref() == Some(value) {
        return Ok(Vec::new());
    }
    let of_graph = state.form.of_graph;
    let node = state.level().selected.clone().unwrap_or_default();
    let label = if of_graph { format!("set {}", field.name) } else { format!("set {node}.{}", field.name) };
    let done = edit(state, label, |draft| {
        if of_graph { draft.set_graph_param(&field.name, value) } else { draft.set_param(&node, &field.name, value) }
    });
    done.map_err(|fault| fault.to_string())
}

/// Switches to the next choice, where the parameter is a choice or a switch.
pub fn next_choice(state: &mut State) -> Vec<Effect> {
    let Some(field) = chosen(state) else { return Vec::new() };
    if field.choices.is_empty() {
        return begin(state);
    }
    let at = field.choices.iter().position(|choice| choice == field.value());
    let next = &field.choices[at.map_or(0, |at| at + 1) % field.choices.len()];
    match write(state, &field, next) {
        Ok(effects) => effects,
        Err(message) => {
            state.complain(message);
            Vec::new()
        }
    }
}

/// Takes the parameter out of the file, so that its default holds.
pub fn reset(state: &mut State) -> Vec<Effect> {
    let Some(field) = chosen(state).filter(|field| field.written.is_some()) else { return Vec::new() };
    if state.form.of_graph {
        state.complain("a graph's own parameter has no other default");
        return Vec::new();
    }
    let Some(node) = state.level().selected.clone() else { return Vec::new() };
    match edit(state, format!("reset {node}.{}", field.name), |draft| draft.unset_param(&node, &field.name)) {
        Ok(effects) => effects,
        Err(fault) => {
            state.complain(fault.to_string());
            Vec::new()
        }
    }
}
