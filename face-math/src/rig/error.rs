//! What can go wrong with rigs: each error names the place and the cure.

use super::RigidError;
use crate::data::DataError;

/// Why a rig cannot be posed, attached to, or split.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RigError {
    /// The parts of a value do not fit together, or a name is not there.
    #[error(transparent)]
    Data(#[from] DataError),
    /// As many weights are needed as the rig has channels.
    #[error("{found} weights for a rig of {expected} channels; arrange the curves by the rig's channels first")]
    WeightCount {
        /// Channels of the rig.
        expected: usize,
        /// Weights given.
        found: usize,
    },
    /// A weight is NaN or infinite.
    #[error("channel `{channel}` is {value} in frame {frame}; fill or mend the curve first")]
    Weight {
        /// The channel.
        channel: String,
        /// Number of the frame, as its source counts.
        frame: i64,
        /// The weight.
        value: f32,
    },
    /// An in-between that peaks at or beyond the ends of its channel.
    #[error("in-between `{shape}` peaks at {peak}; name it `channel@p` with p between 0 and 1")]
    Peak {
        /// The shape.
        shape: String,
        /// Its peak.
        peak: f32,
    },
    /// A pose corrective of a joint that something else than a channel turns.
    #[error(
        "pose corrective `{shape}`: its joint is turned by `{by}`, which is no channel; let channels alone turn it"
    )]
    Turned {
        /// The corrective.
        shape: String,
        /// The shape that turns the joint.
        by: String,
    },
    /// A neutral marker has no position.
    #[error("neutral marker `{marker}` is missing in frame {frame}; triangulate it from more views or leave it out")]
    MissingMarker {
        /// The marker.
        marker: String,
        /// Number of the frame, as its source counts.
        frame: i64,
    },
    /// Markers that hold no frame at all.
    #[error("the neutral markers hold no frame; give one frame of the relaxed face")]
    NoFrame,
    /// None of the parts that markers may sit on has a triangle.
    #[error("rig `{rig}` has no triangles in {parts}; choose parts that hold the skin")]
    NoSurface {
        /// Name of the rig.
        rig: String,
        /// The parts looked at.
        parts: String,
    },
    /// The jaw is already a joint.
    #[error("the jaw of rig `{rig}` is a joint already; split a rig only once")]
    AlreadySplit {
        /// Name of the rig.
        rig: String,
    },
    /// No shape moves the part that stands for the jaw.
    #[error(
        "no channel moves part `{part}` of rig `{rig}` as a rigid body: {found}; name the part that only the jaw \
         moves (the lower teeth), or list the jaw channels"
    )]
    NoJawShape {
        /// Name of the rig.
        rig: String,
        /// The part.
        part: String,
        /// What the channels do to it.
        found: String,
    },
    /// A channel that is said to move the jaw leaves the jaw's part where it is.
    #[error(
        "channel `{channel}` moves part `{part}` by {motion_mm:.3} mm only, less than {least_mm:.3} mm; take it off \
         the jaw channels"
    )]
    StillJaw {
        /// The channel.
        channel: String,
        /// The part.
        part: String,
        /// Its mean motion in millimetres.
        motion_mm: f64,
        /// The least motion asked for, in millimetres.
        least_mm: f64,
    },
    /// The motion of the jaw's part gives no rotation.
    #[error("part `{part}` at shape `{shape}`: {source}")]
    JawFit {
        /// The part.
        part: String,
        /// The shape.
        shape: String,
        /// What the fit says.
        source: RigidError,
    },
    /// M R + (1 − M) I cannot be inverted: the jaw turns by about half a circle.
    #[error(
        "shape `{shape}`, vertex {vertex}: a jaw weight of {weight} under a turn of {angle_deg:.1} degrees flattens \
         the skin; check the motion of the jaw's part"
    )]
    Flat {
        /// The shape.
        shape: String,
        /// The vertex.
        vertex: usize,
        /// Its jaw weight.
        weight: f32,
        /// The jaw's turn in degrees.
        angle_deg: f64,
    },
}
