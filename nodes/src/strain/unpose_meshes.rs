//! `unpose_meshes`: animated meshes with the joints' motion undone; between skinning and all that is learned in rest pose.

use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::{Keep, unpose_meshes};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> =
    Port::new("rig", "a head with fitted skinning (`fit_skinning`), and pose shapes where it has them");
const MESHES: Port<Meshes> = Port::new("meshes", "its animated meshes, in metres");
const POSES: Port<Curves> = Port::new("poses", "the poses of the joints in the same frames");
const UNPOSED: Port<Meshes> = Port::new("meshes", "what the face does besides, in its rest pose, in metres");

/// Undoes skinning, and takes off pose shapes: what is left is what expressions do.
///
/// Skinning has no inverse where a vertex hangs between the skull and a joint that turns by about half a circle; such a frame
/// is refused.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct UnposeMeshes {
    /// Whether what pose shapes do is left in the meshes.
    keep_pose_shapes: bool,
}

graph_core::register!(UnposeMeshes);

#[typetag::serde(name = "unpose_meshes")]
impl Node for UnposeMeshes {
    fn card(&self) -> Card {
        Card::new("strain").takes(&RIG).takes(&MESHES).takes(&POSES).gives(&UNPOSED).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let keep = if self.keep_pose_shapes { Keep::PoseShapes } else { Keep::Strains };
        let unposed = unpose_meshes(inputs.get(&RIG)?, inputs.get(&MESHES)?, inputs.get(&POSES)?, keep);
        Ok(Outputs::default().with(&UNPOSED, unposed.map_err(super::fault)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::compute;
    use face_math::strain::measure_poses;

    #[test]
    fn teeth_and_eyes_are_still_when_unposed() {
        let curves = toy::motion(60);
        let meshes = toy::evaluated(&toy::ACTOR, &curves);
        let poses = measure_poses(&toy::BASE, &meshes).unwrap();
        let inputs = Inputs::default().with(&RIG, toy::BASE.clone()).with(&MESHES, meshes).with(&POSES, poses);
        let outputs = compute(&UnposeMeshes::default(), &inputs).unwrap();
        let unposed = outputs.get(&UNPOSED).unwrap();
        let teeth = toy::BASE.part("teeth_lower").unwrap().vertices.clone();
        for frame in 0..unposed.frames() {
            for vertex in teeth.clone() {
                let far = unposed.frame(frame)[vertex as usize].distance(toy::BASE.neutral[vertex as usize]);
                assert!(far < 2e-5, "{far}");
            }
        }
    }
}
