//! `fit_pose_shapes`: what joints do to a face beyond skinning (section A.2 of Animatomy).

use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::fit_pose_shapes;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a head with fitted skinning (`fit_skinning`)");
const MESHES: Port<Meshes> =
    Port::new("meshes", "its meshes with skinning undone (`unpose_meshes` with `keep_pose_shapes`), in metres");
const POSES: Port<Curves> = Port::new("poses", "the poses of the joints in the same frames");
const CORRECTED: Port<Rig> = Port::new(
    "rig",
    "the same head with nine pose shapes a joint, driven by its rotation, and three for the jaw's translation",
);

/// Fits pose shapes to unposed meshes by least squares, the smaller the less the motion shows what they do.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FitPoseShapes {
    /// How far weak motion of the joints is left to the strains: directions of motion (each feature taken by its own spread) that
    /// are much weaker than this share of the strongest hardly get shapes. 0 explains all it can, and takes from the strains what
    /// merely happened along with the joints in training; more is safer and coarser.
    #[schemars(range(min = 0.0, max = 100.0))]
    stiffness: f64,
}

impl Default for FitPoseShapes {
    fn default() -> Self {
        Self { stiffness: 0.25 }
    }
}

graph_core::register!(FitPoseShapes);

#[typetag::serde(name = "fit_pose_shapes")]
impl Node for FitPoseShapes {
    fn card(&self) -> Card {
        Card::new("strain").takes(&RIG).takes(&MESHES).takes(&POSES).gives(&CORRECTED)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let rig = fit_pose_shapes(inputs.get(&RIG)?, inputs.get(&MESHES)?, inputs.get(&POSES)?, self.stiffness);
        Ok(Outputs::default().with(&CORRECTED, rig.map_err(super::fault)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{compute, made};
    use face_math::strain::{Keep, measure_poses, unpose_meshes};
    use serde_json::json;

    #[test]
    fn pose_shapes_lower_what_is_left() {
        let meshes = toy::evaluated(&toy::ACTOR, &toy::motion(10));
        let poses = measure_poses(&toy::BASE, &meshes).unwrap();
        let unposed = unpose_meshes(&toy::BASE, &meshes, &poses, Keep::PoseShapes).unwrap();
        let node: FitPoseShapes = made(json!({}));
        let inputs =
            Inputs::default().with(&RIG, toy::BASE.clone()).with(&MESHES, unposed.clone()).with(&POSES, poses.clone());
        let outputs = compute(&node, &inputs).unwrap();
        let rig = outputs.get(&CORRECTED).unwrap();
        assert_eq!(rig.shapes.len(), 12 + 27);
        let left = unpose_meshes(rig, &meshes, &poses, Keep::Strains).unwrap();
        let size = |meshes: &Meshes| -> f64 {
            (0..meshes.frames())
                .flat_map(|frame| meshes.frame(frame).iter().zip(&rig.neutral))
                .map(|(a, b)| f64::from(a.distance_squared(*b)))
                .sum()
        };
        assert!(size(&left) < 0.95 * size(&unposed), "{} {}", size(&left), size(&unposed));
        assert!(compute(&node, &inputs.with(&RIG, toy::ACTOR.clone())).is_err());
    }
}
