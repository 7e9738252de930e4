//! The jaw: how it moves, and how much of that each vertex of the skin follows.

use crate::features::{Features, Side};
use crate::numbers::smoothstep;
use crate::skin::SkinPoint;
use glam::{Quat, Vec3};

/// Where the jaw's joint stands, between the two joints before the ears, in millimetres.
pub const PIVOT: Vec3 = Vec3::new(0.0, 8.0, 12.0);

/// A rigid motion: turn about [`PIVOT`], then shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    /// The turn.
    pub turn: Quat,
    /// The shift in millimetres.
    pub shift: Vec3,
}

impl Rigid {
    /// Displacement of a point.
    pub fn delta(&self, at: Vec3) -> Vec3 {
        PIVOT + self.turn * (at - PIVOT) + self.shift - at
    }
}

/// The jaw's motion at weight 1 of a channel, where that moves the jaw.
pub fn motion(channel: &str) -> Option<Rigid> {
    let (turn, shift) = match channel {
        "jawOpen" => (Quat::from_rotation_x(17f32.to_radians()), Vec3::new(0.0, -1.5, 3.0)),
        "jawForward" => (Quat::IDENTITY, Vec3::new(0.0, -0.8, 6.5)),
        "jawLeft" => (Quat::from_rotation_y(3.2f32.to_radians()), Vec3::new(2.2, 0.0, 0.0)),
        _ => return None,
    };
    Some(Rigid { turn, shift })
}

/// How much the corner of the mouth follows the jaw.
const CORNER: f32 = 0.46;

/// Where a vertex stands from the corner of the mouth: outwards and up, in millimetres. On the slit itself, up is a
/// trifle to the vertex' own side.
pub fn from_corner(features: &Features, point: &SkinPoint) -> (f32, f32) {
    let up = features.above_mouth(point.u.abs(), point.v);
    let trifle = if point.side == Side::Lower { -1e-6 } else { 1e-6 };
    (point.u.abs() - features.mouth(), if up.abs() < 1e-6 { trifle } else { up })
}

/// How much a vertex of the skin follows the jaw, 0 to 1.
///
/// Around the corner of the mouth the share turns from the upper lip's 0 to the lower lip's 1 with the angle, and
/// fades to the corner's own share towards it; the neck and what lies behind the jaw do not follow.
pub fn share(features: &Features, point: &SkinPoint) -> f32 {
    let (along, up) = from_corner(features, point);
    let lower = smoothstep(0.72, -0.72, up.atan2(along) / std::f32::consts::PI);
    let near = (along.hypot(up) / 23.0).min(1.0);
    let around_corner = CORNER + (lower - CORNER) * (1.0 - (1.0 - near).powf(1.8));
    let neck = smoothstep(-146.0, -80.0, point.v);
    // The cheek above the mouth's height lets go before the ear.
    let back = smoothstep(-4.0, 26.0, point.at.z - 0.35 * (point.at.y + 34.0).max(0.0));
    around_corner * neck * back
}
