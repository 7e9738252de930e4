//! What solving with trained networks has in common: features held against what a network was trained on, prediction,
//! and the range of the result.

use crate::values::RegionNetwork;
use face_math::data::{Curves, DataError, FeatureSet, Features, RegionFeatures, nearest_name};
use graph_core::node::NodeError;
use learn::Matrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where solved weights are kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Clamp {
    /// Between 0 and 1, where channels belong.
    ZeroToOne,
    /// As the network gives them.
    Off,
}

impl Clamp {
    fn apply(self, weight: f32) -> f32 {
        match self {
            Self::ZeroToOne => weight.clamp(0.0, 1.0),
            Self::Off => weight,
        }
    }
}

/// The features that `network` was trained on, out of those on the port `port`.
///
/// # Errors
/// Where the region is not there, or was made of other markers or sets: both are named.
pub(crate) fn features_for<'f>(
    port: &str,
    features: &'f Features,
    network: &RegionNetwork,
) -> Result<&'f RegionFeatures, NodeError> {
    let name = &network.region;
    let wrong = |problem: String| Err(NodeError::input(port, problem));
    let Some(own) = features.region(name) else {
        let near = nearest_name(name, features.regions().iter().map(|region| region.region.as_str()));
        let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        return wrong(format!("there are no features of region `{name}`, which a network was trained for{near}"));
    };
    if own.sets != network.sets {
        let (found, trained) = (sets_text(&own.sets), sets_text(&network.sets));
        return wrong(format!(
            "region `{name}` comes as {found} but its network was trained on {trained}; give both `graph_features` the same \
             `sets`"
        ));
    }
    if own.markers != network.markers {
        return wrong(format!(
            "region `{name}` is made of other markers than its network was trained on: {}; use the same regions for both, or \
             train again",
            difference(&own.markers, &network.markers)
        ));
    }
    if own.width != network.network.architecture().inputs {
        let expected = network.network.architecture().inputs;
        return wrong(format!("region `{name}` has {} features where its network takes {expected}", own.width));
    }
    Ok(own)
}

/// Names of feature sets, for messages.
fn sets_text(sets: &[FeatureSet]) -> String {
    let name = |set: &FeatureSet| match set {
        FeatureSet::Distance => "distance",
        FeatureSet::Direction => "direction",
        FeatureSet::Delta => "delta",
        FeatureSet::Coordinates => "coordinates",
    };
    format!("[{}]", sets.iter().map(name).collect::<Vec<_>>().join(", "))
}

/// In what two lists of markers differ, for messages.
pub(crate) fn difference(found: &[String], trained: &[String]) -> String {
    let lacking = |these: &[String], those: &[String]| {
        let names: Vec<_> = these.iter().filter(|name| !those.contains(name)).map(|name| format!("`{name}`")).collect();
        let more = if names.len() > 5 { format!(" and {} more", names.len() - 5) } else { String::new() };
        (!names.is_empty()).then(|| names[..names.len().min(5)].join(", ") + &more)
    };
    match (lacking(found, trained), lacking(trained, found)) {
        (None, None) => "the same names in another order".to_owned(),
        (Some(new), None) => format!("{new} here but not in training"),
        (None, Some(old)) => format!("{old} in training but not here"),
        (Some(new), Some(old)) => format!("{new} here but not in training, {old} in training but not here"),
    }
}

/// The weights that `network` gives for each frame: frames × its channels.
///
/// # Errors
/// Where the features overflow the network.
pub(crate) fn predict(
    port: &str,
    network: &RegionNetwork,
    features: &RegionFeatures,
    conditions: Option<&Matrix>,
    clamp: Clamp,
) -> Result<Matrix, NodeError> {
    let wrong = |error: &dyn std::fmt::Display| NodeError::input(port, format!("region `{}`: {error}", network.region));
    let rows = features.values.len() / features.width.max(1);
    let inputs = Matrix::new(rows, features.width, features.values.clone()).map_err(|error| wrong(&error))?;
    let found = network.network.predict(&inputs, conditions).map_err(|error| wrong(&error))?;
    Ok(Matrix::from_fn(found.rows(), found.columns(), |row, column| clamp.apply(found.row(row)[column])))
}

/// The columns `channels` of `curves` as a matrix.
///
/// # Errors
/// Where one of them is not there.
pub(crate) fn columns(curves: &Curves, channels: &[String]) -> Result<Matrix, DataError> {
    let arranged = curves.arrange(channels, None)?;
    Ok(Matrix::from_fn(arranged.frames(), channels.len(), |frame, channel| arranged.frame(frame)[channel]))
}
