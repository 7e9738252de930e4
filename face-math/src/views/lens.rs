//! A calibrated camera's lens: points of the world into its picture, and back to rays.
//!
//! `OpenCV`'s camera model (its manual, "Camera Calibration and 3D Reconstruction"; Brown, "Decentering distortion of
//! lenses", 1966). With `x_cam = R X + t` (metres), `x = x_cam/z_cam`, `y = y_cam/z_cam` and r² = x² + y²:
//!
//! ```text
//! x' = x (1 + k₁ r² + k₂ r⁴ + k₃ r⁶) + 2 p₁ x y + p₂ (r² + 2 x²)        u = fx x' + cx
//! y' = y (1 + k₁ r² + k₂ r⁴ + k₃ r⁶) + p₁ (r² + 2 y²) + 2 p₂ x y        v = fy y' + cy
//! ```
//!
//! u, v, fx, fy, cx, cy in pixels; k, p unitless.

use crate::data::CalibratedCamera;
use glam::{DMat2, DVec2, DVec3};

/// A point of the world in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// u and v in pixels.
    pub point_px: DVec2,
    /// ∂u/∂X and ∂v/∂X, in pixels a metre.
    pub gradients: [DVec3; 2],
}

/// A ray in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it begins, in metres.
    pub origin_m: DVec3,
    /// Where it goes; of length 1.
    pub direction: DVec3,
}

/// Nearer than this before the camera (metres) nothing is seen.
const NEAREST_M: f64 = 1e-4;

/// Where `camera` sees the point `place` (metres), and how that moves with the point; none behind the camera, or where the
/// lens model folds over (its distortion turns back towards the middle, which no lens does).
pub fn project(camera: &CalibratedCamera, place: DVec3) -> Option<Projected> {
    let seen = camera.rotation * place + camera.translation_m;
    if seen.z < NEAREST_M || !seen.is_finite() {
        return None;
    }
    let flat = DVec2::new(seen.x, seen.y) / seen.z;
    let (bent, slope) = bend(&camera.distortion, flat);
    if folds(&slope) {
        return None;
    }
    let focal = DVec2::from_array(camera.focal_px);
    let point_px = focal * bent + DVec2::from_array(camera.centre_px);
    // ∂x/∂X = (R₁ − x R₃) / z, and alike for y; R₁, R₂, R₃ the rows of R.
    let rows = camera.rotation.transpose();
    let across = (rows.x_axis - flat.x * rows.z_axis) / seen.z;
    let down = (rows.y_axis - flat.y * rows.z_axis) / seen.z;
    let gradients = [
        focal.x * (slope.x_axis.x * across + slope.y_axis.x * down),
        focal.y * (slope.x_axis.y * across + slope.y_axis.y * down),
    ];
    Some(Projected { point_px, gradients })
}

/// The ray through the point `point_px` (pixels) of a picture; none where no direction is seen there, as far outside of a
/// picture whose lens model folds over.
pub fn ray_through(camera: &CalibratedCamera, point_px: DVec2) -> Option<Ray> {
    let bent = (point_px - DVec2::from_array(camera.centre_px)) / DVec2::from_array(camera.focal_px);
    let flat = unbend(&camera.distortion, bent)?;
    let direction = camera.rotation.transpose() * DVec3::new(flat.x, flat.y, 1.0);
    Some(Ray { origin_m: camera.eye_m(), direction: direction.normalize() })
}

/// (x', y') of (x, y), and its derivative: column i by coordinate i.
fn bend(distortion: &[f64; 5], flat: DVec2) -> (DVec2, DMat2) {
    let [k1, k2, p1, p2, k3] = *distortion;
    let DVec2 { x, y } = flat;
    let square = flat.length_squared();
    let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
    // ∂ radial / ∂ r², times 2 x or 2 y.
    let steeper = 2.0 * (k1 + square * (2.0 * k2 + square * 3.0 * k3));
    let bent = DVec2::new(
        x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
        y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
    );
    let mixed = steeper * x * y + 2.0 * (p1 * x + p2 * y);
    let slope = DMat2::from_cols(
        DVec2::new(radial + steeper * x * x + 2.0 * p1 * y + 6.0 * p2 * x, mixed),
        DVec2::new(mixed, radial + steeper * y * y + 6.0 * p1 * y + 2.0 * p2 * x),
    );
    (bent, slope)
}

