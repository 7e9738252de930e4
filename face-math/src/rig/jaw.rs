//! Where the jaw stands at given shape weights: the rotation and translation that skinning applies.
//!
//! R(w) comes of adding the shapes' Euler angles, θ(w) = Σ wᵢ θᵢ (radians), and R = Rz(θz) Ry(θy) Rx(θx);
//! T(w) = Σ wᵢ Tᵢ (metres). About a pivot c, x ↦ R (x − c) + c + T. Section 6 of the deepfake capture paper ("Euler angle interpolation of the Rᵢ"). The sum
//! runs over all jaw shapes, channels as well as correctives.

use crate::data::JawSkin;
use glam::{DMat3, DVec3};

/// The jaw at given shape weights: x ↦ R x + T.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JawPose {
    /// R.
    pub rotation: DMat3,
    /// T in metres.
    pub translation_m: DVec3,
    /// ∂R/∂θx, ∂R/∂θy, ∂R/∂θz, a radian.
    pub turns: [DMat3; 3],
}

impl Default for JawPose {
    fn default() -> Self {
        Self::of(DVec3::ZERO, DVec3::ZERO)
    }
}

impl JawPose {
    /// The pose of `euler_rad` (about the fixed axes x, then y, then z) and `translation_m`.
    pub fn of(euler_rad: DVec3, translation_m: DVec3) -> Self {
        let (x, y, z) = (turn(0, euler_rad.x), turn(1, euler_rad.y), turn(2, euler_rad.z));
        Self {
            rotation: z[0] * y[0] * x[0],
            translation_m,
            turns: [z[0] * y[0] * x[1], z[0] * y[1] * x[0], z[1] * y[0] * x[0]],
        }
    }

    /// The pose at given shape weights.
    pub fn at(jaw: &JawSkin, shape_weights: &[f64]) -> Self {
        let (mut euler, mut translation) = (DVec3::ZERO, DVec3::ZERO);
        for motion in &jaw.motions {
            let weight = shape_weights[motion.shape as usize];
            euler += weight * motion.euler_rad.as_dvec3();
            translation += weight * motion.translation_m.as_dvec3();
        }
        Self::about(jaw.pivot_m.as_dvec3(), euler, translation)
    }

    /// The pose of `euler_rad` about the pivot c, moved by `translation_m`: its T is c − R c + `translation_m`.
    pub fn about(pivot_m: DVec3, euler_rad: DVec3, translation_m: DVec3) -> Self {
        let pose = Self::of(euler_rad, translation_m);
        Self { translation_m: pivot_m - pose.rotation * pivot_m + translation_m, ..pose }
    }
}

/// The rotation by `angle_rad` about axis 0, 1 or 2, and its derivative by the angle.
fn turn(axis: usize, angle_rad: f64) -> [DMat3; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let entries = |along: f64, cos: f64, sin: f64| {
        let mut columns = [[0.0; 3]; 3];
        columns[axis][axis] = along;
        columns[next][next] = cos;
        columns[next][last] = sin;
        columns[last][next] = -sin;
        columns[last][last] = cos;
        DMat3::from_cols_array_2d(&columns)
    };
    [entries(1.0, cos, sin), entries(0.0, -sin, cos)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::JawMotion;

    #[test]
    fn the_rotation_is_that_of_a_single_motion() {
        let euler = glam::Vec3::new(0.4, -0.2, 0.1);
        let motion = JawMotion { shape: 0, euler_rad: euler, translation_m: glam::Vec3::X };
        let pose = JawPose::at(&JawSkin { motions: vec![motion], ..JawSkin::default() }, &[1.0]);
        let expected = DMat3::from_quat(motion.rotation().as_dquat());
        assert!(pose.rotation.abs_diff_eq(expected, 1e-6));
        assert_eq!(pose.translation_m, DVec3::X);
        assert!((pose.rotation.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn opening_turns_first() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let pose = JawPose::of(DVec3::new(quarter, quarter, 0.0), DVec3::ZERO);
        // About x: y goes to z; then about y: z goes to x.
        assert!((pose.rotation * DVec3::Y).abs_diff_eq(DVec3::X, 1e-12));
    }

    #[test]
    fn turns_equal_finite_differences() {
        let euler = DVec3::new(0.3, -0.5, 0.2);
        let step = 1e-6;
        for axis in 0..3 {
            let mut shift = DVec3::ZERO;
            shift[axis] = step;
            let up = JawPose::of(euler + shift, DVec3::ZERO).rotation;
            let down = JawPose::of(euler - shift, DVec3::ZERO).rotation;
            let slope = (up - down) * (0.5 / step);
            assert!(slope.abs_diff_eq(JawPose::of(euler, DVec3::ZERO).turns[axis], 1e-9));
        }
    }
}
