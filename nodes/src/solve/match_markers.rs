//! `match_markers`: weights from markers by a quadratic programme (Eq. 2 of FDLS); a solve without training, and what others
//! are compared with.

use face_math::data::{Attachment, Curves, Markers, Rig};
use face_math::rig::MarkerRig;
use face_math::solve::{LinearPuppet, MatchError, MatchOptions};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "the captured markers, in metres; missing ones are left out");
const RIG: Port<Rig> = Port::new("rig", "the puppet; taken as linear, its correctives and in-betweens left out");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where the markers sit on it");
const CURVES: Port<Curves> = Port::new("curves", "the best weight of every channel of the rig in each frame");

/// Finds, frame by frame, the weights whose puppet markers are nearest to the captured ones (Eq. 2 of FDLS).
///
/// The rig is taken as linear: each channel moves the markers in proportion to its weight, as far as it does at weight 1.
/// The weights are the exact optimum between `low` and `high`. Nothing is trained; what markers cannot tell apart comes
/// out as it may, and noise goes straight into the weights. That is what the networks are for (`solve_regions`), and this
/// is what they are compared with.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MatchMarkers {
    /// The least weight.
    #[schemars(range(min = -100.0, max = 100.0))]
    low: f64,
    /// The largest weight.
    #[schemars(range(min = -100.0, max = 100.0))]
    high: f64,
    /// How strongly weights are drawn to 0, as a share of the mean square of what channels move. 0 is Eq. 2 itself; 0.001
    /// calms weights that the markers hardly see.
    #[schemars(range(min = 0.0, max = 1000.0))]
    rest: f64,
}

impl Default for MatchMarkers {
    fn default() -> Self {
        let MatchOptions { low, high, rest } = MatchOptions::default();
        Self { low, high, rest }
    }
}

graph_core::register!(MatchMarkers);

#[typetag::serde(name = "match_markers")]
impl Node for MatchMarkers {
    fn card(&self) -> Card {
        Card::new("solve").takes(&MARKERS).takes(&RIG).takes(&ATTACHMENT).gives(&CURVES).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let take = inputs.get(&MARKERS)?;
        let puppet = MarkerRig::attached(inputs.get(&RIG)?, inputs.get(&ATTACHMENT)?)
            .map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let Self { low, high, rest } = *self;
        let linear = LinearPuppet::new(&puppet, take, MatchOptions { low, high, rest }).map_err(told)?;
        context.go_on()?;
        Ok(Outputs::default().with(&CURVES, linear.solve(take).map_err(told)?))
    }
}

/// The error with the port or parameter that it is about.
fn told(error: MatchError) -> NodeError {
    match error {
        MatchError::Option { what: "the pull to rest", .. } => NodeError::parameter("rest", error),
        MatchError::Option { .. } => NodeError::parameter("low", error),
        _ => NodeError::input(MARKERS.name(), error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use face_math::data::Driver;
    use glam::Vec3;
    use serde_json::json;

    fn linear() -> Rig {
        let mut rig = toy::rig();
        rig.shapes.retain(|shape| matches!(shape.driver, Driver::Channel(_)));
        rig
    }

    fn run(parameters: serde_json::Value, markers: &Markers) -> Result<Curves, String> {
        let node: MatchMarkers = made(parameters);
        let inputs = Inputs::default().with(&MARKERS, markers.clone()).with(&RIG, linear());
        let outputs = compute(&node, &inputs.with(&ATTACHMENT, toy::attachment()));
        outputs.map(|outputs| outputs.get(&CURVES).unwrap().clone()).map_err(|error| error.to_string())
    }

    fn take(truth: &Curves) -> Markers {
        MarkerRig::attached(&linear(), &toy::attachment()).unwrap().drive(truth).unwrap()
    }

    #[test]
    fn the_weights_that_made_the_markers_come_back() {
        let truth = toy::curves(30, 3);
        let found = run(json!({}), &take(&truth)).unwrap();
        let worst = found.values().iter().zip(truth.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-4, "{worst}");
    }

    #[test]
    fn blocks_equal_the_whole_with_noise_and_gaps() {
        let truth = toy::curves(90, 4);
        let markers = take(&truth);
        let mut dice = toy::Dice(6);
        let positions = markers
            .positions()
            .iter()
            .enumerate()
            .map(|(index, point)| if index % 41 == 3 { Vec3::NAN } else { *point + dice.point() * 2e-3 });
        let markers = markers.with_positions(positions.collect()).unwrap();
        let whole = run(json!({}), &markers).unwrap();
        for range in [0..32, 32..64, 64..90, 17..18] {
            let block = run(json!({}), &toy::cut(&markers, range.clone())).unwrap();
            assert!(toy::same_bits(&whole, range, &block));
        }
        assert!(whole.values().iter().all(|weight| (0.0..=1.0).contains(weight)));
    }

    #[test]
    fn mistakes_are_named() {
        let markers = take(&toy::curves(3, 5));
        assert!(run(json!({"low": 2.0}), &markers).unwrap_err().starts_with("parameter `low`: "));
        let blind = markers.with_positions(vec![Vec3::NAN; markers.positions().len()]).unwrap();
        assert!(run(json!({}), &blind).unwrap_err().contains("frame 101"));
    }
}
