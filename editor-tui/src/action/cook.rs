//! Cooking in the background.

use crate::model::{Effect, State};

/// Cooks the graph as it is now, saved or not.
pub fn all(state: &mut State) -> Vec<Effect> {
    begin(state, Vec::new())
}

/// Cooks the selected node and what it needs.
pub fn selected(state: &mut State) -> Vec<Effect> {
    let Some(path) = state.path() else { return Vec::new() };
    begin(state, vec![path])
}

fn begin(state: &mut State, only: Vec<String>) -> Vec<Effect> {
    if state.cooking.is_some() {
        state.complain("a cook runs already; cancel it first");
        return Vec::new();
    }
    if let Some(first) = state.mistakes.first() {
        let message = first.message.clone();
        state.complain(format!("mend the graph first: {message}"));
        return Vec::new();
    }
    state.cooking = Some(crate::model::Cooking { revision: state.texts.revision, ..Default::default() });
    state.note = None;
    vec![Effect::Cook(only)]
}

/// Ends the cook; what is done stays.
pub fn cancel(state: &mut State) -> Vec<Effect> {
    let Some(cooking) = &mut state.cooking else { return Vec::new() };
    cooking.cancelled = true;
    state.say("cancelling …");
    vec![Effect::Cancel]
}
