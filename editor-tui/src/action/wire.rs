//! Wiring: from the selected port to any that fits; what does not fit is refused with the reason.

use super::{edit, peek};
use crate::model::catalogue::closeness;
use crate::model::line::Line;
use crate::model::wiring::{Choice, Fit};
use crate::model::{Effect, Overlay, State};

/// Shows what the port may be wired to.
pub fn wire(state: &mut State) -> Vec<Effect> {
    let Some(fit) = state.fit() else {
        state.complain("select a node first");
        return Vec::new();
    };
    let choices = state.choices(&fit);
    state.overlay = Overlay::Wiring { fit, line: Line::default(), choices, at: 0 };
    Vec::new()
}

/// The choices that `typed` may mean.
pub fn listed<'a>(choices: &'a [Choice], typed: &str) -> Vec<&'a Choice> {
    let near = |choice: &&Choice| closeness(typed, &format!("{}.{}", choice.card, choice.port.name)).is_some();
    choices.iter().filter(near).collect()
}

/// Makes the wire.
pub fn chosen(state: &mut State, fit: &Fit, choice: &Choice) -> Vec<Effect> {
    let own = format!("{}.{}", fit.card, fit.port.name);
    let other = format!("{}.{}", choice.card, choice.port.name);
    if let Some(reason) = &choice.against {
        state.complain(format!("{own} and {other}: {reason}"));
        return Vec::new();
    }
    let (node, input, card, port) = if fit.input {
        (&fit.card, &fit.port, &choice.card, &choice.port)
    } else {
        (&choice.card, &choice.port, &fit.card, &fit.port)
    };
    let source = state.source_text(card, &port.name);
    let label = format!("wire {source} to {node}.{}", input.name);
    match edit(state, label.clone(), |draft| draft.connect(node, &input.name, &source, input.list)) {
        Ok(mut effects) => {
            state.overlay = Overlay::None;
            state.say(label);
            effects.extend(peek(state));
            effects
        }
        Err(fault) => {
            state.complain(fault.to_string());
            Vec::new()
        }
    }
}

/// Takes the selected input's wire away.
pub fn unwire(state: &mut State) -> Vec<Effect> {
    let Some(fit) = state.fit().filter(|fit| fit.input && fit.port.wired) else {
        state.complain("select a wired input first: . goes from port to port");
        return Vec::new();
    };
    let label = format!("unwire {}.{}", fit.card, fit.port.name);
    match edit(state, label.clone(), |draft| draft.disconnect(&fit.card, &fit.port.name, None)) {
        Ok(effects) => {
            state.say(label);
            effects
        }
        Err(fault) => {
            state.complain(fault.to_string());
            Vec::new()
        }
    }
}
