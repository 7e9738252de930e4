//! `add_joints`: a head's surface with a jaw and eyes as joints; where a strain rig begins.

use crate::patterns::Patterns;
use face_math::data::Rig;
use face_math::strain::{JointOptions, add_joints};
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> =
    Port::new("rig", "a head; its own skin (or its split jaw) tells who follows the jaw to begin with");
const BASE: Port<Rig> = Port::new(
    "rig",
    "the same surface with joints and no shapes: its channels are `jaw_turn_x_rad`, `jaw_move_y_m` and so on, the pose itself",
);

/// Gives a head a jaw and two eyes that turn as joints, with their poses as channels, and takes all shapes off.
///
/// A joint is known by parts that follow it wholly: the lower teeth, an eyeball. Angles are radians about the fixed axes x,
/// then y, then z; translations are metres.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AddJoints {
    /// Parts that only the jaw moves, as patterns.
    jaw_parts: Vec<String>,
    /// Parts that only the left eye turns, as patterns. No such joint where empty.
    left_eye_parts: Vec<String>,
    /// Parts that only the right eye turns, as patterns. No such joint where empty.
    right_eye_parts: Vec<String>,
    /// Where the jaw turns, in metres. Where not given, the jaw joint of the head's own skin, or else the middle of a ball
    /// through the jaw's parts.
    jaw_pivot_m: Option<[f32; 3]>,
}

impl Default for AddJoints {
    fn default() -> Self {
        let one = |part: &str| vec![part.to_owned()];
        Self {
            jaw_parts: one("teeth_lower"),
            left_eye_parts: one("eyeball_L"),
            right_eye_parts: one("eyeball_R"),
            jaw_pivot_m: None,
        }
    }
}

graph_core::register!(AddJoints);

#[typetag::serde(name = "add_joints")]
impl Node for AddJoints {
    fn card(&self) -> Card {
        Card::new("strain").takes(&RIG).gives(&BASE)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let rig = inputs.get(&RIG)?;
        let names: Vec<String> = rig.parts.iter().map(|part| part.name.clone()).collect();
        if self.jaw_parts.is_empty() {
            return Err(NodeError::parameter(
                "jaw_parts",
                "name a part that only the jaw moves, such as `teeth_lower`",
            ));
        }
        let mut joints = Vec::new();
        for (name, parameter, patterns) in [
            ("jaw", "jaw_parts", &self.jaw_parts),
            ("eye_L", "left_eye_parts", &self.left_eye_parts),
            ("eye_R", "right_eye_parts", &self.right_eye_parts),
        ] {
            if !patterns.is_empty() {
                let parts = Patterns { parameter, what: "part", names: &names }.chosen(patterns)?;
                let pivot_m = self.jaw_pivot_m.filter(|_| name == "jaw").map(Vec3::from);
                joints.push(JointOptions { name: name.to_owned(), parts, moves: name == "jaw", pivot_m });
            }
        }
        let base = add_joints(rig, &joints).map_err(|error| NodeError::input(RIG.name(), error))?;
        Ok(Outputs::default().with(&BASE, base))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    #[test]
    fn the_sample_head_gains_three_joints() {
        let node: AddJoints = made(json!({}));
        let outputs = compute(&node, &Inputs::default().with(&RIG, toy::ACTOR.clone())).unwrap();
        let base = outputs.get(&BASE).unwrap();
        assert_eq!((base, base.channels.len()), (&*toy::BASE, 12));
        let wrong: AddJoints = made(json!({"jaw_parts": ["teeth_lowre"]}));
        let error = compute(&wrong, &Inputs::default().with(&RIG, toy::ACTOR.clone())).unwrap_err().to_string();
        assert!(error.contains("did you mean `teeth_lower`?"), "{error}");
    }
}
