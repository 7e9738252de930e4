//! What the region networks see of a face: graph features over the markers of each region (section 4.3 of FDLS).
//!
//! For markers mᵢ (metres) of one region, neutral markers nᵢ, and every pair i < j:
//!
//! ```text
//! distance   ‖mᵢ − mⱼ‖                       metres
//! direction  (mᵢ − mⱼ) / ‖mᵢ − mⱼ‖           unitless
//! delta      mᵢ − nᵢ                         metres
//! ```
//!
//! The paper counts n² pairs. Here each unordered pair enters once, n (n − 1) / 2 of them: ‖mⱼ − mᵢ‖ is the same number
//! again, the direction from j to i the same with the other sign, and a marker with itself gives 0 and no direction. The
//! other half would double the width of every network and tell it nothing.
//!
//! A row holds the sets in the order asked for; within a set, pairs come as (0,1), (0,2) … (1,2) …, vectors as x, y, z.
//! Each frame depends on itself alone.

use crate::data::{DataError, FeatureSet, Features, Markers, Region, RegionFeatures, Regions, nearest_name};
use glam::Vec3;

/// Markers nearer to each other than this have no direction, in metres: a micrometre is below all tracking.
const NO_DIRECTION_M: f32 = 1e-6;

/// Why features cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FeatureError {
    /// A marker of a region is not among the markers, or values do not fit together.
    #[error("region `{region}`: {source}")]
    Region {
        /// The region.
        region: String,
        /// What does not fit.
        source: DataError,
    },
    /// Not one list of sets for each region.
    #[error("{found} lists of feature sets for {expected} regions; give each region its own")]
    Sets {
        /// Regions.
        expected: usize,
        /// Lists given.
        found: usize,
    },
    /// A region without features.
    #[error("region `{region}` has no features: it needs a feature set, and two markers where pairs are asked for")]
    Nothing {
        /// The region.
        region: String,
    },
    /// A marker is missing.
    #[error("marker `{marker}` is missing in frame {frame}, and region `{region}` needs it; fill the gaps first")]
    Missing {
        /// The region.
        region: String,
        /// The marker.
        marker: String,
        /// Number of the frame, as its source counts.
        frame: i64,
    },
    /// The neutral markers hold no frame, or lack a position.
    #[error(
        "neutral marker `{marker}` has no position, and region `{region}` needs it; triangulate it or leave it out"
    )]
    Neutral {
        /// The region.
        region: String,
        /// The marker.
        marker: String,
    },
    /// Two markers in one place.
    #[error(
        "markers `{first}` and `{second}` of region `{region}` lie in one place in frame {frame}, so no direction leads \
         from one to the other; look for a swapped or doubled track"
    )]
    OnePlace {
        /// The region.
        region: String,
        /// One marker.
        first: String,
        /// The other.
        second: String,
        /// Number of the frame, as its source counts.
        frame: i64,
    },
}

/// The sets that the paper uses for its regions (the second table of section 8 of FDLS), by the region's name.
pub fn fdls_sets(region: &str) -> Option<&'static [FeatureSet]> {
    use FeatureSet::{Delta, Direction, Distance};
    match region {
        "lower-face" | "cheek" => Some(&[Distance, Delta]),
        "upper-face" | "eyelids" | "eyeballs" | "eyeball" => Some(&[Distance, Direction]),
        "jaw" => Some(&[Direction, Delta]),
        "lips" => Some(&[Direction]),
        _ => None,
    }
}

/// How many numbers a set gives for `markers` markers.
pub fn feature_width(set: FeatureSet, markers: usize) -> usize {
    let pairs = markers * markers.saturating_sub(1) / 2;
    match set {
        FeatureSet::Distance => pairs,
        FeatureSet::Direction => 3 * pairs,
        FeatureSet::Delta | FeatureSet::Coordinates => 3 * markers,
    }
}

/// The features of every region over all frames of `markers`; `sets` holds one list for each region. The first frame of
/// `neutral` is the face at rest; it is asked only where deltas are wanted.
///
/// # Errors
/// Where a region's marker is not there or missing in a frame, a region has no features, or two markers coincide where
/// their direction is wanted.
pub fn graph_features(
    markers: &Markers,
    neutral: &Markers,
    regions: &Regions,
    sets: &[Vec<FeatureSet>],
) -> Result<Features, FeatureError> {
    if sets.len() != regions.regions.len() {
        return Err(FeatureError::Sets { expected: regions.regions.len(), found: sets.len() });
    }
    let mut done = Vec::with_capacity(sets.len());
    for (region, sets) in regions.regions.iter().zip(sets) {
        done.push(region_features(markers, neutral, region, sets)?);
    }
    let region = || regions.regions.first().map_or(String::new(), |region| region.name.clone());
    Features::new(markers.frame_axis(), done).map_err(|source| FeatureError::Region { region: region(), source })
}

