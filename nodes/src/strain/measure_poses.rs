//! `measure_poses`: where the joints of a strain rig stand in animated meshes.

use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::{StrainError, measure_poses};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a head with joints (`add_joints`)");
const MESHES: Port<Meshes> = Port::new("meshes", "its animated meshes, in metres");
const POSES: Port<Curves> =
    Port::new("poses", "the pose of every joint, in radians and metres, as channels of the rig");

/// Measures the pose of every joint by the parts that follow it wholly: the rigid motion nearest to them.
///
/// Meshes without such parts (a face alone) have their jaw solved by `solve_jaw_pose`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeasurePoses {}

graph_core::register!(MeasurePoses);

#[typetag::serde(name = "measure_poses")]
impl Node for MeasurePoses {
    fn card(&self) -> Card {
        Card::new("strain").takes(&RIG).takes(&MESHES).gives(&POSES).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let poses = measure_poses(inputs.get(&RIG)?, inputs.get(&MESHES)?).map_err(|error| match error {
            StrainError::NoJoints { .. } | StrainError::NothingRigid { .. } => NodeError::input(RIG.name(), error),
            _ => NodeError::input(MESHES.name(), error),
        })?;
        Ok(Outputs::default().with(&POSES, poses))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::compute;

    #[test]
    fn an_open_mouth_is_a_turned_jaw() {
        let curves = toy::motion(20);
        let meshes = toy::evaluated(&toy::ACTOR, &curves);
        let inputs = Inputs::default().with(&RIG, toy::BASE.clone()).with(&MESHES, meshes.clone());
        let outputs = compute(&MeasurePoses {}, &inputs).unwrap();
        let poses = outputs.get(&POSES).unwrap();
        let widest = |column: usize, curves: &Curves| {
            let at = |frame: &usize| curves.frame(*frame)[column];
            (0..curves.frames()).max_by(|a, b| at(a).total_cmp(&at(b))).map(|frame| (frame, at(&frame))).unwrap()
        };
        let (frame, angle) = widest(poses.index("jaw_turn_x_rad").unwrap(), poses);
        assert!(angle > 0.15, "{angle}");
        assert_eq!(frame, widest(curves.index("jawOpen").unwrap(), &curves).0);
        let bare = Inputs::default().with(&RIG, toy::ACTOR.clone()).with(&MESHES, meshes);
        assert!(compute(&MeasurePoses {}, &bare).is_err());
    }
}
