//! `solve_regions`: all channels of a take from the trained networks: the raw animation of FDLS (section 4.4).

use super::solving::{Clamp, columns, features_for, predict};
use crate::values::{Networks, RegionNetwork};
use face_math::data::{Curves, Features};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use learn::Matrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const FEATURES: Port<Features> = Port::new("features", "the take's features, made as those of the training");
const NETWORKS: Port<Networks> = Port::new("networks", "the trained networks");
const JAW: Port<Curves> = Port::new(
    "jaw",
    "the weights of the jaw's channels, solved or corrected; the other regions are solved for this jaw",
);
const CURVES: Port<Curves> = Port::new("curves", "the weights of all channels: the raw animation");

/// Solves all regions of a take, each by its network, for the jaw that comes in.
///
/// The jaw's own channels are taken as they come. Channels that no region solves are 0.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SolveRegions {
    /// Where to keep the solved weights. Those of the jaw are not touched.
    clamp: Clamp,
}

impl Default for SolveRegions {
    fn default() -> Self {
        Self { clamp: Clamp::ZeroToOne }
    }
}

graph_core::register!(SolveRegions);

#[typetag::serde(name = "solve_regions")]
impl Node for SolveRegions {
    fn card(&self) -> Card {
        Card::new("solve").takes(&FEATURES).takes(&NETWORKS).takes(&JAW).gives(&CURVES).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (features, networks, jaw) = (inputs.get(&FEATURES)?, inputs.get(&NETWORKS)?, inputs.get(&JAW)?);
        let axis = features.frame_axis();
        axis.matches(&jaw.frame_axis()).map_err(|error| NodeError::input(JAW.name(), error))?;
        crate::rig::check_finite(JAW.name(), jaw)?;
        let width = networks.channels.len();
        let mut values = vec![0.0; axis.count * width];
        for region in &networks.regions {
            context.go_on()?;
            let solved = if region.region == networks.jaw {
                jaw_columns(jaw, &region.channels)?
            } else {
                self.region(features, region, jaw)?
            };
            for (column, channel) in region.channels.iter().enumerate() {
                let place = networks.channels.iter().position(|own| own == channel).ok_or_else(|| {
                    NodeError::input(NETWORKS.name(), format!("channel `{channel}` is not among the solved ones"))
                })?;
                for frame in 0..axis.count {
                    values[frame * width + place] = solved.row(frame)[column];
                }
            }
        }
        let curves = Curves::new(axis, networks.channels.clone(), values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&CURVES, curves))
    }
}

impl SolveRegions {
    fn region(&self, features: &Features, region: &RegionNetwork, jaw: &Curves) -> Result<Matrix, NodeError> {
        let own = features_for(FEATURES.name(), features, region)?;
        let conditions = match region.conditions.as_slice() {
            [] => None,
            channels => Some(jaw_columns(jaw, channels)?),
        };
        predict(FEATURES.name(), region, own, conditions.as_ref(), self.clamp)
    }
}

fn jaw_columns(jaw: &Curves, channels: &[String]) -> Result<Matrix, NodeError> {
    columns(jaw, channels).map_err(|error| NodeError::input(JAW.name(), error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::solve::training::toy::{features, networks};
    use crate::testing::{compute, made};
    use face_math::solve::weight_error;
    use serde_json::json;

    fn solve(features: Features, networks: Networks, jaw: Curves) -> Result<Curves, String> {
        let node: SolveRegions = made(json!({}));
        let inputs = Inputs::default().with(&FEATURES, features).with(&NETWORKS, networks).with(&JAW, jaw);
        let outputs = compute(&node, &inputs);
        outputs.map(|outputs| outputs.get(&CURVES).unwrap().clone()).map_err(|error| error.to_string())
    }

    fn jaw(truth: &Curves) -> Curves {
        truth.arrange(&["jawOpen".to_owned()], None).unwrap()
    }

    #[test]
    fn all_channels_are_solved_in_the_order_of_the_training() {
        let truth = toy::curves(40, 77);
        let raw = solve(features(&truth), networks(), jaw(&truth)).unwrap();
        assert_eq!(raw.channels(), truth.channels());
        let error = weight_error(&truth, &raw).unwrap();
        assert!(error.rms < 0.12, "{error:?}");
        assert!(error.by_channel[0].1 < 1e-9, "the jaw is taken as it comes");
        assert!(raw.values().iter().all(|weight| (0.0..=1.0).contains(weight)));
    }

    #[test]
    fn a_corrected_jaw_changes_the_regions_that_depend_on_it_and_no_other() {
        let truth = toy::curves(5, 79);
        let features = features(&truth);
        let open = Curves::new(truth.frame_axis(), vec!["jawOpen".into()], vec![1.0; 5]).unwrap();
        let (a, b) =
            (solve(features.clone(), networks(), jaw(&truth)).unwrap(), solve(features, networks(), open).unwrap());
        let column = |curves: &Curves, name: &str| curves.arrange(&[name.to_owned()], None).unwrap();
        assert_ne!(column(&a, "smile_L"), column(&b, "smile_L"));
        assert_eq!(column(&a, "browUp"), column(&b, "browUp"));
        assert_eq!(column(&b, "jawOpen").values(), [1.0; 5]);
    }

    #[test]
    fn unsolved_channels_rest() {
        let mut trained = networks();
        let brow = trained.regions.remove(2);
        trained.unsolved = brow.channels;
        let truth = toy::curves(3, 80);
        let raw = solve(features(&truth), trained, jaw(&truth)).unwrap();
        assert!((0..3).all(|frame| raw.frame(frame)[3] == 0.0));
    }

    #[test]
    fn blocks_equal_the_whole() {
        let truth = toy::curves(40, 81);
        let all = features(&truth);
        let block = solve(toy::cut(&all, 8..19), networks(), toy::cut(&jaw(&truth), 8..19)).unwrap();
        assert!(toy::same_bits(&solve(all, networks(), jaw(&truth)).unwrap(), 8..19, &block));
    }

    #[test]
    fn a_wrong_jaw_is_named() {
        let truth = toy::curves(4, 82);
        let features = features(&truth);
        let error = solve(features.clone(), networks(), toy::cut(&jaw(&truth), 0..3)).unwrap_err();
        assert!(error.contains("`jaw`") && error.contains("4 frames beside 3 frames"), "{error}");
        let other = truth.arrange(&["browUp".to_owned()], None).unwrap();
        assert!(solve(features, networks(), other).unwrap_err().contains("no channel `jawOpen`"));
    }
}
