//! Pose correctives: what joints do to a face beyond skinning (section A.2 of Animatomy, the 9K + 3 shapes of SMPL).
//!
//! With V̂(t) the unposed targets, T̄ the rest mesh (metres) and f(t) the 9K + 3 features (every entry of every joint's
//! rotation less that of rest, and the jaw's translation), the loss
//!
//! ```text
//! L(P) = Σ_t ‖V̂(t) − T̄ − Σ_k f_k(t) P_k‖²
//! ```
//!
//! has its least where (Σ f fᵀ) P = Σ f (V̂ − T̄)ᵀ. The entries of a rotation depend on each other, and some hardly differ from
//! rest, so the matrix tells little of some directions. With every feature divided by its root mean square (g = S f), the
//! greatest eigenvalue Λ of Σ g gᵀ and a stiffness κ ≥ 0 (unitless), the shapes are
//!
//! ```text
//! P = S (Σ g gᵀ + κ Λ I)⁻¹ Σ g (V̂ − T̄)ᵀ
//! ```
//!
//! (ridge regression, Hoerl and Kennard 1970): a direction much weaker than κ times the strongest is left to the strains. κ = 0
//! is the loss as it stands, by the pseudo-inverse: of all shapes with the least loss the smallest.

use super::error::{StrainError, same};
use super::joints::{joints, pose_channels};
use super::matrix::product;
use crate::data::{Curves, Driver, Meshes, Rig, Shape};
use crate::rig::ShapeDrivers;
use faer::{Mat, Side};
use glam::Vec3;

/// Shorter displacements than this (metres a unit) are nothing.
const STILL_M: f32 = 1e-9;

/// Adds pose correctives to a rig with joints, fitted to `unposed` meshes (joints turned back, see
/// [`unpose_meshes`](super::unpose_meshes)). `stiffness` is κ.
///
/// # Errors
/// Where meshes, poses and rig do not fit, the stiffness is negative, or the rig has pose correctives already.
pub fn fit_pose_shapes(rig: &Rig, unposed: &Meshes, poses: &Curves, stiffness: f64) -> Result<Rig, StrainError> {
    if !(stiffness.is_finite() && stiffness >= 0.0) {
        return Err(StrainError::Setting {
            what: "the stiffness of pose shapes",
            value: stiffness,
            wanted: "0 or more",
        });
    }
    same("vertices of the meshes", rig.neutral.len(), unposed.vertices())?;
    same("frames of the poses", unposed.frames(), poses.frames())?;
    super::skinning::check_meshes(unposed)?;
    let turns = rig.shapes.iter().filter(|shape| matches!(shape.driver, Driver::Turn { .. })).count();
    same("pose correctives that the rig has already", 0, turns)?;
    let mut rig = rig.clone();
    let features = add_drivers(&mut rig)?;
    let mut values = feature_values(&rig, &features, poses)?;
    let scales = standardise(&mut values);
    let targets = offsets(&rig.neutral, unposed);
    let normal = product(values.as_ref(), values.transpose());
    let right = product(values.as_ref(), targets.transpose());
    let eigen = normal
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| StrainError::Decomposition { what: "the motion of the joints" })?;
    let (levels, vectors) = (eigen.S().column_vector(), eigen.U());
    let largest = levels.iter().copied().fold(0.0, f64::max);
    let mut inverse = Mat::<f64>::zeros(features.len(), features.len());
    for place in (0..features.len()).filter(|place| levels[*place] > ROUNDING * largest) {
        let own = vectors.col(place);
        inverse += own * own.transpose() * faer::Scale(1.0 / (levels[place] + stiffness * largest));
    }
    let found = product(inverse.as_ref(), right.as_ref());
    for (row, shape) in features.into_iter().enumerate() {
        let (vertices, deltas) = sparse((0..rig.neutral.len()).map(|vertex| at(&found, row, vertex, scales[row])));
        (rig.shapes[shape].vertices, rig.shapes[shape].deltas) = (vertices, deltas);
    }
    Ok(rig.checked()?)
}

