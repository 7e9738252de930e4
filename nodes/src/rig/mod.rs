//! Nodes that make training motion and puppet markers from a rig: between loading and solving.

mod attach_markers;
mod evaluate_rig;
mod facs_sweep;
mod join_meshes;
mod join_shapes;
mod keep_parts;
mod merge_curves;
mod mix_regions;
mod place_markers;
mod range_of_motion;
mod register_markers;
mod retarget_curves;
mod skin_jaw;
mod synthesize_markers;
#[cfg(test)]
pub(crate) mod toy;
mod transfer_rig;

pub use attach_markers::AttachMarkers;
pub use evaluate_rig::EvaluateRig;
pub use facs_sweep::FacsSweep;
pub use join_meshes::JoinMeshes;
pub use join_shapes::JoinShapes;
pub use keep_parts::KeepParts;
pub use merge_curves::MergeCurves;
pub use mix_regions::MixRegions;
pub use place_markers::PlaceMarkers;
pub use range_of_motion::RangeOfMotion;
pub use register_markers::RegisterMarkers;
pub use retarget_curves::RetargetCurves;
pub use skin_jaw::SkinJaw;
pub use synthesize_markers::SynthesizeMarkers;
pub use transfer_rig::TransferRig;

use face_math::data::Curves;
use graph_core::node::NodeError;
use wire::FrameAxis;

/// Refuses curves on `port` that hold NaN or infinity.
pub(crate) fn check_finite(port: &str, curves: &Curves) -> Result<(), NodeError> {
    let width = curves.channels().len().max(1);
    let Some(place) = curves.values().iter().position(|value| !value.is_finite()) else { return Ok(()) };
    let (channel, frame) = (&curves.channels()[place % width], frame_number(curves.frame_axis(), place / width));
    let value = curves.values()[place];
    Err(NodeError::input(port, format!("channel `{channel}` is {value} in frame {frame}; mend the curve first")))
}

/// The number of the frame at position `place`, as its source counts.
pub(crate) fn frame_number(axis: FrameAxis, place: usize) -> i64 {
    axis.slice(&(place..place + 1)).first
}
