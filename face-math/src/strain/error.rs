//! What can go wrong when strain rigs are made and driven: each error names the place and the cure.

use crate::data::DataError;
use crate::rig::{RigError, RigidError};

/// Why a strain rig cannot be made, fitted or solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StrainError {
    /// The parts of a value do not fit together, or a name is not there.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The rig cannot be posed.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// Two values that belong together differ in size.
    #[error("{what}: {found} where {expected} are needed; cook both from the same meshes")]
    Count {
        /// What is counted: vertices, frames.
        what: String,
        /// The number needed.
        expected: usize,
        /// The number found.
        found: usize,
    },
    /// A number is NaN or infinite.
    #[error("{what} {index} is not finite in frame {frame}; mend it, or leave the frame out")]
    NotFinite {
        /// Vertex, marker or channel.
        what: &'static str,
        /// Its index.
        index: usize,
        /// The frame, as its source counts.
        frame: i64,
    },
    /// No frame to learn from.
    #[error("there are {found} frames to learn from; {needed} are needed at least")]
    TooFewFrames {
        /// Frames found.
        found: usize,
        /// Frames needed.
        needed: usize,
    },
    /// A joint has nothing rigid to be measured by.
    #[error(
        "no part follows the joint `{joint}` wholly, so its pose cannot be measured; name a part that moves with it alone"
    )]
    NothingRigid {
        /// The joint.
        joint: String,
    },
    /// The rig has no joints.
    #[error("rig `{rig}` has no joints with pose channels; make them first (`add_joints`)")]
    NoJoints {
        /// The rig.
        rig: String,
    },
    /// A shape that joints drive has no peak that could be carried to another head.
    #[error(
        "shape `{shape}` of rig `{rig}` is driven by a joint, so it cannot be carried shape by shape; carry meshes \
         (`transfer_meshes`) and fit a rig to them"
    )]
    DrivenByJoint {
        /// The rig.
        rig: String,
        /// The shape.
        shape: String,
    },
    /// A joint's rigid part gives no rotation.
    #[error("joint `{joint}` in frame {frame}: {source}")]
    Pose {
        /// The joint.
        joint: String,
        /// The frame, as its source counts.
        frame: i64,
        /// What the fit says.
        source: RigidError,
    },
    /// Skinning cannot be undone.
    #[error(
        "skinning flattens vertex {vertex} in frame {frame} (its volume shrinks to {volume:.4}), so it cannot be undone; \
         check the weights of the joints there, or leave the frame out"
    )]
    Flat {
        /// The vertex.
        vertex: usize,
        /// The frame, as its source counts.
        frame: i64,
        /// Determinant of the blended matrix.
        volume: f64,
    },
    /// Linear algebra gave up.
    #[error("{what} cannot be decomposed; look for vertices or values that are far off")]
    Decomposition {
        /// Which matrix.
        what: &'static str,
    },
    /// A setting is out of its range.
    #[error("{what} is {value}, where {wanted} belongs")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it should be.
        wanted: &'static str,
    },
    /// A muscle cannot be laid on the head.
    #[error("muscle `{muscle}`: {problem}")]
    Muscle {
        /// The muscle.
        muscle: String,
        /// What is wrong, and the cure.
        problem: String,
    },
}

/// Refuses a number of things that is not the one needed.
pub(super) fn same(what: impl Into<String>, expected: usize, found: usize) -> Result<(), StrainError> {
    if expected == found { Ok(()) } else { Err(StrainError::Count { what: what.into(), expected, found }) }
}
