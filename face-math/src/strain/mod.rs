//! Strain-driven faces (Animatomy): joints, muscles and what their stretching does to skin, learned from animated meshes.
//!
//! M(θ, γ) = W(T̄ + `B_P`(θ) + `B_E` γ, θ): a rest mesh, pose correctives of the joints' pose θ, expression shapes of the
//! strains γ (relative stretch of muscle curves), skinned by the joints. All of it fits into a [`Rig`](crate::data::Rig), so
//! whatever takes a rig takes a strain rig.
//!
//! Read in the order of the paper's supplement:
//!
//! - [`add_joints`], [`measure_poses`]: jaw and eyes, and θ of animated meshes.
//! - [`trace_muscles`], [`measure_strains`]: muscles as shortest paths on the skin, and γ.
//! - [`fit_skinning`] (A.1), [`unpose_meshes`], [`fit_pose_shapes`] (A.2).
//! - [`train_strain_rig`] (A.3, by [`fit_strain_shapes()`]); [`fit_linear_rig`] and [`mesh_error`] to measure it against.
//! - [`learn_mesh_space`], [`MeshFitter`] (B.1), [`solve_jaw_pose`] (B.2), [`solve_strains()`] (B.3).
//! - [`Transfer`]: meshes and rigs onto another head; [`transfer_guides`] (C) on top.

mod banded;
mod cholesky;
mod error;
mod expression_weights;
mod hanging;
mod jaw_misfit;
mod joints;
mod matrix;
mod measure;
mod mesh_space;
mod muscles;
mod pose_shapes;
mod shapes;
mod skinning;
mod solve_jaw;
mod solve_strains;
#[cfg(test)]
mod solve_strains_tests;
mod strain_problem;
mod strain_sums;
mod surface;
#[cfg(test)]
pub(crate) mod toy;
mod train;
mod transfer;
mod transfer_rig;
mod unpose;

pub use error::StrainError;
pub use expression_weights::expression_weights;
pub use joints::{
    JointOptions, NamedJoint, POSE_CHANNELS, Poses, add_joints, euler_rad, joints, measure_poses, pose_channels,
};
pub use measure::{distance_penalties, measure_strains};
pub use mesh_space::{FittedMeshes, MeshFitter, learn_mesh_space};
pub use muscles::{MusclePlan, Place, PlannedMuscle, mirrored_landmark, spread_muscles, trace_muscles};
pub use pose_shapes::fit_pose_shapes;
pub use shapes::{StrainShapeOptions, StrainShapes, expression_shapes, fit_strain_shapes, refined_strains};
pub use skinning::{FittedSkinning, fit_skinning};
pub use solve_jaw::{JawSolveOptions, SolvedJaw, solve_jaw_pose};
pub use solve_strains::{Manifold, SolvedStrains, StrainSolveOptions, solve_strains, strain_channels};
pub use surface::Surface;
pub use train::{MeshError, StrainReach, TrainedStrains, fit_linear_rig, mesh_error, train_strain_rig};
pub use transfer::{Transfer, TransferOptions, transfer_guides};
pub use unpose::{Keep, unpose_meshes};
