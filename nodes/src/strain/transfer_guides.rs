//! `transfer_guides`: corrects transferred meshes by pairs of guide shapes (section C of Animatomy).

use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::{StrainError, transfer_guides};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MESHES: Port<Meshes> = Port::new("meshes", "the actor's meshes, in metres");
const TRANSFERRED: Port<Meshes> =
    Port::new("transferred", "the same frames on the character, as transferred (`transfer_meshes`)");
const ACTOR: Port<Rig> = Port::new("actor", "the actor at rest");
const ACTOR_GUIDES: Port<Meshes> =
    Port::new("actor_guides", "the actor's guide shapes, a frame each: an eye closed, the jaw open");
const TRANSFERRED_GUIDES: Port<Meshes> =
    Port::new("transferred_guides", "the actor's guide shapes as transferred to the character");
const CHARACTER_GUIDES: Port<Meshes> =
    Port::new("character_guides", "the same guide shapes as an artist made them on the character");
const CORRECTED: Port<Meshes> = Port::new("meshes", "the character's meshes, corrected, in metres");
const WEIGHTS: Port<Curves> = Port::new("weights", "the weight of each guide in each frame: `guide_1`, `guide_2` …");

/// Adds to transferred meshes what guide shapes correct, as much of each as the actor's mesh shows of it.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TransferGuides {
    /// Whether weights of guides are held between 0 and 1.
    bounded: bool,
}

graph_core::register!(TransferGuides);

#[typetag::serde(name = "transfer_guides")]
impl Node for TransferGuides {
    fn card(&self) -> Card {
        Card::new("strain")
            .takes(&MESHES)
            .takes(&TRANSFERRED)
            .takes(&ACTOR)
            .takes(&ACTOR_GUIDES)
            .still()
            .takes(&TRANSFERRED_GUIDES)
            .still()
            .takes(&CHARACTER_GUIDES)
            .still()
            .gives(&CORRECTED)
            .gives(&WEIGHTS)
            .per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let corrected = transfer_guides(
            inputs.get(&MESHES)?,
            inputs.get(&TRANSFERRED)?,
            &inputs.get(&ACTOR)?.neutral,
            [inputs.get(&ACTOR_GUIDES)?, inputs.get(&TRANSFERRED_GUIDES)?, inputs.get(&CHARACTER_GUIDES)?],
            self.bounded,
        );
        let (meshes, weights) = corrected.map_err(|error: StrainError| NodeError::failed(error))?;
        Ok(Outputs::default().with(&CORRECTED, meshes).with(&WEIGHTS, weights))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    #[test]
    fn guides_at_a_guides_pose_give_the_guide() {
        let motion = toy::motion(200);
        let actor = toy::evaluated(&toy::ACTOR, &motion);
        let bigger = |meshes: &Meshes, by: f32| {
            let positions = meshes.positions().iter().map(|point| *point * by).collect();
            Meshes::new(meshes.frame_axis(), meshes.parts().to_vec(), meshes.vertices(), positions).unwrap()
        };
        let inputs = Inputs::default()
            .with(&MESHES, actor.clone())
            .with(&TRANSFERRED, bigger(&actor, 1.1))
            .with(&ACTOR, toy::ACTOR.clone())
            .with(&ACTOR_GUIDES, actor.clone())
            .with(&TRANSFERRED_GUIDES, bigger(&actor, 1.1))
            .with(&CHARACTER_GUIDES, bigger(&actor, 1.2));
        let node: TransferGuides = made(json!({}));
        let outputs = compute(&node, &inputs).unwrap();
        let found = outputs.get(&CORRECTED).unwrap();
        // The first frame is at rest, where no guide weighs in.
        let known = bigger(&actor, 1.2);
        for (a, b) in found.positions().iter().zip(known.positions()).skip(actor.vertices()) {
            assert!(a.abs_diff_eq(*b, 1e-4), "{a} {b}");
        }
    }
}