/// Eigenvalues below this share of the greatest are rounding.
const ROUNDING: f64 = 1e-13;

/// Features (radians, metres) that are smaller than this in the root mean square do not move.
const AT_REST: f64 = 1e-7;

/// Divides each row by its root mean square; gives what it was multiplied by.
fn standardise(values: &mut Mat<f64>) -> Vec<f64> {
    let frames = values.ncols();
    let scale = |row: usize| {
        let mean = (0..frames).map(|frame| values[(row, frame)].powi(2)).sum::<f64>() / frames.max(1) as f64;
        1.0 / mean.sqrt().max(AT_REST)
    };
    let scales: Vec<f64> = (0..values.nrows()).map(scale).collect();
    for frame in 0..frames {
        for (row, scale) in scales.iter().enumerate() {
            values[(row, frame)] *= scale;
        }
    }
    scales
}

fn at(found: &Mat<f64>, row: usize, vertex: usize, scale: f64) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|axis| (scale * found[(row, 3 * vertex + axis)]) as f32))
}

/// Displaced vertices and their displacements.
pub(super) fn sparse(deltas: impl Iterator<Item = Vec3>) -> (Vec<u32>, Vec<Vec3>) {
    (0..).zip(deltas).filter(|(_, delta)| delta.abs().max_element() > STILL_M).unzip()
}

/// Posed positions less the rest, `3 N × T` (metres).
pub(super) fn offsets(rest: &[Vec3], meshes: &Meshes) -> Mat<f64> {
    let mut out = Mat::<f64>::zeros(3 * rest.len(), meshes.frames());
    super::matrix::pieces(out.as_mut(), |first, mut out| {
        for frame in 0..out.ncols() {
            for (vertex, (posed, rest)) in meshes.frame(first + frame).iter().zip(rest).enumerate() {
                let offset = posed.as_dvec3() - rest.as_dvec3();
                for axis in 0..3 {
                    out[(3 * vertex + axis, frame)] = offset[axis];
                }
            }
        }
    });
    out
}

/// Adds an empty shape for each entry of each joint's rotation, and finds those of the jaw's translation: the features.
fn add_drivers(rig: &mut Rig) -> Result<Vec<usize>, StrainError> {
    let names: Vec<String> = joints(rig).iter().map(|joint| joint.name.to_owned()).collect();
    if names.is_empty() || pose_channels(rig)?.is_empty() {
        return Err(StrainError::NoJoints { rig: rig.name.clone() });
    }
    let mut features = Vec::new();
    for (joint, name) in names.iter().enumerate() {
        for entry in 0..9 {
            let (row, column) = (entry / 3, entry % 3);
            features.push(rig.shapes.len());
            let driver = Driver::Turn { joint: joint as u32, row: row as u32, column: column as u32 };
            let name = format!("{name}_pose_{row}{column}");
            rig.shapes.push(Shape { name, driver, vertices: Vec::new(), deltas: Vec::new() });
        }
    }
    let jaw = rig.jaw.iter().flat_map(|jaw| &jaw.motions).filter(|motion| motion.translation_m != Vec3::ZERO);
    features.extend(jaw.map(|motion| motion.shape as usize));
    Ok(features)
}

