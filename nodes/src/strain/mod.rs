//! Nodes for strain-driven faces (Animatomy): joints and muscles on a head, a strain rig learned from animated meshes, and
//! meshes turned into the strains that move it. Between rigs and what is saved.

mod add_joints;
mod fit_linear_rig;
mod fit_mesh_targets;
mod fit_pose_shapes;
mod fit_skinning;
mod fit_strain_shapes;
pub(crate) mod heads;
mod learn_mesh_space;
mod measure_poses;
mod measure_strains;
mod mesh_error;
mod solve_jaw_pose;
mod solve_strains;
#[cfg(test)]
pub(crate) mod toy;
mod trace_muscles;
mod train_strain_autoencoder;
mod transfer_guides;
mod transfer_meshes;
mod unpose_meshes;

pub use add_joints::AddJoints;
pub use fit_linear_rig::FitLinearRig;
pub use fit_mesh_targets::FitMeshTargets;
pub use fit_pose_shapes::FitPoseShapes;
pub use fit_skinning::FitSkinning;
pub use fit_strain_shapes::FitStrainShapes;
pub use learn_mesh_space::LearnMeshSpace;
pub use measure_poses::MeasurePoses;
pub use measure_strains::MeasureStrains;
pub use mesh_error::MeshError;
pub use solve_jaw_pose::SolveJawPose;
pub use solve_strains::SolveStrains;
pub use trace_muscles::TraceMuscles;
pub use train_strain_autoencoder::TrainStrainAutoencoder;
pub use transfer_guides::TransferGuides;
pub use transfer_meshes::TransferMeshes;
pub use unpose_meshes::UnposeMeshes;

use face_math::data::{Curves, Meshes};
use face_math::strain::StrainError;
use graph_core::node::NodeError;

/// The error of a solver as that of the input it concerns. The ports `rig`, `meshes` and `poses` are called so in all nodes
/// that use this.
fn fault(error: StrainError) -> NodeError {
    let port = match &error {
        StrainError::Rig(_) | StrainError::NoJoints { .. } | StrainError::NothingRigid { .. } => "rig",
        StrainError::Data(_) | StrainError::NotFinite { what: "pose channel", .. } => "poses",
        StrainError::Count { .. }
        | StrainError::NotFinite { .. }
        | StrainError::Flat { .. }
        | StrainError::TooFewFrames { .. } => "meshes",
        _ => return NodeError::failed(error),
    };
    NodeError::input(port, error)
}

/// A curve of distances in millimetres, from metres.
fn millimetres(meshes: &Meshes, name: &str, metres: &[f64]) -> Result<Curves, NodeError> {
    let values = metres.iter().map(|metres| (1000.0 * metres) as f32).collect();
    Curves::new(meshes.frame_axis(), vec![name.to_owned()], values).map_err(NodeError::failed)
}
