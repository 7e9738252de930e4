//! Two heads brought together by landmarks and muscle curves: what `transfer_meshes` and `transfer_rig` share.

use crate::patterns::Patterns;
use face_math::data::{Attachment, Muscles, Part, Rig};
use face_math::strain::{Transfer, TransferOptions};
use graph_core::node::{Inputs, NodeError, Port};

pub(crate) const ACTOR: Port<Rig> = Port::new("actor", "the actor; what counts of it is its rest");
pub(crate) const CHARACTER: Port<Rig> =
    Port::new("character", "the character at rest; its parts are named as the actor's are");
pub(crate) const ACTOR_LANDMARKS: Port<Attachment> = Port::new("actor_landmarks", "landmarks on the actor");
pub(crate) const CHARACTER_LANDMARKS: Port<Attachment> =
    Port::new("character_landmarks", "the same landmarks on the character, by name");
pub(crate) const ACTOR_MUSCLES: Port<Muscles> =
    Port::new("actor_muscles", "muscle curves on the actor, which guide the warp; landmarks alone do where left open");
pub(crate) const CHARACTER_MUSCLES: Port<Muscles> =
    Port::new("character_muscles", "the same muscle curves on the character");

/// The warp between the heads on the ports above. `parts` are patterns of the actor's parts that hold its skin.
pub(crate) fn bring_together<'i>(
    inputs: &'i Inputs,
    parts: &[String],
    smoothing_mm: f64,
) -> Result<Transfer<'i>, NodeError> {
    let (actor, character) = (inputs.get(&ACTOR)?, inputs.get(&CHARACTER)?);
    let names: Vec<String> = actor.parts.iter().map(|part| part.name.clone()).collect();
    let chosen = Patterns { parameter: "parts", what: "part", names: &names }.chosen(parts)?;
    let parts: Vec<&Part> = actor.parts.iter().filter(|part| chosen.contains(&part.name)).collect();
    let muscles = match (inputs.may_get(&ACTOR_MUSCLES)?, inputs.may_get(&CHARACTER_MUSCLES)?) {
        (Some(actor), Some(character)) => Some((actor, character)),
        (None, None) => None,
        _ => {
            return Err(NodeError::input(CHARACTER_MUSCLES.name(), "connect the muscles of both heads, or of neither"));
        }
    };
    let landmarks = (inputs.get(&ACTOR_LANDMARKS)?, inputs.get(&CHARACTER_LANDMARKS)?);
    let options = TransferOptions { smoothing_m: smoothing_mm / 1000.0 };
    Transfer::new(actor, character, &parts, landmarks, muscles, &options)
        .map_err(|error| NodeError::input(CHARACTER.name(), error))
}