fn region_features(
    markers: &Markers,
    neutral: &Markers,
    region: &Region,
    sets: &[FeatureSet],
) -> Result<RegionFeatures, FeatureError> {
    let count = region.markers.len();
    let width: usize = sets.iter().map(|set| feature_width(*set, count)).sum();
    if sets.iter().any(|set| feature_width(*set, count) == 0) || width == 0 {
        return Err(FeatureError::Nothing { region: region.name.clone() });
    }
    let columns = columns(markers, region)?;
    let rest = if sets.contains(&FeatureSet::Delta) { rest(neutral, region)? } else { Vec::new() };
    let mut values = Vec::with_capacity(markers.frames() * width);
    let mut points = Vec::with_capacity(count);
    for position in 0..markers.frames() {
        let frame = markers.frame(position);
        let number = || markers.frame_axis().slice(&(position..position + 1)).first;
        points.clear();
        points.extend(columns.iter().map(|column| frame[*column]));
        if let Some(missing) = points.iter().position(|point| !point.is_finite()) {
            let (region, marker) = (region.name.clone(), region.markers[missing].clone());
            return Err(FeatureError::Missing { region, marker, frame: number() });
        }
        for set in sets {
            row(*set, &points, &rest, &mut values).map_err(|(first, second)| FeatureError::OnePlace {
                region: region.name.clone(),
                first: region.markers[first].clone(),
                second: region.markers[second].clone(),
                frame: number(),
            })?;
        }
    }
    Ok(RegionFeatures {
        region: region.name.clone(),
        markers: region.markers.clone(),
        sets: sets.to_vec(),
        width,
        values,
    })
}

/// Appends the numbers of one set. Fails with the two markers that lie in one place.
fn row(set: FeatureSet, points: &[Vec3], rest: &[Vec3], values: &mut Vec<f32>) -> Result<(), (usize, usize)> {
    match set {
        FeatureSet::Distance => {
            for (i, from) in points.iter().enumerate() {
                values.extend(points[i + 1..].iter().map(|to| from.distance(*to)));
            }
        }
        FeatureSet::Direction => {
            for (i, from) in points.iter().enumerate() {
                for (j, to) in points.iter().enumerate().skip(i + 1) {
                    let apart = *from - *to;
                    let distance = apart.length();
                    if distance < NO_DIRECTION_M {
                        return Err((i, j));
                    }
                    values.extend((apart / distance).to_array());
                }
            }
        }
        FeatureSet::Delta => {
            values.extend(points.iter().zip(rest).flat_map(|(point, rest)| (*point - *rest).to_array()));
        }
        FeatureSet::Coordinates => values.extend(points.iter().flat_map(Vec3::to_array)),
    }
    Ok(())
}

fn columns(markers: &Markers, region: &Region) -> Result<Vec<usize>, FeatureError> {
    let fault = |source| FeatureError::Region { region: region.name.clone(), source };
    let mut columns = Vec::with_capacity(region.markers.len());
    for name in &region.markers {
        let near = || nearest_name(name, markers.names().iter().map(String::as_str));
        let column = markers
            .index(name)
            .ok_or_else(|| fault(DataError::Missing { what: "marker", name: name.clone(), near: near() }))?;
        if columns.contains(&column) {
            return Err(fault(DataError::Twice { what: "marker", name: name.clone() }));
        }
        columns.push(column);
    }
    Ok(columns)
}

