//! Choosing the item of repeated nodes that shows.

use super::peek;
use crate::model::{Effect, State};

/// The next item of the selected node; after the last, none in particular.
pub fn next(state: &mut State) -> Vec<Effect> {
    let Some(path) = state.path() else { return Vec::new() };
    let items: Vec<String> =
        state.statuses.tally(&path).map(|tally| tally.items.keys().cloned().collect()).unwrap_or_default();
    if items.is_empty() {
        state.complain(format!("`{path}` is cooked once, not for items"));
        return Vec::new();
    }
    let at = state.item.as_ref().and_then(|item| items.iter().position(|known| known == item));
    state.item = match at {
        None => items.first().cloned(),
        Some(at) => items.get(at + 1).cloned(),
    };
    match &state.item {
        Some(item) => state.say(format!("item {item}")),
        None => state.say("all items"),
    }
    peek(state)
}
