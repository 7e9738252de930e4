//! `node_name`: says in one line what it does to what.

use face_math::data::Curves;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RAW: Port<Curves> = Port::new("curves", "one weight per channel and frame");
const SCALED: Port<Curves> = Port::new("curves", "the same channels and frames, scaled");

/// Scales every curve.
///
/// The first sentence stands in lists of nodes; all of it is the manual: what the node is for, what it assumes of its
/// inputs, and which published method it follows.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NodeName {
    /// The factor, unitless. Say what less and more of it do.
    #[schemars(range(min = -10.0, max = 10.0))]
    gain: f64,
}

impl Default for NodeName {
    fn default() -> Self {
        Self { gain: 1.0 }
    }
}

graph_core::register!(NodeName);

#[typetag::serde(name = "node_name")]
impl Node for NodeName {
    fn card(&self) -> Card {
        Card::new("clean").takes(&RAW).gives(&SCALED).per_frame(0)
    }

    /// y = g x, with x and y the weights before and after, and g the gain, all unitless.
    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let raw = inputs.get(&RAW)?;
        let values = raw.values().iter().map(|weight| weight * self.gain as f32).collect();
        let scaled = Curves::new(raw.frame_axis(), raw.channels().to_vec(), values);
        Ok(Outputs::default().with(&SCALED, scaled.map_err(NodeError::failed)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use serde_json::json;
    use wire::FrameAxis;

    #[test]
    fn weights_are_scaled() {
        let axis = FrameAxis::new(2, 60.0);
        let raw = Curves::new(axis, vec!["jawOpen".to_owned()], vec![0.25, 0.5]).unwrap();
        let node: NodeName = made(json!({"gain": 2.0}));
        let outputs = compute(&node, &Inputs::default().with(&RAW, raw)).unwrap();
        assert_eq!(outputs.get(&SCALED).unwrap().values(), [0.5, 1.0]);
    }
}