/// Whether the lens model turns the picture over, along one axis or both, where its derivative is `slope`.
fn folds(slope: &DMat2) -> bool {
    slope.determinant() <= 0.0 || slope.x_axis.x + slope.y_axis.y <= 0.0
}

/// (x, y) of (x', y') by Newton's method from x', y' themselves.
fn unbend(distortion: &[f64; 5], bent: DVec2) -> Option<DVec2> {
    let mut flat = bent;
    for _ in 0..50 {
        let (found, slope) = bend(distortion, flat);
        if folds(&slope) {
            return None;
        }
        let step = slope.inverse() * (bent - found);
        flat += step;
        if step.length() <= 1e-14 * (1.0 + flat.length()) {
            return Some(flat);
        }
    }
    // Rounding may keep the last digits moving.
    (bend(distortion, flat).0.distance(bent) < 1e-10).then_some(flat)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::rig::toy::Dice;
    use glam::DMat3;

    /// A camera at `yaw` about the head, 0.7 m before it, with a lens like those of studio cameras.
    pub(in crate::views) fn camera(name: &str, yaw_rad: f64) -> CalibratedCamera {
        // Looks along its own +Z, with y down: half a turn about x from the world's axes.
        let rotation = DMat3::from_rotation_x(std::f64::consts::PI - 0.1) * DMat3::from_rotation_y(yaw_rad);
        CalibratedCamera {
            name: name.to_owned(),
            size_px: [2048, 1536],
            focal_px: [2400.0, 2390.0],
            centre_px: [1024.0, 768.0],
            rotation,
            translation_m: DVec3::new(0.01, -0.02, 0.7),
            distortion: [-0.08, 0.02, 5e-4, -3e-4, 1e-3],
        }
    }

    #[test]
    fn the_gradients_are_those_of_finite_differences() {
        let camera = camera("a", 0.4);
        let mut dice = Dice(3);
        for _ in 0..50 {
            let place = dice.point().as_dvec3() * 0.1;
            let found = project(&camera, place).unwrap();
            let step = 1e-6;
            for axis in 0..3 {
                let mut shift = DVec3::ZERO;
                shift[axis] = step;
                let ahead = project(&camera, place + shift).unwrap().point_px;
                let behind = project(&camera, place - shift).unwrap().point_px;
                let slope = (ahead - behind) / (2.0 * step);
                let exact = DVec2::new(found.gradients[0][axis], found.gradients[1][axis]);
                assert!(slope.distance(exact) < 1e-4 * exact.length().max(1.0), "{slope} {exact}");
            }
        }
    }

    #[test]
    fn the_ray_through_a_projected_point_meets_the_point() {
        let camera = camera("a", -0.7);
        let mut dice = Dice(4);
        for _ in 0..100 {
            let place = dice.point().as_dvec3() * 0.15;
            let ray = ray_through(&camera, project(&camera, place).unwrap().point_px).unwrap();
            let along = (place - ray.origin_m).dot(ray.direction);
            assert!(along > 0.0 && (ray.origin_m + along * ray.direction).distance(place) < 1e-12);
        }
    }

    #[test]
    fn the_middle_of_a_picture_is_straight_ahead() {
        let camera = camera("a", 0.0);
        let ray = ray_through(&camera, DVec2::from_array(camera.centre_px)).unwrap();
        let ahead = camera.rotation.transpose() * DVec3::Z;
        assert!(ray.direction.abs_diff_eq(ahead, 1e-12) && ray.origin_m.abs_diff_eq(camera.eye_m(), 1e-12));
    }

    #[test]
    fn nothing_is_seen_behind_a_camera_or_beyond_its_lens() {
        let camera = camera("a", 0.0);
        let behind = camera.eye_m() - 0.5 * (camera.rotation.transpose() * DVec3::Z);
        assert!(project(&camera, behind).is_none());
        let folding = CalibratedCamera { distortion: [-0.5, 0.0, 0.0, 0.0, 0.0], ..camera };
        assert!(ray_through(&folding, DVec2::new(9e4, 0.0)).is_none());
    }
}
