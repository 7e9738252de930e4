//! `curve_error`: how far solved weights are from known ones; for tests of a set-up, where the truth is known.

use crate::values::Scores;
use face_math::data::Curves;
use face_math::solve::{MeasureError, weight_error};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CURVES: Port<Curves> = Port::new("curves", "solved weights");
const TRUTH: Port<Curves> = Port::new("truth", "the weights that they should be");
const ERROR: Port<Curves> =
    Port::new("error", "`rms`: root mean square difference over the channels of the truth, in each frame");
const SCORES: Port<Scores> =
    Port::new("scores", "root mean square difference over all frames and channels of the truth, and of each channel");

/// Measures solved weights against known ones, over the channels and frames of the known ones.
///
/// The summary of `scores` tells the overall root mean square and the worst channels.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CurveError {}

graph_core::register!(CurveError);

#[typetag::serde(name = "curve_error")]
impl Node for CurveError {
    fn card(&self) -> Card {
        Card::new("solve").takes(&CURVES).takes(&TRUTH).gives(&ERROR).gives(&SCORES)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (curves, truth) = (inputs.get(&CURVES)?, inputs.get(&TRUTH)?);
        let error = weight_error(truth, curves).map_err(|error| match error {
            MeasureError::NothingShared => NodeError::input(TRUTH.name(), error),
            _ => NodeError::input(CURVES.name(), error),
        })?;
        let solved = curves.arrange(truth.channels(), None).map_err(|error| NodeError::input(CURVES.name(), error))?;
        let rms = (0..truth.frames()).map(|frame| {
            let pairs = truth.frame(frame).iter().zip(solved.frame(frame));
            let squares: f64 = pairs.map(|(known, found)| (f64::from(*known) - f64::from(*found)).powi(2)).sum();
            (squares / truth.channels().len() as f64).sqrt() as f32
        });
        let rms = Curves::new(curves.frame_axis(), vec!["rms".to_owned()], rms.collect()).map_err(NodeError::failed)?;
        let scores = Scores {
            what: "root mean square difference of weights".to_owned(),
            overall: error.rms,
            by_name: error.by_channel,
        };
        Ok(Outputs::default().with(&ERROR, rms).with(&SCORES, scores))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::compute;
    use wire::{FrameAxis, Value};

    fn curves(channels: &[&str], values: Vec<f32>) -> Curves {
        let axis = FrameAxis::new(values.len() / channels.len(), 60.0);
        Curves::new(axis, channels.iter().map(|channel| (*channel).to_owned()).collect(), values).unwrap()
    }

    #[test]
    fn the_overall_error_is_that_over_frames_and_channels() {
        let truth = curves(&["a", "b"], vec![0.0, 0.5, 1.0, 0.5]);
        let solved = curves(&["b", "extra", "a"], vec![0.5, 9.0, 0.3, 0.1, 9.0, 1.0]);
        let outputs = compute(&CurveError {}, &Inputs::default().with(&TRUTH, truth).with(&CURVES, solved)).unwrap();
        let scores = outputs.get(&SCORES).unwrap();
        assert!((scores.overall - 0.25).abs() < 1e-6);
        assert!(scores.summary().starts_with("root mean square difference of weights 0.25"), "{}", scores.summary());
        let error = outputs.get(&ERROR).unwrap();
        assert!((error.frame(0)[0] - 0.3 / 2.0_f32.sqrt()).abs() < 1e-6);
        assert!((error.frame(1)[0] - 0.4 / 2.0_f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let truth = toy::curves(4, 1);
        let fault = |solved: Curves| {
            let inputs = Inputs::default().with(&TRUTH, truth.clone()).with(&CURVES, solved);
            compute(&CurveError {}, &inputs).unwrap_err().to_string()
        };
        assert!(fault(toy::cut(&truth, 0..3)).contains("4 frames beside 3 frames"));
        assert!(fault(truth.arrange(&truth.channels()[1..], None).unwrap()).contains("no channel `jawOpen`"));
    }
}