fn rest(neutral: &Markers, region: &Region) -> Result<Vec<Vec3>, FeatureError> {
    let columns = columns(neutral, region)?;
    let place = |(column, marker): (&usize, &String)| {
        let point = (neutral.frames() > 0).then(|| neutral.frame(0)[*column]).filter(|point| point.is_finite());
        point.ok_or_else(|| FeatureError::Neutral { region: region.name.clone(), marker: marker.clone() })
    };
    columns.iter().zip(&region.markers).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;
    use glam::{Mat3, Quat};
    use wire::{FrameAxis, Value};

    const ALL: [FeatureSet; 4] =
        [FeatureSet::Distance, FeatureSet::Direction, FeatureSet::Delta, FeatureSet::Coordinates];

    fn take(frames: usize) -> Markers {
        let mut dice = Dice(41);
        let names = (0..5).map(|marker| format!("m{marker}")).collect();
        let axis = FrameAxis { first: 101, count: frames, rate_hz: 60.0 };
        Markers::new(axis, names, (0..frames * 5).map(|_| dice.point() * 0.1).collect()).unwrap()
    }

    fn regions(markers: &[&str]) -> Regions {
        let markers = markers.iter().map(|marker| (*marker).to_owned()).collect();
        Regions { regions: vec![Region { name: "lips".into(), markers, channels: Vec::new() }] }
    }

    fn values(markers: &Markers, neutral: &Markers, set: FeatureSet) -> Vec<f32> {
        let features = graph_features(markers, neutral, &regions(&["m3", "m0", "m4"]), &[vec![set]]).unwrap();
        features.regions()[0].values.clone()
    }

    fn moved(markers: &Markers, by: impl Fn(Vec3) -> Vec3) -> Markers {
        markers.with_positions(markers.positions().iter().map(|point| by(*point)).collect()).unwrap()
    }

    #[test]
    fn a_row_holds_what_was_asked_for_in_that_order() {
        let (markers, neutral) = (take(2), take(1));
        let features = graph_features(&markers, &neutral, &regions(&["m3", "m0", "m4"]), &[ALL.to_vec()]).unwrap();
        let region = features.region("lips").unwrap();
        assert_eq!(region.width, 3 + 9 + 9 + 9);
        let row = &region.values[30..60];
        let frame = markers.frame(1);
        let (a, b, c) = (frame[3], frame[0], frame[4]);
        assert_eq!(row[..3], [a.distance(b), a.distance(c), b.distance(c)]);
        assert_eq!(row[3..6], ((a - b) / a.distance(b)).to_array());
        assert_eq!(row[12..15], (a - neutral.frame(0)[3]).to_array());
        assert_eq!(row[24..27], b.to_array());
    }

    #[test]
    fn distances_and_directions_do_not_see_the_camera_slip() {
        let (markers, neutral) = (take(3), take(1));
        let slipped = moved(&markers, |point| point + Vec3::new(0.01, -0.02, 0.005));
        for set in [FeatureSet::Distance, FeatureSet::Direction] {
            for (a, b) in values(&markers, &neutral, set).iter().zip(values(&slipped, &neutral, set)) {
                assert!((a - b).abs() < 1e-5);
            }
        }
        let turn = Mat3::from_quat(Quat::from_rotation_y(0.3));
        let turned = moved(&markers, |point| turn * point);
        let kept = values(&turned, &neutral, FeatureSet::Distance);
        for (a, b) in values(&markers, &neutral, FeatureSet::Distance).iter().zip(kept) {
            assert!((a - b).abs() < 1e-6);
        }
        let directions = values(&markers, &neutral, FeatureSet::Direction);
        let turned = values(&turned, &neutral, FeatureSet::Direction);
        for (a, b) in directions.chunks(3).zip(turned.chunks(3)) {
            assert!((turn * Vec3::from_slice(a)).abs_diff_eq(Vec3::from_slice(b), 1e-5));
        }
    }

    #[test]
    fn a_resting_face_has_no_delta() {
        let neutral = take(1);
        assert!(values(&neutral, &neutral, FeatureSet::Delta).iter().all(|delta| *delta == 0.0));
    }

    #[test]
    fn blocks_equal_the_whole() {
        let (markers, neutral) = (take(7), take(1));
        let regions = regions(&["m0", "m1", "m2", "m4"]);
        let whole = graph_features(&markers, &neutral, &regions, &[ALL.to_vec()]).unwrap();
        let part = markers.slice(3..6).unwrap();
        let part = part.downcast_ref::<Markers>().unwrap();
        let block = graph_features(part, &neutral, &regions, &[ALL.to_vec()]).unwrap();
        assert_eq!(whole.slice(3..6).unwrap().encoded(), (&block as &dyn Value).encoded());
    }

    #[test]
    fn bad_input_is_named() {
        let neutral = take(1);
        let lost = moved(&take(3), |point| point);
        let mut positions = lost.positions().to_vec();
        positions[5] = Vec3::NAN;
        let lost = lost.with_positions(positions.clone()).unwrap();
        let sets = [vec![FeatureSet::Direction]];
        let error = graph_features(&lost, &neutral, &regions(&["m1", "m0"]), &sets).unwrap_err();
        assert_eq!(error, FeatureError::Missing { region: "lips".into(), marker: "m0".into(), frame: 102 });
        assert!(graph_features(&lost, &neutral, &regions(&["m1", "m2"]), &sets).is_ok());
        positions[5] = positions[6];
        let swapped = lost.with_positions(positions).unwrap();
        let error = graph_features(&swapped, &neutral, &regions(&["m1", "m0"]), &sets).unwrap_err();
        assert!(matches!(error, FeatureError::OnePlace { frame: 102, .. }));
        let error = graph_features(&lost, &neutral, &regions(&["m1", "n0"]), &sets).unwrap_err();
        assert!(error.to_string().contains("did you mean"), "{error}");
        let error = graph_features(&lost, &neutral, &regions(&["m1"]), &sets).unwrap_err();
        assert_eq!(error, FeatureError::Nothing { region: "lips".into() });
        let error = graph_features(&lost, &neutral, &regions(&["m1", "m1"]), &sets).unwrap_err();
        assert!(error.to_string().contains("stands twice"), "{error}");
        assert_eq!(
            graph_features(&lost, &neutral, &regions(&["m1"]), &[]).unwrap_err(),
            FeatureError::Sets { expected: 1, found: 0 }
        );
    }
}
