//! `transfer_meshes`: an actor's animated meshes on another head, by landmarks and muscle curves; where characters begin.

use super::heads::{
    ACTOR, ACTOR_LANDMARKS, ACTOR_MUSCLES, CHARACTER, CHARACTER_LANDMARKS, CHARACTER_MUSCLES, bring_together,
};
use face_math::data::Meshes;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MESHES: Port<Meshes> = Port::new("meshes", "the actor's meshes, in metres");
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
        let transfer = bring_together(inputs, &self.parts, self.smoothing_mm)?;
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
