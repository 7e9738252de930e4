//! `select_salient`: thins training motion where frames are alike (section 4.2 of FDLS).

use crate::rig::frame_number;
use face_math::data::{Curves, Markers};
use face_math::solve::{SalienceOptions, select_salient};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wire::FrameAxis;

const MARKERS: Port<Markers> = Port::new("markers", "the markers of the training motion, in metres");
const CURVES: Port<Curves> = Port::new("curves", "the weights that made them");
const CHOSEN: Port<Markers> = Port::new("markers", "the markers of the frames that stay, in metres");
const WEIGHTS: Port<Curves> = Port::new("curves", "their weights");
const SALIENCE: Port<Curves> = Port::new(
    "salience",
    "for every frame that came in: its mean likeness to all frames (`likeness`, 0 to 1), and whether it stays (`kept`, 0 or 1)",
);

/// Drops training frames that say what others say already, so that a network does not spend itself on the resting face.
///
/// A frame stays where its mean likeness to the frames is below `sigma` (Eq. 3 of FDLS). The frame most like the others
/// goes first, the means are taken anew, and so on until the rule holds for all that are left: a frequent pose is thinned,
/// never lost.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SelectSalient {
    /// The threshold: 1 keeps every frame that differs from the others, 0 keeps one. The paper found 0.3 best for one actor
    /// and 0.1 and 0.5 worse, so try it for yours.
    #[schemars(range(min = 0.0, max = 1.0))]
    sigma: f64,
    /// The distance at which two frames count as alike to 61 %, over all markers together, in millimetres: √(Σ Δx²). Left
    /// out, it is a quarter of the typical distance between two of the frames.
    #[schemars(range(min = 0.000_001, max = 1_000_000.0))]
    bandwidth_mm: Option<f64>,
}

impl Default for SelectSalient {
    fn default() -> Self {
        Self { sigma: 0.3, bandwidth_mm: None }
    }
}

graph_core::register!(SelectSalient);

#[typetag::serde(name = "select_salient")]
impl Node for SelectSalient {
    fn card(&self) -> Card {
        Card::new("solve").takes(&MARKERS).takes(&CURVES).gives(&CHOSEN).gives(&WEIGHTS).gives(&SALIENCE)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (markers, curves) = (inputs.get(&MARKERS)?, inputs.get(&CURVES)?);
        let axis = markers.frame_axis();
        axis.matches(&curves.frame_axis()).map_err(|error| NodeError::input(CURVES.name(), error))?;
        complete(markers)?;
        let samples: Vec<f32> = markers.positions().iter().flat_map(glam::Vec3::to_array).collect();
        let options =
            SalienceOptions { threshold: self.sigma, bandwidth: self.bandwidth_mm.map(|bandwidth| bandwidth / 1000.0) };
        let salience = select_salient(&samples, 3 * markers.names().len(), &options)
            .map_err(|error| NodeError::input(MARKERS.name(), error))?;
        context.progress(
            1.0,
            &[
                ("kept", salience.kept.len() as f64),
                ("of", axis.count as f64),
                ("bandwidth mm", salience.bandwidth * 1000.0),
            ],
        );
        let mut told: Vec<f32> = salience.means.iter().flat_map(|mean| [*mean as f32, 0.0]).collect();
        for frame in &salience.kept {
            told[2 * frame + 1] = 1.0;
        }
        let kept = FrameAxis { count: salience.kept.len(), ..axis };
        let positions = salience.kept.iter().flat_map(|frame| markers.frame(*frame).iter().copied()).collect();
        let values = salience.kept.iter().flat_map(|frame| curves.frame(*frame).iter().copied()).collect();
        Ok(Outputs::default()
            .with(&CHOSEN, Markers::new(kept, markers.names().to_vec(), positions).map_err(NodeError::failed)?)
            .with(&WEIGHTS, Curves::new(kept, curves.channels().to_vec(), values).map_err(NodeError::failed)?)
            .with(
                &SALIENCE,
                Curves::new(axis, vec!["likeness".into(), "kept".into()], told).map_err(NodeError::failed)?,
            ))
    }
}

/// Refuses markers with gaps, since a frame with a gap is like no other.
fn complete(markers: &Markers) -> Result<(), NodeError> {
    let width = markers.names().len().max(1);
    let Some(place) = markers.positions().iter().position(|point| !point.is_finite()) else { return Ok(()) };
    let (marker, frame) = (&markers.names()[place % width], frame_number(markers.frame_axis(), place / width));
    Err(NodeError::input(MARKERS.name(), format!("marker `{marker}` is missing in frame {frame}; fill the gaps first")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use glam::Vec3;
    use serde_json::json;

    /// Forty frames of rest and ten that differ, weights counting the frames.
    fn take() -> (Markers, Curves) {
        let mut dice = toy::Dice(3);
        let axis = FrameAxis { first: 5, count: 50, rate_hz: 60.0 };
        let positions = (0..100).map(|place| dice.point() * if place < 80 { 1e-5 } else { 0.1 }).collect();
        let markers = Markers::new(axis, vec!["a".into(), "b".into()], positions).unwrap();
        let curves = Curves::new(axis, vec!["frame".into()], (0..50).map(|frame| frame as f32).collect()).unwrap();
        (markers, curves)
    }

    fn select(parameters: serde_json::Value, (markers, curves): (Markers, Curves)) -> Result<Outputs, String> {
        let node: SelectSalient = made(parameters);
        compute(&node, &Inputs::default().with(&MARKERS, markers).with(&CURVES, curves))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn rest_is_thinned_and_weights_stay_with_their_markers() {
        let (markers, curves) = take();
        let outputs = select(json!({"bandwidth_mm": 10.0}), (markers.clone(), curves)).unwrap();
        let (chosen, weights) = (outputs.get(&CHOSEN).unwrap(), outputs.get(&WEIGHTS).unwrap());
        assert_eq!(chosen.frames(), weights.frames());
        let frames: Vec<usize> = weights.values().iter().map(|frame| *frame as usize).collect();
        assert!(frames.len() < 20 && (40..50).all(|frame| frames.contains(&frame)), "{frames:?}");
        for (place, frame) in frames.iter().enumerate() {
            assert_eq!(chosen.frame(place), markers.frame(*frame));
        }
        let salience = outputs.get(&SALIENCE).unwrap();
        assert_eq!(salience.frames(), 50);
        for frame in 0..50 {
            assert_eq!(salience.frame(frame)[1] > 0.5, frames.contains(&frame));
        }
        assert!(salience.frame(3)[0] > 0.7 && salience.frame(45)[0] < 0.1);
    }

    #[test]
    fn sigma_of_one_keeps_all() {
        let outputs = select(json!({"sigma": 1.0}), take()).unwrap();
        assert_eq!(outputs.get(&CHOSEN).unwrap().frames(), 50);
    }

    #[test]
    fn gaps_and_other_frames_are_refused() {
        let (markers, curves) = take();
        let mut positions = markers.positions().to_vec();
        positions[7] = Vec3::NAN;
        let gappy = markers.with_positions(positions).unwrap();
        let error = select(json!({}), (gappy, curves.clone())).err().unwrap();
        assert!(error.contains("`b` is missing in frame 8"), "{error}");
        let error = select(json!({}), (toy::cut(&markers, 0..9), curves)).err().unwrap();
        assert!(error.contains("9 frames beside 50 frames"), "{error}");
    }
}
