//! `smooth_curves`: calms jitter in animation curves; after a solve, before curves are saved.

use crate::patterns::Patterns;
use face_math::clean::{Smoothing, kernel, smoothed};
use face_math::data::Curves;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CURVES: Port<Curves> = Port::new("curves", "one value a channel and frame; NaN is a gap");
const CALM: Port<Curves> = Port::new("curves", "the same channels and frames, calmer; gaps stay gaps");

/// Calms curves over time; nothing lags, since the frames before and after count alike.
///
/// The Gaussian is the calmer one. Savitzky-Golay keeps the height and width of short peaks such as blinks and plosives,
/// and lets more jitter through.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SmoothCurves {
    /// Channels to calm, as patterns: `mouth*`. All where empty.
    channels: Vec<String>,
    /// How to calm: `gaussian(sigma_frames: 1.5)` or `savitzky_golay(reach_frames: 4, degree: 2)`.
    filter: Filter,
}

/// How curves are calmed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Filter {
    /// A mean weighted by a Gaussian.
    Gaussian {
        /// Standard deviation of the Gaussian, in frames; 0 changes nothing.
        #[schemars(range(min = 0.0, max = 100.0))]
        sigma_frames: f64,
    },
    /// The middle of a polynomial fitted to the frames around (Savitzky and Golay 1964).
    SavitzkyGolay {
        /// Frames on either side that the polynomial is fitted to.
        #[schemars(range(min = 1, max = 100))]
        reach_frames: usize,
        /// Degree of the polynomial; below twice the reach.
        #[schemars(range(min = 0, max = 6))]
        degree: usize,
    },
}

impl Default for SmoothCurves {
    fn default() -> Self {
        Self { channels: Vec::new(), filter: Filter::Gaussian { sigma_frames: 1.5 } }
    }
}

graph_core::register!(SmoothCurves);

impl SmoothCurves {
    fn smoothing(&self) -> Smoothing {
        match self.filter {
            Filter::Gaussian { sigma_frames } => Smoothing::Gaussian { sigma_frames },
            Filter::SavitzkyGolay { reach_frames, degree } => Smoothing::SavitzkyGolay { reach_frames, degree },
        }
    }
}

#[typetag::serde(name = "smooth_curves")]
impl Node for SmoothCurves {
    fn card(&self) -> Card {
        Card::new("clean").takes(&CURVES).gives(&CALM).per_frame(self.smoothing().reach())
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let curves = inputs.get(&CURVES)?;
        let kernel = kernel(self.smoothing()).map_err(|error| NodeError::parameter("filter", error))?;
        let chosen = Patterns { parameter: "channels", what: "channel", names: curves.channels() };
        let chosen =
            if self.channels.is_empty() { vec![true; curves.channels().len()] } else { chosen.fits(&self.channels)? };
        let width = curves.channels().len();
        let mut values = curves.values().to_vec();
        for channel in (0..width).filter(|channel| chosen[*channel]) {
            context.go_on()?;
            let raw: Vec<f64> = (0..curves.frames()).map(|frame| f64::from(curves.frame(frame)[channel])).collect();
            for (frame, value) in smoothed(&raw, &kernel).into_iter().enumerate() {
                values[frame * width + channel] = value as f32;
            }
        }
        let calm = Curves::new(curves.frame_axis(), curves.channels().to_vec(), values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&CALM, calm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use graph_core::node::Time;
    use serde_json::json;

    fn run(parameters: serde_json::Value, curves: &Curves) -> Result<Curves, String> {
        let node: SmoothCurves = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&CURVES, curves.clone()));
        outputs.map(|outputs| outputs.get(&CALM).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn the_halo_is_what_the_filter_reaches_and_blocks_equal_the_whole() {
        let golay = || json!({"filter": {"savitzky_golay": {"reach_frames": 4, "degree": 2}}});
        let time = |parameters| made::<SmoothCurves>(parameters).card().time;
        assert_eq!(time(json!({})), Time::PerFrame { halo: 6 });
        assert_eq!(time(golay()), Time::PerFrame { halo: 4 });
        let curves = toy::curves(90, 2);
        for (parameters, halo) in [(json!({}), 6), (golay(), 4)] {
            let whole = run(parameters.clone(), &curves).unwrap();
            let block = run(parameters, &toy::cut(&curves, 32 - halo..64 + halo)).unwrap();
            assert!(toy::same_bits(&whole, 32..64, &toy::cut(&block, halo..halo + 32)));
        }
    }

    #[test]
    fn only_the_chosen_channels_change() {
        let curves = toy::curves(30, 1);
        let calm = run(json!({"channels": ["smile_*"]}), &curves).unwrap();
        for frame in 0..30 {
            for channel in 0..4 {
                let same = calm.frame(frame)[channel].to_bits() == curves.frame(frame)[channel].to_bits();
                assert_eq!(same, !(1..3).contains(&channel));
            }
        }
        assert!(run(json!({"channels": ["smle_*"]}), &curves).unwrap_err().contains("`channels`"));
        let bad = json!({"filter": {"savitzky_golay": {"reach_frames": 1, "degree": 3}}});
        assert!(run(bad, &curves).unwrap_err().contains("`filter`"));
    }
}
