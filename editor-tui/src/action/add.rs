//! Adding a node: a palette of kinds, then a name.

use super::{edit, peek};
use crate::model::catalogue::KindFacts;
use crate::model::line::Line;
use crate::model::wiring::Fit;
use crate::model::{Ask, Effect, Overlay, PortAt, State};

/// Opens the palette; where a port is selected, with what fits it.
pub fn add(state: &mut State) -> Vec<Effect> {
    let fit = state.level().port.and_then(|_| state.fit());
    state.overlay = Overlay::Palette { line: Line::default(), at: 0, fit };
    Vec::new()
}

/// The kinds in the palette.
pub fn listed<'a>(state: &'a State, typed: &str, fit: Option<&Fit>) -> Vec<&'a KindFacts> {
    state.catalogue.find(typed, |kind| fit.is_none_or(|fit| fit.takes(kind)))
}

/// A kind was chosen: asks for a name.
pub fn chosen(state: &mut State, kind: &str, fit: Option<Fit>) -> Vec<Effect> {
    let taken = |name: &str| state.level().board.find(name).is_some();
    let mut name = kind.to_owned();
    for number in 2.. {
        if !taken(&name) {
            break;
        }
        name = format!("{kind}_{number}");
    }
    let ask = Ask::NewName(kind.to_owned(), fit);
    state.overlay = Overlay::Prompt { ask, line: Line::new(name), error: None };
    Vec::new()
}

/// Adds the node, wired to the port it was chosen for.
pub fn done(state: &mut State, kind: &str, fit: Option<&Fit>, name: &str) -> Result<Vec<Effect>, String> {
    let facts = state.catalogue.get(kind).ok_or_else(|| format!("there is no kind `{kind}`"))?.clone();
    let mut inputs = String::new();
    if let Some(fit) = fit.filter(|fit| !fit.input)
        && let Some(port) = facts.inputs.iter().find(|port| port.kind.name == fit.port.type_name)
    {
        inputs = format!(", in: {{\"{}\": \"{}\"}}", port.name, state.source_text(&fit.card, &fit.port.name));
    }
    let entry = format!("(kind: \"{kind}\"{inputs})");
    let mut effects =
        edit(state, format!("add {name}"), |draft| draft.add_node(name, &entry)).map_err(|fault| fault.to_string())?;
    if let Some(fit) = fit.filter(|fit| fit.input)
        && let Some(port) = facts.outputs.iter().find(|port| port.kind.name == fit.port.type_name)
    {
        let source = if facts.outputs.len() > 1 { format!("{name}.{}", port.name) } else { name.to_owned() };
        let wired = edit(state, format!("wire {name} to {}", fit.card), |draft| {
            draft.connect(&fit.card, &fit.port.name, &source, fit.port.list)
        });
        effects.extend(wired.map_err(|fault| fault.to_string())?);
    }
    state.select(name);
    if !facts.inputs.is_empty() && fit.is_none() {
        state.level_mut().port = Some(PortAt { input: true, at: 0 });
    }
    state.say(format!("added {name}; w wires it, e edits its parameters"));
    effects.extend(peek(state));
    Ok(effects)
}
