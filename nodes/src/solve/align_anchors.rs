//! `align_anchors`: moves a take's markers onto the puppet by anchor poses, without training again (Eq. 5 of FDLS).

use crate::values::Anchors;
use face_math::data::Markers;
use face_math::solve::{AlignError, AlignOptions, align_anchors};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "the take, in metres");
const ANCHORS: Port<Anchors> = Port::new("anchors", "the anchor poses of this take");
const ALIGNED: Port<Markers> = Port::new("markers", "the take, moved towards the puppet, in metres");

/// Moves the markers of a take by what separates them from the puppet at the anchors: for masks that sit a little off, and
/// faces that have changed.
///
/// The first anchor's offsets apply to all frames alike, those of further ones to the frames that look like them. Markers
/// that an anchor does not show, or that the puppet lacks, keep their place.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AlignAnchors {
    /// How far a frame may be from a further anchor for it to count 37 %: root mean square distance of the markers in
    /// millimetres. Smaller keeps each anchor to itself.
    #[schemars(range(min = 0.001, max = 1000.0))]
    falloff_mm: f64,
}

impl Default for AlignAnchors {
    fn default() -> Self {
        Self { falloff_mm: AlignOptions::default().falloff_mm }
    }
}

graph_core::register!(AlignAnchors);

#[typetag::serde(name = "align_anchors")]
impl Node for AlignAnchors {
    fn card(&self) -> Card {
        Card::new("solve").takes(&MARKERS).takes(&ANCHORS).gives(&ALIGNED).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (take, anchors) = (inputs.get(&MARKERS)?, inputs.get(&ANCHORS)?);
        let options = AlignOptions { falloff_mm: self.falloff_mm };
        let aligned = align_anchors(take, anchors.captured(), anchors.puppet(), &options);
        let aligned = aligned.map_err(|error| match error {
            AlignError::Falloff { .. } => NodeError::parameter("falloff_mm", error),
            other => NodeError::input(ANCHORS.name(), other),
        })?;
        Ok(Outputs::default().with(&ALIGNED, aligned.markers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use face_math::rig::MarkerRig;
    use glam::Vec3;
    use serde_json::json;

    fn exact(frames: usize) -> Markers {
        MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap().drive(&toy::curves(frames, 4)).unwrap()
    }

    /// The toy's markers, each moved by an offset of its own.
    fn shifted(exact: &Markers) -> Markers {
        let mut dice = toy::Dice(9);
        let offsets: Vec<Vec3> = exact.names().iter().map(|_| dice.point() * 0.002).collect();
        let moved = exact.positions().iter().enumerate().map(|(place, point)| *point + offsets[place % offsets.len()]);
        exact.with_positions(moved.collect()).unwrap()
    }

    fn anchors(take: &Markers, puppet: &Markers, frames: &[usize]) -> Anchors {
        let pick = |markers: &Markers| {
            let positions = frames.iter().flat_map(|frame| markers.frame(*frame).iter().copied()).collect();
            Markers::new(Anchors::axis(frames.len()), markers.names().to_vec(), positions).unwrap()
        };
        let numbers = frames.iter().map(|frame| crate::rig::frame_number(take.frame_axis(), *frame)).collect();
        Anchors::new(numbers, pick(take), pick(puppet)).unwrap()
    }

    fn align(take: Markers, anchors: Anchors) -> Result<Markers, String> {
        let node: AlignAnchors = made(json!({"falloff_mm": 2.0}));
        let outputs = compute(&node, &Inputs::default().with(&MARKERS, take).with(&ANCHORS, anchors));
        outputs.map(|outputs| outputs.get(&ALIGNED).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn one_anchor_undoes_a_mask_that_sits_off() {
        let exact = exact(8);
        let take = shifted(&exact);
        let aligned = align(take.clone(), anchors(&take, &exact, &[3])).unwrap();
        for (found, known) in aligned.positions().iter().zip(exact.positions()) {
            assert!(found.abs_diff_eq(*known, 1e-6));
        }
    }

    #[test]
    fn blocks_equal_the_whole() {
        let exact = exact(9);
        let take = shifted(&exact);
        let anchors = anchors(&take, &exact, &[1, 6]);
        let block = align(toy::cut(&take, 2..7), anchors.clone()).unwrap();
        assert!(toy::same_bits(&align(take, anchors).unwrap(), 2..7, &block));
    }

    #[test]
    fn anchors_of_another_take_are_refused() {
        let exact = exact(3);
        let some = exact.pick(&exact.names()[1..]).unwrap();
        let error = align(exact.clone(), anchors(&some, &exact, &[0])).unwrap_err();
        assert!(error.contains("`anchors`") && error.contains("`m0`"), "{error}");
    }
}
