//! `facs_sweep`: every channel of a rig by itself, from rest to its extreme; the training motion that needs no artist.

use crate::patterns::Patterns;
use face_math::data::{Curves, Driver, Rig};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use wire::FrameAxis;

const RIG: Port<Rig> = Port::new("rig", "the head whose channels are swept");
const CURVES: Port<Curves> = Port::new("curves", "weights of all channels of the rig, in its order");

/// Moves one channel after the other from 0 to its peak, in a straight line, while all others rest (the "one-hot" FACS
/// motion of section 7 of the FDLS supplement). A rig of 53 channels gives about 480 frames.
///
/// A network trained on this alone is a minimum viable solver; a range of motion beside it makes it a good one.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FacsSweep {
    /// Frames from rest to the peak, of each channel.
    #[schemars(range(min = 1, max = 10_000))]
    frames_up: usize,
    /// Further frames at the peak.
    #[schemars(range(max = 10_000))]
    frames_hold: usize,
    /// Frames from the peak back to rest.
    #[schemars(range(max = 10_000))]
    frames_down: usize,
    /// Frames at rest before the first channel.
    #[schemars(range(max = 10_000))]
    frames_rest: usize,
    /// The peak: 1 is a channel's full weight.
    #[schemars(range(min = 0.01, max = 10.0))]
    peak: f32,
    /// Channels to sweep, as patterns: `mouth*`. All where empty.
    channels: Vec<String>,
    /// Which channels to move together, beside each by itself.
    together: Together,
    /// Frames a second that the curves claim.
    #[schemars(range(min = 0.001, max = 100_000.0))]
    rate_hz: f64,
}

/// Which channels are moved together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Together {
    /// None.
    Nothing,
    /// The channels of each combination corrective of the rig (`a+b`).
    Correctives,
    /// Every two channels.
    Pairs,
}

impl Default for FacsSweep {
    fn default() -> Self {
        Self {
            frames_up: 9,
            frames_hold: 0,
            frames_down: 0,
            frames_rest: 1,
            peak: 1.0,
            channels: Vec::new(),
            together: Together::Nothing,
            rate_hz: 60.0,
        }
    }
}

graph_core::register!(FacsSweep);

#[typetag::serde(name = "facs_sweep")]
impl Node for FacsSweep {
    fn card(&self) -> Card {
        Card::new("rig").takes(&RIG).gives(&CURVES)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let rig = inputs.get(&RIG)?;
        let swept = Patterns { parameter: "channels", what: "channel", names: &rig.channels };
        let swept: BTreeSet<String> = swept.chosen(&self.channels)?.into_iter().collect();
        let width = rig.channels.len();
        let groups = self.groups(rig, &swept);
        let frames = self.frames_rest + groups.len() * (self.frames_up + self.frames_hold + self.frames_down);
        context.claim("frames_up", frames.saturating_mul(width * size_of::<f32>()))?;
        let mut values = vec![0.0; self.frames_rest * width];
        for group in groups {
            context.go_on()?;
            for weight in self.ramp() {
                let start = values.len();
                values.resize(start + width, 0.0);
                for channel in &group {
                    values[start + channel] = weight;
                }
            }
        }
        let axis = FrameAxis::new(values.len() / width.max(1), self.rate_hz);
        let curves = Curves::new(axis, rig.channels.clone(), values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&CURVES, curves))
    }
}

impl FacsSweep {
    /// The channels that move together, group by group.
    fn groups(&self, rig: &Rig, swept: &BTreeSet<String>) -> Vec<Vec<usize>> {
        let chosen = |channel: &usize| swept.contains(&rig.channels[*channel]);
        let single: Vec<usize> = (0..rig.channels.len()).filter(chosen).collect();
        let mut groups: Vec<Vec<usize>> = single.iter().map(|channel| vec![*channel]).collect();
        match self.together {
            Together::Nothing => {}
            Together::Correctives => groups.extend(rig.shapes.iter().filter_map(|shape| match &shape.driver {
                Driver::Combination(channels) => {
                    let channels: Vec<usize> = channels.iter().map(|channel| *channel as usize).collect();
                    channels.iter().all(chosen).then_some(channels)
                }
                _ => None,
            })),
            Together::Pairs => groups.extend(
                single.iter().enumerate().flat_map(|(place, a)| single[place + 1..].iter().map(|b| vec![*a, *b])),
            ),
        }
        groups
    }

    /// The weights that each group runs through.
    fn ramp(&self) -> impl Iterator<Item = f32> {
        let part = |frame: usize, frames: usize| frame as f32 / frames as f32 * self.peak;
        let up = (1..=self.frames_up).map(move |frame| part(frame, self.frames_up));
        let hold = std::iter::repeat_n(self.peak, self.frames_hold);
        let down = (0..self.frames_down).map(move |frame| part(self.frames_down - 1 - frame, self.frames_down));
        up.chain(hold).chain(down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    fn sweep(parameters: serde_json::Value) -> Result<Curves, String> {
        let node: FacsSweep = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&RIG, toy::rig()));
        outputs.map(|outputs| outputs.get(&CURVES).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn each_channel_rises_alone_in_a_straight_line() {
        let curves = sweep(json!({})).unwrap();
        assert_eq!(curves.channels(), toy::rig().channels);
        assert_eq!(curves.frames(), 1 + 4 * 9);
        assert_eq!(curves.frame(0), [0.0; 4]);
        for frame in 1..curves.frames() {
            let (channel, step) = ((frame - 1) / 9, (frame - 1) % 9);
            let mut expected = [0.0; 4];
            expected[channel] = (step + 1) as f32 / 9.0;
            assert_eq!(curves.frame(frame), expected);
        }
    }

    #[test]
    fn it_holds_and_comes_back() {
        let with = json!({"frames_up": 2, "frames_hold": 1, "frames_down": 2, "frames_rest": 0, "channels": ["brow*"]});
        let curves = sweep(with).unwrap();
        let brow: Vec<f32> = (0..curves.frames()).map(|frame| curves.frame(frame)[3]).collect();
        assert_eq!(brow, [0.5, 1.0, 1.0, 0.5, 0.0]);
        assert!(sweep(json!({"channels": ["brwUp"]})).unwrap_err().contains("did you mean `browUp`?"));
    }

    #[test]
    fn correctives_and_pairs_move_together() {
        let short = |together: &str| sweep(json!({"frames_up": 1, "frames_rest": 0, "together": together})).unwrap();
        let correctives = short("correctives");
        assert_eq!(correctives.frames(), 5);
        assert_eq!(correctives.frame(4), [1.0, 1.0, 0.0, 0.0]);
        let pairs = short("pairs");
        assert_eq!(pairs.frames(), 4 + 6);
        assert_eq!(pairs.frame(9), [0.0, 0.0, 1.0, 1.0]);
    }
}
