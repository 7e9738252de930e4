//! `synthesize_markers`: the puppet's markers under given curves, x = g(w) of FDLS; training data, and what solves are
//! measured against.

use face_math::data::{Attachment, Curves, Markers, Rig};
use face_math::rig::MarkerRig;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "the head that carries the markers, in metres");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where the markers sit on it");
const CURVES: Port<Curves> =
    Port::new("curves", "weights of every channel of the rig, one value a frame; other channels are passed over");
const MARKERS: Port<Markers> = Port::new("markers", "the attached markers in every frame, in metres");

/// Moves attached markers as the rig moves its surface.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SynthesizeMarkers {}

graph_core::register!(SynthesizeMarkers);

#[typetag::serde(name = "synthesize_markers")]
impl Node for SynthesizeMarkers {
    fn card(&self) -> Card {
        Card::new("rig").takes(&RIG).takes(&ATTACHMENT).takes(&CURVES).gives(&MARKERS).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let puppet = MarkerRig::attached(inputs.get(&RIG)?, inputs.get(&ATTACHMENT)?);
        let puppet = puppet.map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let markers = puppet.drive(inputs.get(&CURVES)?).map_err(|error| NodeError::input(CURVES.name(), error))?;
        Ok(Outputs::default().with(&MARKERS, markers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::compute;
    use face_math::rig::Puppet;
    use glam::Vec3;

    fn synthesize(curves: Curves) -> Result<Markers, String> {
        let inputs =
            Inputs::default().with(&RIG, toy::rig()).with(&ATTACHMENT, toy::attachment()).with(&CURVES, curves);
        let outputs = compute(&SynthesizeMarkers {}, &inputs);
        outputs.map(|outputs| outputs.get(&MARKERS).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn markers_ride_on_the_surface() {
        let (rig, attachment, curves) = (toy::rig(), toy::attachment(), toy::curves(4, 1));
        let markers = synthesize(curves.clone()).unwrap();
        assert_eq!(markers.names(), attachment.names());
        let vertices = Puppet::new(&rig).unwrap().vertices(curves.frame(3)).unwrap();
        for (point, found) in attachment.points.iter().zip(markers.frame(3)) {
            let corners = point.vertices.iter().zip(point.weights);
            let expected: Vec3 = corners.map(|(vertex, weight)| weight * vertices[*vertex as usize]).sum();
            assert!(found.abs_diff_eq(expected, 1e-7));
        }
    }

    #[test]
    fn blocks_equal_the_whole() {
        let curves = toy::curves(9, 2);
        let block = synthesize(toy::cut(&curves, 3..8)).unwrap();
        assert!(toy::same_bits(&synthesize(curves).unwrap(), 3..8, &block));
    }

    #[test]
    fn missing_channels_are_named() {
        let curves = toy::curves(2, 3);
        let some = curves.arrange(&curves.channels()[..3], None).unwrap();
        let error = synthesize(some).unwrap_err();
        assert!(error.contains("`curves`") && error.contains("browUp"), "{error}");
    }
}
