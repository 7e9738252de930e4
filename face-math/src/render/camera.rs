//! The camera: a perspective view on a turntable, from 3D metres to picture coordinates.

use glam::{Vec2, Vec3};

/// A perspective camera that looks at a point from a turntable position.
///
/// Yaw turns the camera around the head towards the performer's left (+X), pitch lifts it. At zero yaw and pitch it
/// stands in front of the face, on +Z, looking along −Z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// The point at the middle of the picture, in metres.
    pub target: Vec3,
    /// Distance of the camera from the target, in metres.
    pub distance_m: f32,
    /// Turn around the vertical through the target, in radians.
    pub yaw_rad: f32,
    /// Lift above the horizontal, in radians.
    pub pitch_rad: f32,
    /// Angle across the shorter side of the picture, in radians.
    pub field_of_view_rad: f32,
}

/// The axes of a camera in the world: right, up and forward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    pub eye: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    pub forward: Vec3,
}

impl Camera {
    /// A front view that holds all of `points` (metres), from whichever side it is turned to later.
    ///
    /// Points that are not finite are left out. The lens is a portrait lens (24°), for little distortion.
    pub fn framing(points: &[Vec3]) -> Self {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for point in points.iter().filter(|point| point.is_finite()) {
            low = low.min(*point);
            high = high.max(*point);
        }
        if low.x > high.x {
            (low, high) = (Vec3::splat(-0.1), Vec3::splat(0.1));
        }
        let target = (low + high) * 0.5;
        let field_of_view_rad = 24f32.to_radians();
        let (sin, tan) = ((field_of_view_rad * 0.5).sin(), (field_of_view_rad * 0.5).tan());
        // A point r beside the turntable's axis and h above the target comes as near as D − r to a camera at distance D:
        // h ≤ (D − r) tan; turned to the edge of its circle it needs r ≤ D sin.
        let mut distance_m: f32 = 1e-3;
        for offset in points.iter().filter(|point| point.is_finite()).map(|point| *point - target) {
            let beside = offset.x.hypot(offset.z);
            distance_m = distance_m.max(beside + offset.y.abs() / tan).max(beside / sin);
        }
        Self { target, distance_m: distance_m * 1.04, yaw_rad: 0.0, pitch_rad: 0.0, field_of_view_rad }
    }

    /// The same camera turned around the head to `yaw_rad`, lifted to `pitch_rad`.
    #[must_use]
    pub fn turned(self, yaw_rad: f32, pitch_rad: f32) -> Self {
        Self { yaw_rad, pitch_rad, ..self }
    }

    /// The same camera, nearer: `factor` 2 shows half the width.
    #[must_use]
    pub fn closer(self, factor: f32) -> Self {
        Self { field_of_view_rad: 2.0 * ((self.field_of_view_rad * 0.5).tan() / factor).atan(), ..self }
    }

    /// The same camera, looking at `target` (metres).
    #[must_use]
    pub fn at(self, target: Vec3) -> Self {
        Self { target, ..self }
    }

    pub(super) fn axes(&self) -> Axes {
        let (sin_yaw, cos_yaw) = self.yaw_rad.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch_rad.sin_cos();
        let back = Vec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        let right = Vec3::new(cos_yaw, 0.0, -sin_yaw);
        Axes { eye: self.target + back * self.distance_m, right, up: back.cross(right), forward: -back }
    }

    /// Where `point` (metres) falls in a picture of the given size: pixels from the top left, and the depth in metres
    /// along the view. `None` behind the camera or where the point is missing.
    pub fn project(&self, point: Vec3, width_px: usize, height_px: usize) -> Option<(Vec2, f32)> {
        self.projector(width_px, height_px).project(point)
    }

    pub(super) fn projector(&self, width_px: usize, height_px: usize) -> Projector {
        let short = width_px.min(height_px) as f32;
        Projector {
            axes: self.axes(),
            scale_px: short * 0.5 / (self.field_of_view_rad * 0.5).tan(),
            centre_px: Vec2::new(width_px as f32 * 0.5, height_px as f32 * 0.5),
        }
    }
}

/// A camera with a picture size: the pinhole projection c + f · (x, −y) / depth, with c and f in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projector {
    pub axes: Axes,
    pub scale_px: f32,
    pub centre_px: Vec2,
}

impl Projector {
    pub fn project(&self, point: Vec3) -> Option<(Vec2, f32)> {
        let offset = point - self.axes.eye;
        let depth_m = offset.dot(self.axes.forward);
        // A millimetre before the eye is as near as anything can be drawn; NaN fails the comparison too.
        if depth_m > 1e-3 {
            let across = Vec2::new(offset.dot(self.axes.right), -offset.dot(self.axes.up));
            Some((self.centre_px + across * (self.scale_px / depth_m), depth_m))
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framed_points_fall_inside_from_all_sides() {
        let points: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32 * 0.15, (i >> 1 & 1) as f32 * 0.25, (i >> 2) as f32 * 0.2))
            .collect();
        for step in 0..12 {
            let camera = Camera::framing(&points).turned(step as f32 * 0.6, 0.0);
            for point in &points {
                let (at, depth) = camera.project(*point, 200, 200).unwrap();
                assert!(at.x > 0.0 && at.x < 200.0 && at.y > 0.0 && at.y < 200.0, "{at} at step {step}");
                assert!(depth > 0.0);
            }
        }
    }

    #[test]
    fn up_is_up_and_the_performers_left_is_on_the_right() {
        let camera = Camera::framing(&[Vec3::splat(-0.1), Vec3::splat(0.1)]);
        let (middle, _) = camera.project(Vec3::ZERO, 100, 100).unwrap();
        let (above, _) = camera.project(Vec3::Y * 0.05, 100, 100).unwrap();
        let (left, _) = camera.project(Vec3::X * 0.05, 100, 100).unwrap();
        assert!(above.y < middle.y && left.x > middle.x);
        assert!(camera.project(Vec3::NAN, 100, 100).is_none());
    }
}
