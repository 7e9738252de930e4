//! `find_anchor`: the first anchor of a take without a hand: where its markers sit on the puppet that day, told by the whole
//! take. `align_anchors` moves the take by it, frame by frame.

use crate::rig::frame_number;
use crate::values::Anchors;
use face_math::data::{Attachment, MarkerNoise, Markers, NoiseOfMarker, Rig};
use face_math::rig::MarkerRig;
use face_math::solve::{FindAnchorError, FindAnchorOptions, find_anchor};
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "the take, in metres, the head held still");
const RIG: Port<Rig> = Port::new("rig", "the puppet");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where the markers sit on it");
const ANCHORS: Port<Anchors> = Port::new(
    "anchors",
    "one anchor: the take's most neutral frame of those looked at, the puppet's pose there, and the markers there as the \
     whole take has them (without the noise of that frame)",
);
const REMAINDER: Port<MarkerNoise> = Port::new(
    "remainder",
    "how far each marker stays from the puppet once all is aligned: its noise, and what the puppet cannot follow",
);

/// Finds the offsets between a take and the puppet, for a mask that sits a little off and a face that has changed, and gives
/// them as an anchor at the take's most neutral frame.
///
/// Offsets stay over the take while expressions come and go, and weights are never negative: so both are told together, from
/// frames all over the take, and the face need not be at rest in any of them. An expression that lasts the whole take is
/// taken for the face. Where the markers sit on the puppet as they are, the offsets are 0.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FindAnchor {
    /// How many frames are looked at, spread evenly over the take.
    #[schemars(range(min = 1, max = 10_000))]
    frames: usize,
    /// What weights are on the average. Smaller takes more of what is seen for offsets, larger for expression.
    #[schemars(range(min = 0.000_1, max = 100.0))]
    usual_weight: f64,
    /// The largest weight.
    #[schemars(range(min = 0.001, max = 100.0))]
    high: f64,
    /// Offsets below this count as none, and the take stays as it is: root mean square over the markers, in millimetres.
    #[schemars(range(min = 0.0, max = 1000.0))]
    least_offset_mm: f64,
}

impl Default for FindAnchor {
    fn default() -> Self {
        let FindAnchorOptions { samples, usual_weight, high, least_offset_mm } = FindAnchorOptions::default();
        Self { frames: samples, usual_weight, high, least_offset_mm }
    }
}

graph_core::register!(FindAnchor);

#[typetag::serde(name = "find_anchor")]
impl Node for FindAnchor {
    fn card(&self) -> Card {
        Card::new("solve").takes(&MARKERS).takes(&RIG).takes(&ATTACHMENT).gives(&ANCHORS).gives(&REMAINDER)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let take = inputs.get(&MARKERS)?;
        let puppet = MarkerRig::attached(inputs.get(&RIG)?, inputs.get(&ATTACHMENT)?)
            .map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let Self { frames, usual_weight, high, least_offset_mm } = *self;
        let options = FindAnchorOptions { samples: frames, usual_weight, high, least_offset_mm };
        let found = find_anchor(&puppet, take, &options).map_err(|error| match error {
            FindAnchorError::Option { .. } | FindAnchorError::Minimise(_) => NodeError::failed(error),
            _ => NodeError::input(MARKERS.name(), error),
        })?;
        let frame = frame_number(take.frame_axis(), found.frame);
        context.progress(1.0, &[("frame", frame as f64), ("offsets mm", found.spread_mm)]);
        // x = g(w) + d, so that aligning takes d off.
        let placed = |name: &String| {
            let place = puppet.names().iter().position(|own| own == name)?;
            Some(found.posed[place] + found.offsets[place]?)
        };
        let captured = take.names().iter().map(|name| placed(name).unwrap_or(Vec3::NAN)).collect();
        let axis = Anchors::axis(1);
        let captured = Markers::new(axis, take.names().to_vec(), captured).map_err(NodeError::failed)?;
        let posed = Markers::new(axis, puppet.names().to_vec(), found.posed).map_err(NodeError::failed)?;
        let remainder = puppet.names().iter().zip(found.remaining_mm).zip(&found.offsets);
        let remainder = remainder.filter(|(_, offset)| offset.is_some());
        let remainder = remainder.map(|((name, sigma_mm), _)| NoiseOfMarker { marker: name.clone(), sigma_mm });
        let anchors = Anchors::new(vec![frame], captured, posed).map_err(NodeError::failed)?;
        let remainder = MarkerNoise::new(remainder.collect()).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&ANCHORS, anchors).with(&REMAINDER, remainder))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::compute;
    use face_math::data::Curves;

    const OFF: Vec3 = Vec3::new(0.002, -0.001, 0.0);

    /// The toy's markers in a performance in which each channel rests now and then, off by [`OFF`], and a marker that the
    /// puppet lacks.
    fn take() -> Markers {
        let curves = toy::curves(60, 6);
        let values = curves.values().iter().map(|weight| (weight - 0.5).max(0.0)).collect();
        let curves = Curves::new(curves.frame_axis(), curves.channels().to_vec(), values).unwrap();
        let exact = MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap().drive(&curves).unwrap();
        let names = exact.names().iter().cloned().chain(["other".to_owned()]).collect();
        let frames = (0..60).flat_map(|t| exact.frame(t).iter().map(|point| *point + OFF).chain([Vec3::ONE]));
        Markers::new(exact.frame_axis(), names, frames.collect()).unwrap()
    }

    #[test]
    fn the_anchor_holds_the_offsets_of_the_take() {
        let inputs =
            Inputs::default().with(&MARKERS, take()).with(&RIG, toy::rig()).with(&ATTACHMENT, toy::attachment());
        let outputs = compute(&FindAnchor::default(), &inputs).unwrap();
        let anchors = outputs.get(&ANCHORS).unwrap();
        assert_eq!(anchors.frames().len(), 1);
        assert!((101..161).contains(&anchors.frames()[0]));
        let offsets = anchors.offsets(0);
        assert_eq!(offsets.len(), 12);
        for (marker, offset) in offsets {
            assert!(offset.abs_diff_eq(OFF, 5e-4), "{marker}: {offset}");
        }
        assert!(outputs.get(&REMAINDER).unwrap().sigma_mm("m0").unwrap() < 0.2);
        assert!(outputs.get(&REMAINDER).unwrap().sigma_mm("other").is_none());
    }

    #[test]
    fn a_take_of_other_markers_is_refused() {
        let strangers = Markers::new(wire::FrameAxis::new(1, 60.0), vec!["x".into()], vec![Vec3::ZERO]).unwrap();
        let inputs =
            Inputs::default().with(&MARKERS, strangers).with(&RIG, toy::rig()).with(&ATTACHMENT, toy::attachment());
        assert!(compute(&FindAnchor::default(), &inputs).unwrap_err().to_string().contains("share no marker"));
    }
}
