//! Moving the selection: along wires to the left and right, to neighbours up and down.

use super::peek;
use crate::model::{Effect, PortAt, State};

/// To where the selected port's wire, or the nearest, comes from.
pub fn left(state: &mut State) -> Vec<Effect> {
    along(state, true)
}

/// To where the selected port's wire, or the nearest, leads.
pub fn right(state: &mut State) -> Vec<Effect> {
    along(state, false)
}

/// To the card above in the same layer, or the nearest above.
pub fn up(state: &mut State) -> Vec<Effect> {
    beside(state, -1)
}

/// To the card below.
pub fn down(state: &mut State) -> Vec<Effect> {
    beside(state, 1)
}

fn along(state: &mut State, back: bool) -> Vec<Effect> {
    let Some(at) = state.card_at() else {
        state.select_first();
        return Vec::new();
    };
    let level = state.level();
    let port = level.port.filter(|port| port.input == back).map(|port| port.at);
    let own = level.layout.places.get(at).copied().unwrap_or_default();
    let middle = |card: usize| level.layout.places.get(card).map_or(0, |place| place.y + place.height / 2);
    let near = |card: usize| (middle(card) - own.y - own.height / 2).abs();
    let wired = if back {
        let wires = level.board.before(at).filter(|wire| port.is_none_or(|port| wire.to.1 == port));
        wires.map(|wire| wire.from.0).min_by_key(|card| (near(*card), *card))
    } else {
        let wires = level.board.after(at).filter(|wire| port.is_none_or(|port| wire.from.1 == port));
        wires.map(|wire| wire.to.0).min_by_key(|card| (near(*card), *card))
    };
    let lies = |card: &usize| {
        let x = level.layout.places[*card].x;
        if back { x < own.x } else { x > own.x }
    };
    let nearest = || {
        let others = (0..level.layout.places.len()).filter(lies);
        others.min_by_key(|card| ((level.layout.places[*card].x - own.x).abs(), near(*card)))
    };
    let target = wired.or_else(nearest).map(|card| level.board.cards[card].name.clone());
    go(state, target)
}

fn beside(state: &mut State, step: i32) -> Vec<Effect> {
    let Some(at) = state.card_at() else {
        state.select_first();
        return Vec::new();
    };
    let level = state.level();
    let own = level.layout.places.get(at).copied().unwrap_or_default();
    let others = (0..level.layout.places.len()).filter(|card| {
        let place = level.layout.places[*card];
        *card != at && (place.y - own.y).signum() == step
    });
    let target = others.min_by_key(|card| {
        let place = level.layout.places[*card];
        (place.x != own.x, (place.y - own.y).abs() + (place.x - own.x).abs(), *card)
    });
    let target = target.map(|card| level.board.cards[card].name.clone());
    go(state, target)
}

fn go(state: &mut State, target: Option<String>) -> Vec<Effect> {
    let Some(target) = target else { return Vec::new() };
    state.select(&target);
    peek(state)
}

/// Selects a port of the selected card.
pub fn to_port(state: &mut State, port: Option<PortAt>) -> Vec<Effect> {
    state.level_mut().port = port;
    peek(state)
}
