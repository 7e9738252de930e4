//! The best rigid motion between two sets of points: for jaws, and for heads that must be held still.
//!
//! Least squares: minimise Σ wₖ ‖R aₖ + t − bₖ‖² over rotations R and translations t (metres). With the weighted means
//! ā, b̄ and the covariance H = Σ wₖ (aₖ − ā)(bₖ − b̄)ᵀ = U Σ Vᵀ,
//!
//! ```text
//! R = V diag(1, 1, det(V Uᵀ)) Uᵀ,   t = b̄ − R ā
//! ```
//!
//! Kabsch, "A solution for the best rotation to relate two sets of vectors", Acta Cryst. A32 (1976); the determinant
//! keeps reflections out (Umeyama, PAMI 13, 1991, Eq. 40 to 43).

use faer::Mat;
use glam::{DMat3, DVec3};

/// A rigid motion: x ↦ R x + t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    /// R, a rotation: orthonormal, determinant +1.
    pub rotation: DMat3,
    /// t in metres.
    pub translation_m: DVec3,
}

impl Rigid {
    /// Moves a point (metres).
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation_m
    }

    /// The motion that undoes this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation_m: -(rotation * self.translation_m) }
    }

    /// Angle of the rotation, in radians.
    pub fn angle_rad(&self) -> f64 {
        // |log R|: the skew part gives the sine, the trace the cosine; together they hold near 0 and near π.
        let r = self.rotation.to_cols_array_2d();
        let skew = DVec3::new(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
        (0.5 * skew.length()).atan2(0.5 * (r[0][0] + r[1][1] + r[2][2] - 1.0))
    }
}

/// A rigid motion and how well it fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidFit {
    /// The motion.
    pub motion: Rigid,
    /// Weighted root mean square distance that remains, in metres.
    pub residual_rms_m: f64,
}

/// Why two sets of points give no rigid motion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RigidError {
    /// The sets differ in size.
    #[error("{from} points onto {to} points ({weights} weights); give one target and one weight a point")]
    Sizes {
        /// Points to move.
        from: usize,
        /// Target points.
        to: usize,
        /// Weights.
        weights: usize,
    },
    /// A point or a weight is not a number, or a weight is negative.
    #[error("point {index} or its weight is not usable; leave missing points out")]
    Unusable {
        /// Position of the point.
        index: usize,
    },
    /// The points lie on a line, or there are too few: they leave a rotation free.
    #[error("{count} points with weight do not fix a rotation; give at least three that are not on one line")]
    Free {
        /// Points that have a weight.
        count: usize,
    },
}

