//! `marker_scores`: how far the puppet's markers are from the captured ones over a whole take; a number to compare solves by.

use crate::values::Scores;
use face_math::data::{Attachment, Curves, Markers, Rig};
use face_math::rig::MarkerRig;
use face_math::solve::marker_error;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CURVES: Port<Curves> = Port::new("curves", "a solve: weights of every channel of the rig");
const MARKERS: Port<Markers> = Port::new("markers", "the markers that it should meet, in metres");
const RIG: Port<Rig> = Port::new("rig", "the puppet");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where the markers sit on it");
const SCORES: Port<Scores> =
    Port::new("scores", "root mean square distance in millimetres over all frames and markers, and of each marker");

/// Measures the distance between the puppet's markers and the captured ones over all frames.
///
/// A distance is that of two points in space; markers that are missing in a frame, or that the rig or the take lacks, are
/// passed over. For the error of each frame there is `marker_error`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MarkerScores {}

graph_core::register!(MarkerScores);

#[typetag::serde(name = "marker_scores")]
impl Node for MarkerScores {
    fn card(&self) -> Card {
        Card::new("solve").takes(&CURVES).takes(&MARKERS).takes(&RIG).takes(&ATTACHMENT).gives(&SCORES)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let puppet = MarkerRig::attached(inputs.get(&RIG)?, inputs.get(&ATTACHMENT)?)
            .map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let posed = puppet.drive(inputs.get(&CURVES)?).map_err(|error| NodeError::input(CURVES.name(), error))?;
        context.go_on()?;
        let error =
            marker_error(&posed, inputs.get(&MARKERS)?).map_err(|error| NodeError::input(MARKERS.name(), error))?;
        let seen = error.by_marker_mm.into_iter().filter_map(|(name, apart)| Some((name, apart?)));
        let what = "root mean square distance of markers in mm".to_owned();
        let scores = Scores { what, overall: error.rms_mm, by_name: seen.collect() };
        Ok(Outputs::default().with(&SCORES, scores))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::compute;
    use glam::Vec3;

    fn measure(curves: &Curves, markers: Markers) -> Result<Scores, String> {
        let inputs = Inputs::default()
            .with(&CURVES, curves.clone())
            .with(&MARKERS, markers)
            .with(&RIG, toy::rig())
            .with(&ATTACHMENT, toy::attachment());
        let outputs = compute(&MarkerScores {}, &inputs).map_err(|error| error.to_string())?;
        Ok(outputs.get(&SCORES).unwrap().clone())
    }

    #[test]
    fn the_mean_is_over_markers_and_frames_that_are_seen() {
        let curves = toy::curves(2, 1);
        let exact = MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap().drive(&curves).unwrap();
        let (count, mut positions) = (exact.names().len(), exact.positions().to_vec());
        positions[0] += Vec3::new(0.001, 0.002, 0.002);
        positions[1] = Vec3::NAN;
        let scores = measure(&curves, exact.with_positions(positions).unwrap()).unwrap();
        let expected = (9.0 / (2 * count - 1) as f64).sqrt();
        assert!((scores.overall - expected).abs() < 1e-3, "{} beside {expected}", scores.overall);
        assert!((scores.by_name[0].1 - (9.0_f64 / 2.0).sqrt()).abs() < 1e-3, "{:?}", scores.by_name[0]);
        assert!(scores.by_name[1].1 < 1e-3 && scores.by_name.len() == count);
    }

    #[test]
    fn other_frames_are_refused() {
        let exact = MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap().drive(&toy::curves(3, 1)).unwrap();
        let error = measure(&toy::curves(2, 1), exact).unwrap_err();
        assert!(error.contains("input `markers`"), "{error}");
    }
}
