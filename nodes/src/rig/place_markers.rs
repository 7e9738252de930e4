//! `place_markers`: where attached markers sit on the rig at rest: a neutral face without the noise of a measured one.

use face_math::data::{Attachment, Markers, Rig};
use face_math::rig::{MarkerPose, MarkerRig};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wire::FrameAxis;

const RIG: Port<Rig> = Port::new("rig", "the head that carries the markers, in metres");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where the markers sit on it");
const MARKERS: Port<Markers> =
    Port::new("markers", "one frame: the attached markers with every channel at 0, in metres");

/// Gives the places of attached markers on the rig at rest.
///
/// They lie on the rig's surface, where measured neutral markers lie off it by their noise. Head markers are best held to
/// these (`stabilize_head`): what they are off moves the whole face.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PlaceMarkers {}

graph_core::register!(PlaceMarkers);

#[typetag::serde(name = "place_markers")]
impl Node for PlaceMarkers {
    fn card(&self) -> Card {
        Card::new("rig").takes(&RIG).takes(&ATTACHMENT).gives(&MARKERS)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let puppet = MarkerRig::attached(inputs.get(&RIG)?, inputs.get(&ATTACHMENT)?)
            .map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let mut pose = MarkerPose::default();
        puppet.pose(&vec![0.0; puppet.channels().len()], &mut pose);
        let positions = pose.positions().iter().map(|point| point.as_vec3()).collect();
        let markers = Markers::new(FrameAxis::new(1, 1.0), puppet.names().to_vec(), positions);
        Ok(Outputs::default().with(&MARKERS, markers.map_err(NodeError::failed)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::compute;

    #[test]
    fn they_are_where_they_were_attached() {
        let inputs = Inputs::default().with(&RIG, toy::rig()).with(&ATTACHMENT, toy::attachment());
        let outputs = compute(&PlaceMarkers {}, &inputs).unwrap();
        let (found, neutral) = (outputs.get(&MARKERS).unwrap(), toy::neutral());
        assert_eq!((found.frames(), found.names()), (1, neutral.names()));
        for (own, rest) in found.positions().iter().zip(neutral.positions()) {
            assert!(own.abs_diff_eq(*rest, 1e-6));
        }
    }
}
