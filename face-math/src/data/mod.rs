//! The data types of faces, one a file. Each implements [`wire::Value`] beside its definition.

mod attachment;
mod cameras;
mod curves;
mod edits;
mod features;
mod image;
mod markers;
mod mesh_space;
mod meshes;
mod muscles;
mod noise;
mod regions;
mod rig;
mod shape_space;
mod tables;
mod views;

pub use attachment::{Attachment, SurfacePoint};
pub use cameras::{CalibratedCamera, Cameras};
pub use curves::Curves;
pub use edits::{AnchorPose, Edits, Key, KeyCurve, KeyTarget, TakeEdits};
pub use features::{FeatureSet, Features, RegionFeatures};
pub use image::Image;
pub use markers::Markers;
pub use mesh_space::MeshSpace;
pub use meshes::Meshes;
pub use muscles::{MuscleCurve, Muscles, RidingPoint};
pub use noise::{MarkerNoise, NoiseOfMarker};
pub use regions::{Region, Regions};
pub use rig::{Driver, JawMotion, JawSkin, Joint, Part, Rig, Shape};
pub use shape_space::ShapeSpace;
pub use views::Views;

use wire::{FrameAxis, JoinError};

/// Why parts do not make a valid value of a data type.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DataError {
    /// A table does not have the size that its heads ask for.
    #[error("{what}: {found} numbers where {expected} are needed")]
    Size {
        /// Which table.
        what: &'static str,
        /// Numbers needed.
        expected: usize,
        /// Numbers given.
        found: usize,
    },
    /// A name stands twice where names must differ.
    #[error("{what} `{name}` stands twice; names must differ")]
    Twice {
        /// What is named.
        what: &'static str,
        /// The repeated name.
        name: String,
    },
    /// An index points past the end of what it indexes.
    #[error("{what}: index {index} where there are {count}")]
    Index {
        /// Which index.
        what: String,
        /// The index.
        index: usize,
        /// How many things there are.
        count: usize,
    },
    /// A number is not what it must be.
    #[error("{what} is {value}, where {wanted} belongs")]
    Number {
        /// Which number.
        what: String,
        /// Its value.
        value: f64,
        /// What it should be.
        wanted: &'static str,
    },
    /// A name that is asked for is not there.
    #[error("no {what} `{name}`{}", near.as_ref().map(|near| format!("; did you mean `{near}`?")).unwrap_or_default())]
    Missing {
        /// What is named.
        what: &'static str,
        /// The name asked for.
        name: String,
        /// The nearest name there is.
        near: Option<String>,
    },
}

fn check_size(what: &'static str, expected: usize, found: usize) -> Result<(), DataError> {
    if expected == found { Ok(()) } else { Err(DataError::Size { what, expected, found }) }
}

fn check_unique(what: &'static str, names: &[String]) -> Result<(), DataError> {
    let mut seen = std::collections::BTreeSet::new();
    match names.iter().find(|name| !seen.insert(name.as_str())) {
        None => Ok(()),
        Some(name) => Err(DataError::Twice { what, name: name.clone() }),
    }
}

/// The axis of consecutive slices laid end to end.
fn join_axes(axes: impl Iterator<Item = FrameAxis>, kind: &'static str) -> Result<FrameAxis, JoinError> {
    let mut joined: Option<FrameAxis> = None;
    for (index, axis) in axes.enumerate() {
        match &mut joined {
            None => joined = Some(axis),
            Some(whole) if whole.rate_hz.to_bits() != axis.rate_hz.to_bits() => {
                return Err(JoinError::Differs { kind, index, what: "frame rate" });
            }
            Some(whole) => whole.count += axis.count,
        }
    }
    joined.ok_or(JoinError::Empty(kind))
}

/// The name in `names` nearest to `wanted` by edit distance, where one is near enough to be a slip of the pen.
pub fn nearest_name<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let distance = |a: &str, b: &str| {
        let b: Vec<char> = b.to_lowercase().chars().collect();
        let mut row: Vec<usize> = (0..=b.len()).collect();
        for (i, x) in a.to_lowercase().chars().enumerate() {
            let mut diagonal = row[0];
            row[0] = i + 1;
            for (j, y) in b.iter().enumerate() {
                let changed = diagonal + usize::from(x != *y);
                diagonal = row[j + 1];
                row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
            }
        }
        row[b.len()]
    };
    let limit = (wanted.chars().count() / 3).max(1);
    names
        .into_iter()
        .map(|name| (distance(wanted, name), name))
        .filter(|(far, _)| *far <= limit)
        .min()
        .map(|(_, name)| name.to_owned())
}
