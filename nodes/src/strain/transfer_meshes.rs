//! `transfer_meshes`: an actor's animated meshes on another head, by landmarks and muscle curves; where characters begin.

use crate::patterns::Patterns;
use face_math::data::{Attachment, Meshes, Muscles, Part, Rig};
use face_math::strain::{Transfer, TransferOptions};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MESHES: Port<Meshes> = Port::new("meshes", "the actor's meshes, in metres");
const ACTOR: Port<Rig> = Port::new("actor", "the actor at rest");
const CHARACTER: Port<Rig> = Port::new("character", "the character at rest; its parts are named as the actor's are");
const ACTOR_LANDMARKS: Port<Attachment> = Port::new("actor_landmarks", "landmarks on the actor");
const CHARACTER_LANDMARKS: Port<Attachment> =
    Port::new("character_landmarks", "the same landmarks on the character, by name");
const ACTOR_MUSCLES: Port<Muscles> =
    Port::new("actor_muscles", "muscle curves on the actor, which guide the warp; landmarks alone do where left open");
const CHARACTER_MUSCLES: Port<Muscles> = Port::new("character_muscles", "the same muscle curves on the character");
const TRANSFERRED: Port<Meshes> = Port::new("meshes", "the character's meshes in the same frames, in metres");

/// Carries meshes from one head to another of any topology.
///
/// A smooth warp takes the actor at rest to the character by their landmarks and muscle curves. Each vertex of the character
/// rides on the actor's surface nearest to it there, and moves as the warp says that this surface does.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TransferMeshes {
    /// Parts of the actor that hold its skin, as patterns; the same parts of the character ride on them.
    parts: Vec<String>,
    /// How closely the warp keeps to landmarks and curves: 0 meets them exactly, more bends less.
    #[schemars(range(min = 0.0, max = 1000.0))]
    smoothing_mm: f64,
}

impl Default for TransferMeshes {
    fn default() -> Self {
        Self { parts: Vec::new(), smoothing_mm: 0.0 }
    }
}

graph_core::register!(TransferMeshes);

#[typetag::serde(name = "transfer_meshes")]
impl Node for TransferMeshes {
    fn card(&self) -> Card {
        Card::new("strain")
            .takes(&MESHES)
            .takes(&ACTOR)
            .takes(&CHARACTER)
            .takes(&ACTOR_LANDMARKS)
            .takes(&CHARACTER_LANDMARKS)
            .may_take(&ACTOR_MUSCLES)
            .may_take(&CHARACTER_MUSCLES)
            .gives(&TRANSFERRED)
            .per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (actor, character) = (inputs.get(&ACTOR)?, inputs.get(&CHARACTER)?);
        let names: Vec<String> = actor.parts.iter().map(|part| part.name.clone()).collect();
        let chosen = Patterns { parameter: "parts", what: "part", names: &names }.chosen(&self.parts)?;
        let keep = |part: &&Part| chosen.contains(&part.name);
        let parts: Vec<&Part> = actor.parts.iter().filter(keep).collect();
        let muscles = match (inputs.may_get(&ACTOR_MUSCLES)?, inputs.may_get(&CHARACTER_MUSCLES)?) {
            (Some(actor), Some(character)) => Some((actor, character)),
            (None, None) => None,
            _ => {
                return Err(NodeError::input(
                    CHARACTER_MUSCLES.name(),
                    "connect the muscles of both heads, or of neither",
                ));
            }
        };
        let landmarks = (inputs.get(&ACTOR_LANDMARKS)?, inputs.get(&CHARACTER_LANDMARKS)?);
        let options = TransferOptions { smoothing_m: self.smoothing_mm / 1000.0 };
        let transfer = Transfer::new(actor, character, &parts, landmarks, muscles, &options)
            .map_err(|error| NodeError::input(CHARACTER.name(), error))?;
        let meshes = transfer.meshes(inputs.get(&MESHES)?).map_err(|error| NodeError::input(MESHES.name(), error))?;
        Ok(Outputs::default().with(&TRANSFERRED, meshes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::compute;
    use glam::Vec3;

    #[test]
    fn a_larger_head_moves_as_much_more() {
        let motion = toy::motion(120);
        let meshes = toy::evaluated(&toy::ACTOR, &motion);
        let mut character = toy::ACTOR.clone();
        character.neutral.iter_mut().for_each(|point| *point = *point * 1.2 + Vec3::new(0.0, 0.1, 0.0));
        let inputs = Inputs::default()
            .with(&MESHES, meshes.clone())
            .with(&ACTOR, toy::ACTOR.clone())
            .with(&CHARACTER, character)
            .with(&ACTOR_LANDMARKS, toy::landmarks())
            .with(&CHARACTER_LANDMARKS, toy::landmarks());
        let outputs = compute(&TransferMeshes::default(), &inputs).unwrap();
        let found = outputs.get(&TRANSFERRED).unwrap();
        let face = toy::ACTOR.part("face").unwrap().vertices.end as usize;
        for frame in 0..found.frames() {
            for vertex in (0..face).step_by(50) {
                let expected = meshes.frame(frame)[vertex] * 1.2 + Vec3::new(0.0, 0.1, 0.0);
                assert!(found.frame(frame)[vertex].distance(expected) < 5e-4);
            }
        }
    }
}
