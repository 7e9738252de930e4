//! Finding a node by a few letters.

use super::peek;
use crate::model::catalogue::closeness;
use crate::model::line::Line;
use crate::model::{Ask, Effect, Overlay, State};

/// Asks for letters of a name.
pub fn find(state: &mut State) -> Vec<Effect> {
    state.overlay = Overlay::Prompt { ask: Ask::Find, line: Line::default(), error: None };
    Vec::new()
}

/// The nodes of the open file that the letters may mean, the likeliest first.
pub fn found<'a>(state: &'a State, typed: &str) -> Vec<&'a str> {
    let cards = state.level().board.cards.iter().map(|card| card.name.as_str());
    let mut near: Vec<(u32, &str)> = cards.filter_map(|name| Some((closeness(typed, name)?, name))).collect();
    near.sort_unstable();
    near.into_iter().map(|(_, name)| name).collect()
}

/// Selects the likeliest.
pub fn done(state: &mut State, typed: &str) -> Result<Vec<Effect>, String> {
    let name = found(state, typed).first().map(|name| (*name).to_owned());
    let name = name.ok_or_else(|| format!("no node here is called like `{typed}`"))?;
    state.select(&name);
    Ok(peek(state))
}
