//! `mix_regions`: further training motion, in which each part of the face comes from another frame; after a range of motion.

use crate::patterns::Patterns;
use crate::random::Random;
use face_math::data::{Curves, Regions};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use wire::FrameAxis;

const CURVES: Port<Curves> = Port::new("curves", "training motion: a FACS sweep and a range of motion");
const REGIONS: Port<Regions> = Port::new("regions", "the regions, each with its channels");
const MIXED: Port<Curves> = Port::new("curves", "the same motion, and behind it the mixed frames");

/// Makes more expressions of those in a range of motion: in a mixed frame, each group of regions comes from a frame of its
/// own, stronger or weaker than it was there.
///
/// An actor's range of motion holds few of the expressions that a take may bring: brows raised in a smile, a harder blink.
/// Networks do not solve well what they were not shown. Regions that move together, and whose markers cannot tell them
/// apart, should stay together in a group: eyelids follow the eyes, and the upper lip follows the nose.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MixRegions {
    /// Number of mixed frames; as many as the range of motion has is a good measure.
    #[schemars(range(max = 10_000_000))]
    frames: usize,
    /// The groups of regions that come from one frame. Regions that no group names are groups by themselves.
    groups: Vec<Group>,
    /// How much stronger or weaker groups come that do not say so themselves: 0.5 is anything from half to one and a half
    /// times the weights of the frame. Each group of each mixed frame has a strength of its own.
    #[schemars(range(min = 0.0, max = 1.0))]
    variation: f64,
    /// The least weight of a channel in a mixed frame.
    #[schemars(range(min = -100.0, max = 100.0))]
    low: f32,
    /// The largest weight of a channel in a mixed frame.
    #[schemars(range(min = -100.0, max = 100.0))]
    high: f32,
    /// Where the random numbers come from.
    #[schemars(range(max = 1_000_000_000))]
    seed: u64,
}

/// Regions that come from one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Group {
    /// Names of the regions, as patterns: `eye*`.
    regions: Vec<String>,
    /// How much stronger or weaker this group comes, in place of `variation` above.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    variation: Option<f64>,
}

impl Default for MixRegions {
    fn default() -> Self {
        Self { frames: 4000, groups: Vec::new(), variation: 0.5, low: 0.0, high: 1.0, seed: 0 }
    }
}

graph_core::register!(MixRegions);

#[typetag::serde(name = "mix_regions")]
impl Node for MixRegions {
    fn card(&self) -> Card {
        Card::new("rig").takes(&CURVES).takes(&REGIONS).gives(&MIXED)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (curves, regions) = (inputs.get(&CURVES)?, inputs.get(&REGIONS)?);
        super::check_finite(CURVES.name(), curves)?;
        if self.low > self.high {
            let problem = format!("{} is above `high`, {}", self.low, self.high);
            return Err(NodeError::parameter("low", problem));
        }
        if curves.frames() == 0 {
            return Err(NodeError::input(CURVES.name(), "there is no frame to mix"));
        }
        let groups = self.groups(curves, regions)?;
        let width = curves.channels().len();
        context.claim("frames", (curves.frames() + self.frames).saturating_mul(width * size_of::<f32>()))?;
        let mut values = curves.values().to_vec();
        values.reserve(self.frames * width);
        let mut random = Random::new(self.seed, 0);
        for mixed in 0..self.frames {
            if mixed % 1024 == 0 {
                context.go_on()?;
            }
            let start = values.len();
            values.resize(start + width, 0.0);
            for (columns, variation) in &groups {
                let source = curves.frame(random.below(curves.frames()));
                let strength = (1.0 + variation * (2.0 * random.unit() - 1.0)) as f32;
                for column in columns {
                    values[start + column] = (strength * source[*column]).clamp(self.low, self.high);
                }
            }
        }
        let axis = FrameAxis { count: curves.frames() + self.frames, ..curves.frame_axis() };
        let mixed = Curves::new(axis, curves.channels().to_vec(), values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&MIXED, mixed))
    }
}

