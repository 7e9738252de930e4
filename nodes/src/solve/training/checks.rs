//! Whether regions, features and curves fit together, before anything is trained. Messages name the ports `features`,
//! `curves` and `regions` of `train_regions`.

use crate::solve::solving::difference;
use face_math::data::{Curves, Features, Region, RegionFeatures, Regions, nearest_name};
use graph_core::node::NodeError;
use std::collections::BTreeMap;

/// Refuses a name of `parameter` that no region has.
pub(in crate::solve) fn known_region(parameter: &str, name: &str, regions: &Regions) -> Result<(), NodeError> {
    if regions.get(name).is_some() {
        return Ok(());
    }
    let near = nearest_name(name, regions.regions.iter().map(|own| own.name.as_str()));
    let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
    Err(NodeError::parameter(parameter, format!("there is no region `{name}`{near}")))
}

/// Refuses regions without channels, and channels that two regions solve.
pub(in crate::solve) fn each_solved_once(regions: &Regions) -> Result<(), NodeError> {
    let mut solved_by: BTreeMap<&str, &str> = BTreeMap::new();
    for region in &regions.regions {
        if region.channels.is_empty() {
            let problem = format!("region `{}` has no channels to solve; give it some or take it out", region.name);
            return Err(NodeError::input("regions", problem));
        }
        for channel in &region.channels {
            if let Some(other) = solved_by.insert(channel, &region.name) {
                let problem =
                    format!("channel `{channel}` is solved by `{other}` and by `{}`; one must do", region.name);
                return Err(NodeError::input("regions", problem));
            }
        }
    }
    Ok(())
}

/// The channels of the curves that no region solves; refuses channels of regions that the curves lack.
pub(in crate::solve) fn unsolved(regions: &Regions, curves: &Curves) -> Result<Vec<String>, NodeError> {
    for region in &regions.regions {
        curves
            .arrange(&region.channels, None)
            .map_err(|error| NodeError::input("curves", format!("region `{}`: {error}", region.name)))?;
    }
    let solved = |channel: &&String| regions.regions.iter().any(|region| region.channels.contains(channel));
    Ok(curves.channels().iter().filter(|channel| !solved(channel)).cloned().collect())
}

/// The features of `region`, made of its markers.
pub(in crate::solve) fn features_of<'f>(
    region: &Region,
    features: &'f Features,
) -> Result<&'f RegionFeatures, NodeError> {
    let own = features.region(&region.name).ok_or_else(|| {
        let problem = format!("there are no features of region `{}`; make them from the same regions", region.name);
        NodeError::input("features", problem)
    })?;
    if own.markers != region.markers {
        let problem = format!(
            "region `{}` is made of other markers than the regions say: {}",
            region.name,
            difference(&own.markers, &region.markers)
        );
        return Err(NodeError::input("features", problem));
    }
    Ok(own)
}
