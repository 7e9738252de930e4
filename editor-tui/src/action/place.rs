//! Which part of the screen takes the keys.

use super::peek;
use crate::model::{Effect, Focus, State};

/// The parameters of the selected node.
pub fn form(state: &mut State) -> Vec<Effect> {
    state.form.of_graph = false;
    state.focus = Focus::Form;
    Vec::new()
}

/// The graph's own parameters.
pub fn graph_params(state: &mut State) -> Vec<Effect> {
    state.form = crate::model::Form { of_graph: true, ..Default::default() };
    state.focus = Focus::Form;
    Vec::new()
}

/// The graph.
pub fn canvas(state: &mut State) -> Vec<Effect> {
    if state.form.of_graph {
        state.form = crate::model::Form::default();
    }
    state.focus = Focus::Canvas;
    Vec::new()
}

/// The next part that shows.
pub fn next(state: &mut State) -> Vec<Effect> {
    state.focus = match state.focus {
        Focus::Canvas => Focus::Form,
        Focus::Form if state.preview_open => Focus::Preview,
        Focus::Form | Focus::Preview => Focus::Canvas,
        Focus::Curves => Focus::Curves,
    };
    peek(state)
}

/// The previous part that shows.
pub fn previous(state: &mut State) -> Vec<Effect> {
    state.focus = match state.focus {
        Focus::Canvas if state.preview_open => Focus::Preview,
        Focus::Canvas | Focus::Preview => Focus::Form,
        Focus::Form => Focus::Canvas,
        Focus::Curves => Focus::Curves,
    };
    peek(state)
}