impl MixRegions {
    /// The columns of each group, with its variation. Channels of no region come with the first group.
    fn groups(&self, curves: &Curves, regions: &Regions) -> Result<Vec<(Vec<usize>, f64)>, NodeError> {
        let names: Vec<String> = regions.regions.iter().map(|region| region.name.clone()).collect();
        let mut grouped = BTreeSet::new();
        let mut groups = Vec::new();
        for group in &self.groups {
            let own = Patterns { parameter: "groups", what: "region", names: &names }.chosen(&group.regions)?;
            if let Some(twice) = own.iter().find(|name| !grouped.insert((*name).clone())) {
                return Err(NodeError::parameter("groups", format!("region `{twice}` is in two groups; one must do")));
            }
            groups.push((own, group.variation.unwrap_or(self.variation)));
        }
        let alone = names.into_iter().filter(|name| !grouped.contains(name));
        groups.extend(alone.map(|name| (vec![name], self.variation)).collect::<Vec<_>>());
        let mut left: BTreeSet<usize> = (0..curves.channels().len()).collect();
        let mut columns_of = Vec::with_capacity(groups.len());
        for (names, variation) in groups {
            let mut columns = Vec::new();
            for region in names.iter().filter_map(|name| regions.get(name)) {
                curves
                    .arrange(&region.channels, None)
                    .map_err(|error| NodeError::input(CURVES.name(), format!("region `{}`: {error}", region.name)))?;
                columns.extend(region.channels.iter().filter_map(|channel| curves.index(channel)));
            }
            columns.retain(|column| left.remove(column));
            columns_of.push((columns, variation));
        }
        match columns_of.first_mut() {
            Some((columns, _)) => columns.extend(left),
            None => columns_of.push((left.into_iter().collect(), self.variation)),
        }
        Ok(columns_of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    fn mix(parameters: serde_json::Value, curves: Curves) -> Result<Curves, String> {
        let node: MixRegions = made(parameters);
        let inputs = Inputs::default().with(&CURVES, curves).with(&REGIONS, toy::regions());
        let outputs = compute(&node, &inputs);
        outputs.map(|outputs| outputs.get(&MIXED).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn more_than_memory_holds_is_refused() {
        let error = mix(json!({"frames": 10_000_000_000_u64}), counted()).unwrap_err();
        let expected = "parameter `frames`: this takes 160.0 GB of memory, and the cook may take 1.1 GB; lower it";
        assert!(error.starts_with(expected), "{error}");
    }

    /// Ten frames in which every channel tells its frame.
    fn counted() -> Curves {
        let values = (0..10).flat_map(|frame| [frame as f32 / 20.0; 4]).collect();
        Curves::new(FrameAxis { first: 7, count: 10, rate_hz: 60.0 }, toy::rig().channels, values).unwrap()
    }

    #[test]
    fn each_group_comes_from_one_frame_and_the_motion_stays_before() {
        let curves = counted();
        let mixed =
            mix(json!({"frames": 200, "variation": 0.0, "groups": [{"regions": ["lips", "jaw"]}]}), curves.clone());
        let mixed = mixed.unwrap();
        assert_eq!(mixed.frames(), 210);
        assert_eq!(mixed.values()[..40], curves.values()[..]);
        let mut apart = 0;
        for frame in 10..210 {
            let [jaw, left, right, brow] = [0, 1, 2, 3].map(|channel| mixed.frame(frame)[channel].to_bits());
            assert!(jaw == left && left == right, "lips and jaw come together");
            assert!(curves.values().iter().any(|value| value.to_bits() == brow));
            apart += usize::from(brow != jaw);
        }
        assert!(apart > 150, "the brow comes from frames of its own: {apart}");
        assert_ne!(mix(json!({"frames": 9, "seed": 1}), counted()), mix(json!({"frames": 9}), counted()));
    }

    #[test]
    fn strengths_vary_and_weights_stay_inside() {
        let ones = Curves::new(FrameAxis::new(1, 60.0), toy::rig().channels, vec![0.8; 4]).unwrap();
        let mixed = mix(json!({"frames": 500, "groups": [{"regions": ["brow"], "variation": 1.0}]}), ones).unwrap();
        let column = |channel: usize| (1..501).map(|frame| mixed.frame(frame)[channel]).collect::<Vec<_>>();
        let range = |values: &[f32]| values.iter().fold((9.0_f32, -9.0_f32), |(a, b), v| (a.min(*v), b.max(*v)));
        let (low, high) = range(&column(3));
        assert!(low < 0.05 && (high - 1.0).abs() < 1e-6, "{low} {high}");
        let (low, high) = range(&column(0));
        assert!((0.4..0.45).contains(&low) && (high - 1.0).abs() < 1e-6, "{low} {high}");
    }

    #[test]
    fn mistakes_are_named() {
        let fault = |parameters: serde_json::Value| mix(parameters, counted()).unwrap_err();
        assert!(fault(json!({"groups": [{"regions": ["lip"]}]})).contains("did you mean `lips`?"));
        assert!(fault(json!({"groups": [{"regions": ["lips"]}, {"regions": ["*"]}]})).contains("in two groups"));
        assert!(fault(json!({"low": 1.0, "high": 0.0})).contains("`low`"));
        let some = counted().arrange(&["jawOpen".to_owned()], None).unwrap();
        assert!(mix(json!({}), some).unwrap_err().contains("smile_L"));
    }
}
