//! `solve_jaw`: the jaw's channels first, since the lower face depends on where the jaw is (section 4.4.1 of FDLS).

use super::solving::{Clamp, features_for, predict};
use crate::values::Networks;
use face_math::data::{Curves, Features, nearest_name};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const FEATURES: Port<Features> = Port::new("features", "the take's features, made as those of the training");
const NETWORKS: Port<Networks> = Port::new("networks", "the trained networks");
const JAW: Port<Curves> = Port::new("jaw", "the weights of the jaw's channels");

/// Solves the jaw's channels of a take. An animator may correct them before `solve_regions` solves the rest.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SolveJaw {
    /// Where to keep the weights.
    clamp: Clamp,
}

impl Default for SolveJaw {
    fn default() -> Self {
        Self { clamp: Clamp::ZeroToOne }
    }
}

graph_core::register!(SolveJaw);

#[typetag::serde(name = "solve_jaw")]
impl Node for SolveJaw {
    fn card(&self) -> Card {
        Card::new("solve").takes(&FEATURES).takes(&NETWORKS).gives(&JAW).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (features, networks) = (inputs.get(&FEATURES)?, inputs.get(&NETWORKS)?);
        let network = networks.region(&networks.jaw).ok_or_else(|| {
            let near = nearest_name(&networks.jaw, networks.regions.iter().map(|region| region.region.as_str()));
            let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            let problem = format!("no network was trained for the region `{}`{near}", networks.jaw);
            NodeError::input(NETWORKS.name(), problem)
        })?;
        let own = features_for(FEATURES.name(), features, network)?;
        let solved = predict(FEATURES.name(), network, own, None, self.clamp)?;
        let jaw = Curves::new(features.frame_axis(), network.channels.clone(), solved.into_values());
        Ok(Outputs::default().with(&JAW, jaw.map_err(NodeError::failed)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::solve::training::toy::{features, networks};
    use crate::testing::{compute, made};
    use serde_json::json;

    fn solve(parameters: serde_json::Value, features: Features, networks: Networks) -> Result<Curves, String> {
        let node: SolveJaw = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&FEATURES, features).with(&NETWORKS, networks));
        outputs.map(|outputs| outputs.get(&JAW).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn the_jaw_is_found_on_motion_that_was_not_trained_on() {
        let truth = toy::curves(40, 77);
        let jaw = solve(json!({}), features(&truth), networks()).unwrap();
        assert_eq!(jaw.channels(), ["jawOpen"]);
        assert_eq!(jaw.frame_axis(), truth.frame_axis());
        let square = |frame: usize| f64::from(jaw.frame(frame)[0] - truth.frame(frame)[0]).powi(2);
        let rms = ((0..40).map(square).sum::<f64>() / 40.0).sqrt();
        assert!(rms < 0.1, "{rms}");
    }

    #[test]
    fn blocks_equal_the_whole() {
        let all = features(&toy::curves(40, 78));
        let block = solve(json!({}), toy::cut(&all, 30..37), networks()).unwrap();
        assert!(toy::same_bits(&solve(json!({}), all, networks()).unwrap(), 30..37, &block));
    }

    #[test]
    fn features_that_were_not_trained_on_are_named() {
        let features = features(&toy::curves(2, 3));
        let mut trained = networks();
        trained.regions[1].sets.reverse();
        let error = solve(json!({}), features.clone(), trained).unwrap_err();
        assert!(
            error.contains("comes as [direction, delta] but its network was trained on [delta, direction]"),
            "{error}"
        );
        let mut trained = networks();
        trained.regions[1].markers[3] = "chin".to_owned();
        let error = solve(json!({}), features.clone(), trained).unwrap_err();
        assert!(error.contains("`m3` here but not in training, `chin` in training but not here"), "{error}");
        let mut trained = networks();
        trained.jaw = "jaws".to_owned();
        assert!(solve(json!({}), features, trained).unwrap_err().contains("did you mean `jaw`?"));
    }
}