/// f: the weights of the features in every frame, features × frames.
fn feature_values(rig: &Rig, features: &[usize], poses: &Curves) -> Result<Mat<f64>, StrainError> {
    let arranged = poses.arrange(&pose_channels(rig)?, None)?.arrange(&rig.channels, Some(0.0))?;
    let drivers = ShapeDrivers::new(rig)?;
    let mut out = Mat::<f64>::zeros(features.len(), poses.frames());
    let mut all = Vec::new();
    for frame in 0..poses.frames() {
        let values: Vec<f64> = arranged.frame(frame).iter().map(|value| f64::from(*value)).collect();
        drivers.weights_into(&values, &mut all);
        for (row, feature) in features.iter().enumerate() {
            out[(row, frame)] = all[*feature];
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;
    use crate::strain::{Keep, toy, unpose_meshes};

    /// A head whose pose moves more than skinning does: a rig with known correctives.
    fn corrected() -> Rig {
        let mut rig = toy::jointed_head();
        let features = add_drivers(&mut rig).unwrap();
        let mut dice = Dice(41);
        for feature in &features {
            rig.shapes[*feature].vertices = (0..64).collect();
            rig.shapes[*feature].deltas = (0..64).map(|_| dice.point() * 0.01).collect();
        }
        rig
    }

    #[test]
    fn the_features_are_nine_a_joint_and_three() {
        let mut rig = toy::jointed_head();
        assert_eq!(add_drivers(&mut rig).unwrap().len(), 9 * 2 + 3);
    }

    #[test]
    fn what_correctives_did_is_explained_on_poses_not_seen() {
        let known = corrected();
        let poses = toy::pose_curves(&known, 200);
        let meshes = toy::evaluated(&known, &poses);
        let base = toy::jointed_head();
        let unposed = unpose_meshes(&base, &meshes, &poses, Keep::PoseShapes).unwrap();
        let rig = fit_pose_shapes(&base, &unposed, &poses, 0.0).unwrap();
        // A rotation by 0.25 rad has entries of the second order too: the least of them is seen poorly.
        let fresh = toy::pose_curves(&known, 230);
        for (a, b) in toy::evaluated(&rig, &fresh).positions().iter().zip(toy::evaluated(&known, &fresh).positions()) {
            assert!(a.abs_diff_eq(*b, 2e-6), "{a} {b}");
        }
        let left = unpose_meshes(&rig, &meshes, &poses, Keep::Strains).unwrap();
        assert!(left.frame(7).iter().zip(&rig.neutral).all(|(a, b)| a.abs_diff_eq(*b, 2e-6)));
        assert_eq!(left.frame(0), &rig.neutral[..]);
        assert!(fit_pose_shapes(&rig, &unposed, &poses, 0.0).is_err(), "a second time is refused");
        assert!(fit_pose_shapes(&base, &unposed, &poses, -1.0).is_err());
        let size = |rig: &Rig| rig.shapes.iter().flat_map(|shape| &shape.deltas).map(|by| by.length()).sum::<f32>();
        assert!(
            size(&fit_pose_shapes(&base, &unposed, &poses, 0.5).unwrap()) < size(&rig),
            "stiffer shapes are smaller"
        );
    }

    /// The residual is orthogonal to every feature: the slope of the loss is nought.
    #[test]
    fn the_normal_equations_hold() {
        let known = toy::with_shapes(&corrected(), 3, 0.01);
        let poses = toy::pose_curves(&known, 60);
        let both = toy::beside(&poses, &toy::values(&known.channels[9..], 60, 1.0, 8));
        let base = toy::jointed_head();
        let unposed = unpose_meshes(&base, &toy::evaluated(&known, &both), &poses, Keep::PoseShapes).unwrap();
        let rig = fit_pose_shapes(&base, &unposed, &poses, 0.0).unwrap();
        let mut drivers = base.clone();
        let features = add_drivers(&mut drivers).unwrap();
        let values = feature_values(&drivers, &features, &poses).unwrap();
        let shapes = toy::evaluated(&rig, &poses);
        let modelled = offsets(&base.neutral, &unpose_meshes(&base, &shapes, &poses, Keep::PoseShapes).unwrap());
        let residual = offsets(&base.neutral, &unposed) - modelled;
        let slope = &values * residual.transpose();
        let scale = (&values * offsets(&base.neutral, &unposed).transpose()).norm_l2();
        assert!(slope.norm_l2() < 2e-4 * scale, "{} of {scale}", slope.norm_l2());
    }
}
