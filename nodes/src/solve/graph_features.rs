//! `graph_features`: what the region networks see of the markers (section 4.3 of FDLS).

use face_math::data::{FeatureSet, Features, Markers, Regions, nearest_name};
use face_math::solve::{FeatureError, fdls_sets, graph_features};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const MARKERS: Port<Markers> = Port::new("markers", "the markers to look at, without gaps, in metres");
const NEUTRAL: Port<Markers> = Port::new("neutral", "the same markers on the face at rest; its first frame is used");
const REGIONS: Port<Regions> = Port::new("regions", "the regions, each with its markers");
const FEATURES: Port<Features> = Port::new("features", "for each region and frame one row of numbers");

/// Turns the markers of each region into graph features: distances and directions between every two markers, and
/// displacements from the face at rest.
///
/// Distances and directions do not change when the head camera slips; displacements tell the rest. Which of them a region
/// sees is a matter of taste that the paper has settled for seven regions.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GraphFeatures {
    /// The feature sets of every region: `"paper"` for the paper's own of each region, or a list for all regions alike, in
    /// the order in which a row holds them.
    sets: Sets,
    /// Other sets for certain regions, by the region's name.
    by_region: BTreeMap<String, Vec<Set>>,
}

/// Which sets all regions have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "`paper`, or a list of `distance`, `direction`, `delta` and `coordinates`")]
enum Sets {
    /// A known choice.
    Known(Known),
    /// The same for all regions.
    These(Vec<Set>),
}

/// A known choice of sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Known {
    /// Those of the FDLS supplement for `jaw`, `lips`, `lower-face`, `upper-face`, `cheek`, `eyelids` and `eyeballs`.
    /// Regions of other names see distances, directions and deltas.
    Paper,
}

/// A kind of feature over the markers of one region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Set {
    /// Distance of every two markers, in metres.
    Distance,
    /// Unit direction from the first to the second of every two markers.
    Direction,
    /// Displacement of every marker from its place at rest, in metres.
    Delta,
    /// The plain coordinates of every marker, in metres: what the others are measured against.
    Coordinates,
}

impl Default for Sets {
    fn default() -> Self {
        Self::Known(Known::Paper)
    }
}

impl From<Set> for FeatureSet {
    fn from(set: Set) -> Self {
        match set {
            Set::Distance => Self::Distance,
            Set::Direction => Self::Direction,
            Set::Delta => Self::Delta,
            Set::Coordinates => Self::Coordinates,
        }
    }
}

graph_core::register!(GraphFeatures);

#[typetag::serde(name = "graph_features")]
impl Node for GraphFeatures {
    fn card(&self) -> Card {
        Card::new("solve").takes(&MARKERS).takes(&NEUTRAL).still().takes(&REGIONS).gives(&FEATURES).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let regions = inputs.get(&REGIONS)?;
        let sets = self.sets_of(regions)?;
        let features = graph_features(inputs.get(&MARKERS)?, inputs.get(&NEUTRAL)?, regions, &sets);
        let features = features.map_err(|error| match error {
            FeatureError::Neutral { .. } => NodeError::input(NEUTRAL.name(), error),
            FeatureError::Missing { .. } | FeatureError::OnePlace { .. } => NodeError::input(MARKERS.name(), error),
            FeatureError::Sets { .. } | FeatureError::Nothing { .. } | FeatureError::Region { .. } => {
                NodeError::input(REGIONS.name(), error)
            }
        })?;
        Ok(Outputs::default().with(&FEATURES, features))
    }
}

impl GraphFeatures {
    fn sets_of(&self, regions: &Regions) -> Result<Vec<Vec<FeatureSet>>, NodeError> {
        for name in self.by_region.keys() {
            if regions.get(name).is_none() {
                let near = nearest_name(name, regions.regions.iter().map(|region| region.name.as_str()));
                let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
                return Err(NodeError::parameter("by_region", format!("there is no region `{name}`{near}")));
            }
        }
        let listed = |sets: &[Set]| sets.iter().map(|set| FeatureSet::from(*set)).collect::<Vec<_>>();
        let of = |name: &str| match (self.by_region.get(name), &self.sets) {
            (Some(own), _) => listed(own),
            (None, Sets::These(sets)) => listed(sets),
            (None, Sets::Known(Known::Paper)) => match fdls_sets(name) {
                Some(sets) => sets.to_vec(),
                None => vec![FeatureSet::Distance, FeatureSet::Direction, FeatureSet::Delta],
            },
        };
        Ok(regions.regions.iter().map(|region| of(&region.name)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use face_math::rig::MarkerRig;
    use glam::Vec3;
    use serde_json::json;

    fn take(frames: usize) -> Markers {
        let puppet = MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap();
        puppet.drive(&toy::curves(frames, 3)).unwrap()
    }

    fn features(parameters: serde_json::Value, markers: Markers) -> Result<Features, String> {
        let node: GraphFeatures = made(parameters);
        let inputs =
            Inputs::default().with(&MARKERS, markers).with(&NEUTRAL, toy::neutral()).with(&REGIONS, toy::regions());
        let outputs = compute(&node, &inputs);
        outputs.map(|outputs| outputs.get(&FEATURES).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn regions_see_what_the_paper_says_or_the_graph() {
        use FeatureSet::{Coordinates, Delta, Direction, Distance};
        let sets = |features: &Features, region: &str| features.region(region).unwrap().sets.clone();
        let paper = features(json!({}), take(2)).unwrap();
        assert_eq!(sets(&paper, "lips"), [Direction]);
        assert_eq!(sets(&paper, "jaw"), [Direction, Delta]);
        assert_eq!(sets(&paper, "brow"), [Distance, Direction, Delta]);
        let own = json!({"sets": ["coordinates"], "by_region": {"jaw": ["delta", "distance"]}});
        let own = features(own, take(2)).unwrap();
        assert_eq!(sets(&own, "lips"), [Coordinates]);
        assert_eq!(sets(&own, "jaw"), [Delta, Distance]);
    }

    #[test]
    fn blocks_equal_the_whole() {
        let take = take(9);
        let block = features(json!({}), toy::cut(&take, 4..7)).unwrap();
        assert!(toy::same_bits(&features(json!({}), take).unwrap(), 4..7, &block));
    }

    #[test]
    fn gaps_and_unknown_regions_are_named() {
        let take = take(3);
        let mut positions = take.positions().to_vec();
        positions[12 + 5] = Vec3::NAN;
        let error = features(json!({}), take.with_positions(positions).unwrap()).unwrap_err();
        assert!(error.contains("marker `m5` is missing in frame 102"), "{error}");
        let error = features(json!({"by_region": {"lip": ["delta"]}}), take.clone()).unwrap_err();
        assert!(error.contains("did you mean `lips`?"), "{error}");
        let error = features(json!({"by_region": {"lips": []}}), take).unwrap_err();
        assert!(error.contains("`lips` has no features"), "{error}");
    }

    #[test]
    fn another_word_than_paper_is_refused_with_what_may_stand_there() {
        let error = serde_json::from_value::<GraphFeatures>(json!({"sets": "papr"})).unwrap_err().to_string();
        assert!(error.contains("`paper`, or a list"), "{error}");
    }
}