/// The rigid motion that takes `from` nearest to `to` (metres), each point counting by its weight (all alike where none
/// are given).
///
/// # Errors
/// Where sizes differ, a number is not usable, or the points do not fix a rotation.
pub fn fit_rigid(from: &[DVec3], to: &[DVec3], weights: Option<&[f64]>) -> Result<RigidFit, RigidError> {
    let count = from.len();
    if to.len() != count || weights.is_some_and(|weights| weights.len() != count) {
        let weights = weights.map_or(count, <[f64]>::len);
        return Err(RigidError::Sizes { from: count, to: to.len(), weights });
    }
    let weight = |index: usize| weights.map_or(1.0, |weights| weights[index]);
    let usable = |index: &usize| {
        from[*index].is_finite() && to[*index].is_finite() && weight(*index).is_finite() && weight(*index) >= 0.0
    };
    if let Some(index) = (0..count).find(|index| !usable(index)) {
        return Err(RigidError::Unusable { index });
    }
    let free = RigidError::Free { count: (0..count).filter(|index| weight(*index) > 0.0).count() };
    let total: f64 = (0..count).map(weight).sum();
    if total <= 0.0 {
        return Err(free);
    }
    let mean = |points: &[DVec3]| points.iter().enumerate().map(|(k, p)| weight(k) * *p).sum::<DVec3>() / total;
    let (middle_from, middle_to) = (mean(from), mean(to));
    let mut covariance = Mat::<f64>::zeros(3, 3);
    for index in 0..count {
        let a = from[index] - middle_from;
        let b = to[index] - middle_to;
        for row in 0..3 {
            for column in 0..3 {
                covariance[(row, column)] += weight(index) * a[row] * b[column];
            }
        }
    }
    let decomposition = covariance.svd().map_err(|_| free.clone())?;
    let singular = decomposition.S().column_vector();
    // Two directions must spread: the second singular value tells, against the first.
    if singular[1] <= 1e-12 * singular[0].max(f64::MIN_POSITIVE) {
        return Err(free);
    }
    let matrix = |m: faer::MatRef<'_, f64>| {
        DMat3::from_cols_array_2d(&std::array::from_fn(|column| std::array::from_fn(|row| m[(row, column)])))
    };
    let (u, v) = (matrix(decomposition.U()), matrix(decomposition.V()));
    let handedness = (v * u.transpose()).determinant().signum();
    let rotation = v * DMat3::from_diagonal(DVec3::new(1.0, 1.0, handedness)) * u.transpose();
    let motion = Rigid { rotation, translation_m: middle_to - rotation * middle_from };
    let squares: f64 =
        (0..count).map(|index| weight(index) * motion.apply(from[index]).distance_squared(to[index])).sum();
    Ok(RigidFit { motion, residual_rms_m: (squares / total).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    fn cloud(count: usize) -> Vec<DVec3> {
        let mut dice = Dice(19);
        (0..count).map(|_| dice.point().as_dvec3()).collect()
    }

    #[test]
    fn a_rigid_motion_is_found_again() {
        for angle in [1e-7, 0.5, 3.1] {
            let known = Rigid {
                rotation: DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), angle),
                translation_m: DVec3::new(0.1, -2.0, 0.3),
            };
            let from = cloud(12);
            let to: Vec<_> = from.iter().map(|point| known.apply(*point)).collect();
            let fit = fit_rigid(&from, &to, None).unwrap();
            assert!(fit.motion.rotation.abs_diff_eq(known.rotation, 1e-12));
            assert!(fit.motion.translation_m.abs_diff_eq(known.translation_m, 1e-12));
            assert!(fit.residual_rms_m < 1e-12);
            assert!((fit.motion.angle_rad() - angle).abs() < 1e-9, "{} {angle}", fit.motion.angle_rad());
            let back = fit.motion.inverse().apply(to[3]);
            assert!(back.abs_diff_eq(from[3], 1e-12));
        }
    }

    #[test]
    fn a_mirror_image_still_gives_a_rotation() {
        let from = cloud(9);
        let to: Vec<_> = from.iter().map(|point| DVec3::new(-point.x, point.y, point.z)).collect();
        let fit = fit_rigid(&from, &to, None).unwrap();
        assert!((fit.motion.rotation.determinant() - 1.0).abs() < 1e-12);
        assert!(fit.residual_rms_m > 0.1);
    }

    #[test]
    fn three_points_in_a_plane_are_enough_and_a_line_is_not() {
        let from = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let turn = DMat3::from_rotation_z(1.0);
        let to = from.map(|point| turn * point);
        assert!(fit_rigid(&from, &to, None).unwrap().motion.rotation.abs_diff_eq(turn, 1e-12));
        let line = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        assert_eq!(fit_rigid(&line, &line, None).unwrap_err(), RigidError::Free { count: 3 });
        assert_eq!(fit_rigid(&[], &[], None).unwrap_err(), RigidError::Free { count: 0 });
    }

    #[test]
    fn a_point_without_weight_does_not_count() {
        let from = cloud(6);
        let mut to = from.clone();
        to[2] = DVec3::splat(100.0);
        let mut weights = [1.0; 6];
        weights[2] = 0.0;
        let fit = fit_rigid(&from, &to, Some(&weights)).unwrap();
        assert!(fit.residual_rms_m < 1e-12);
        to[1] = DVec3::NAN;
        assert_eq!(fit_rigid(&from, &to, Some(&weights)).unwrap_err(), RigidError::Unusable { index: 1 });
    }
}
