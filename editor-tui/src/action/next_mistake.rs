//! Going from mistake to mistake.

use crate::model::{Effect, State};

/// Selects the next card of the open file in which something is wrong, and tells what.
pub fn next_mistake(state: &mut State) -> Vec<Effect> {
    let count = state.level().board.cards.len();
    let from = state.card_at().map_or(0, |at| at + 1);
    let wrong = (0..count).map(|step| (from + step) % count.max(1)).find_map(|at| Some((at, state.mistake_of(at)?)));
    match wrong {
        Some((at, message)) => {
            let name = state.level().board.cards[at].name.clone();
            state.select(&name);
            state.complain(message);
        }
        None => match state.mistakes.first().map(|mistake| mistake.message.clone()) {
            Some(message) => state.complain(message),
            None => state.say("there are no mistakes"),
        },
    }
    Vec::new()
}
