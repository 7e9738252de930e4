//! The features on the skull: brow, sockets, lids, cheekbones, nose, lips, chin, as heights over the bare surface.
//!
//! Everything here works on the performer's left half (u ≥ 0), in millimetres.

use crate::identity::Identity;
use crate::numbers::{gauss, interpolate, smoothstep, soft_max};
use crate::skull::Skull;
use glam::{Vec2, Vec3};

/// v of the line between the lips.
pub const V_MOUTH: f32 = -34.0;
/// v of the line through the corners of the eye.
pub const V_EYE: f32 = 34.0;
/// Height of each lip's red in the chart; the true height varies along the lip.
pub const LIP_CHART: f32 = 8.0;
/// Radius of the eyeball.
pub const EYE_RADIUS: f32 = 12.2;
/// Radius of the outside of the lids around the eye's centre.
pub const LID_RADIUS: f32 = 13.6;

/// Which side of a slit (mouth or eye) a vertex on it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Above the slit, or clear of it.
    Upper,
    /// Below the slit.
    Lower,
}

/// The face of one identity.
#[derive(Debug)]
pub struct Features {
    /// Proportions.
    pub identity: Identity,
    /// The bare surface.
    pub skull: Skull,
    /// Centre of the left eyeball.
    pub eye: Vec3,
    /// u of the inner and the outer corner of the eye.
    pub eye_corners: [f32; 2],
}

/// Centre (x, y), deviations (x, y), height.
#[rustfmt::skip]
const HILLS: [([f32; 2], [f32; 2], f32); 17] = [
    ([  0.0,  53.0], [10.0,  7.0],  1.8),
    ([ 58.0,  17.0], [12.0,  8.0],  1.2),
    ([ 62.0,  56.0], [ 8.0, 16.0], -1.3),
    ([ 30.0,  83.0], [16.0, 12.0],  1.2),
    ([ 32.5,  38.0], [13.5,  9.0], -9.0),
    ([ 17.0,  38.0], [ 6.0,  8.0], -5.5),
    ([ 30.0,  21.0], [13.0,  4.5], -1.2),
    ([ 52.0, -22.0], [11.0, 15.0], -2.4),
    ([ 27.0,   0.0], [ 9.0, 10.0],  1.5),
    ([ 31.0, -24.0], [ 5.0, 11.0], -0.9),
    ([ 35.0, -36.0], [ 7.0,  8.0],  0.9),
    ([  0.0, -53.0], [17.0,  4.0], -3.6),
    ([ 20.0, -52.0], [ 9.0,  5.0], -1.4),
    ([ 58.0, -44.0], [12.0, 10.0],  1.2),
    ([ 30.0,-112.0], [ 7.0, 22.0],  2.5),
    ([  0.0,-118.0], [ 9.0,  8.0],  3.5),
    ([  0.0,  38.0], [ 7.0,  6.0], -2.0),
];

/// y; height of the bridge over the skull, half width of the bridge.
#[rustfmt::skip]
const BRIDGE: [(f32, [f32; 2]); 12] = [
    (-15.0, [ 0.0, 9.0]),
    (-12.5, [ 1.2, 8.0]),
    (-10.0, [ 5.0, 7.5]),
    ( -7.0, [12.0, 7.5]),
    ( -4.0, [18.5, 8.0]),
    ( -1.0, [21.8, 8.2]),
    (  3.0, [21.5, 8.0]),
    ( 10.0, [17.6, 7.6]),
    ( 20.0, [11.8, 7.6]),
    ( 30.0, [ 6.6, 7.6]),
    ( 40.0, [ 3.6, 8.5]),
    ( 52.0, [ 0.0, 10.0]),
];

/// Along the lip (0 middle, 1 corner): height of the upper and of the lower red, rise of the line between the lips.
#[rustfmt::skip]
const LIPS: [(f32, [f32; 3]); 8] = [
    (0.00, [7.0, 9.4, -0.9]),
    (0.12, [7.6, 9.4, -0.7]),
    (0.24, [8.3, 9.2, -0.2]),
    (0.45, [7.1, 8.4,  0.5]),
    (0.65, [5.2, 6.7,  0.4]),
    (0.82, [3.2, 4.2, -0.2]),
    (0.94, [1.6, 1.9, -0.7]),
    (1.00, [0.9, 0.9, -0.9]),
];

/// From the line between the lips (0) over the red's border (1) outwards, in heights of the red: how far the upper
/// and the lower lip stand out.
#[rustfmt::skip]
const LIP_PROFILE: [(f32, [f32; 2]); 10] = [
    (0.00, [1.8, 1.8]),
    (0.15, [4.4, 4.0]),
    (0.35, [6.1, 6.0]),
    (0.60, [6.5, 6.4]),
    (0.85, [5.9, 4.6]),
    (1.00, [5.4, 3.2]),
    (1.30, [3.9, 1.3]),
    (1.80, [2.1, 0.1]),
    (2.40, [0.7, 0.0]),
    (3.00, [0.0, 0.0]),
];

/// Height of a unit ball over the plane at distance `r` from its middle; past 0.86 it falls on, ever steeper.
fn dome(r: f32) -> f32 {
    const EDGE: f32 = 0.86;
    let ball = |r: f32| (1.0 - r * r).sqrt();
    if r <= EDGE { ball(r) } else { ball(EDGE) - (r - EDGE) * EDGE / ball(EDGE) - 0.7 * (r - EDGE).powi(2) }
}

impl Features {
    /// The face of `identity`.
    pub fn new(identity: Identity) -> Self {
        let skull = Skull::new(&identity);
        let eye = Vec3::new(identity.eye_x, 35.0, 84.2);
        let eye_corners = [identity.eye_x - 14.6, identity.eye_x + 15.2];
        Self { identity, skull, eye, eye_corners }
    }

    /// Half the width of the mouth in the chart.
    pub fn mouth(&self) -> f32 {
        self.identity.mouth_half_width
    }

    /// Heights of the upper and lower red and rise of the mouth's line at u; beyond the corner the rows fan out again.
    pub fn lip_heights(&self, u: f32) -> [f32; 3] {
        let s = u / self.mouth();
        if s <= 1.0 {
            let [upper, lower, line] = interpolate(&LIPS, s);
            let full = 1.0 + (self.identity.lip_fullness - 1.0) * (1.0 - s);
            [upper * full, lower * full, line]
        } else {
            let out = smoothstep(1.0, 1.7, s);
            let height = 0.9 + (LIP_CHART - 0.9) * out;
            [height, height, -0.9 * (1.0 - out)]
        }
    }

    /// How far the lid's edge stands from the line of the corners at u, upwards and downwards.
    pub fn lid_heights(&self, u: f32) -> [f32; 2] {
        let [inner, outer] = self.eye_corners;
        let s = (u - inner) / (outer - inner);
        if s <= 0.0 || s >= 1.0 {
            return [0.0, 0.0];
        }
        // A sine arch whose top is pushed inwards for the upper lid and outwards for the lower.
        let arch = |skew: f32, power: f32| (std::f32::consts::PI * s.powf(skew)).sin().max(0.0).powf(power);
        let open = self.identity.eye_opening;
        [7.1 * open * arch(0.86, 0.82), 4.5 * open * arch(1.12, 0.85)]
    }

    /// Chart coordinates bent so that the rows follow lids and lips: the v to use at (u, v).
    fn bend(&self, u: f32, v: f32, side: Side) -> f32 {
        let mut bent = v;
        let from_eye = v - V_EYE;
        let [up, down] = self.lid_heights(u);
        let upper = from_eye > 0.0 || (from_eye == 0.0 && side == Side::Upper);
        bent += if upper {
            up * (1.0 - smoothstep(0.0, 21.0, from_eye))
        } else {
            -down * (1.0 - smoothstep(0.0, 20.0, -from_eye))
        };
        let [inner, outer] = self.eye_corners;
        let tilt = smoothstep(inner - 4.0, outer + 2.0, u) * (1.0 - smoothstep(outer + 4.0, 75.0, u)) - 0.45;
        let near_eye = 1.0 - smoothstep(0.0, 20.0, from_eye.abs());
        bent += self.identity.eye_tilt * tilt * near_eye * smoothstep(4.0, inner, u);

        let [_, _, line] = self.lip_heights(u);
        let above_mouth = v - V_MOUTH;
        bent + self.above_mouth(u, v) - above_mouth + line * (1.0 - smoothstep(0.0, 13.0, above_mouth.abs()))
    }

    /// How far chart coordinates (u, v) lie above (below, where negative) the line between the lips, in millimetres.
    pub fn above_mouth(&self, u: f32, v: f32) -> f32 {
        let along = v - V_MOUTH;
        let [upper, lower, _] = self.lip_heights(u);
        let (height, reach) = if along > 0.0 { (upper, 20.0) } else { (lower, 23.0) };
        let from = along.abs();
        let distance = if from <= LIP_CHART {
            from * height / LIP_CHART
        } else if from < reach {
            height + (from - LIP_CHART) * (reach - height) / (reach - LIP_CHART)
        } else {
            from
        };
        distance.copysign(along)
    }

    /// Where the skin's vertex at chart coordinates (u ≥ 0, v) stands, in millimetres.
    pub fn skin(&self, u: f32, v: f32, side: Side) -> Vec3 {
        let surface = self.skull.at(u, self.bend(u, v, side));
        let mut at = surface.at;
        if at.z < 0.0 || u > 105.0 {
            return at;
        }
        let flat = Vec2::new(at.x, at.y);
        at += surface.outwards * (self.hills(flat) * smoothstep(105.0, 66.0, u));
        at.z = self.over_eye(at);
        at = self.nose(at);
        at.z += self.lips(u, v, side, flat);
        at
    }

    fn hills(&self, flat: Vec2) -> f32 {
        let fixed: f32 = HILLS.iter().map(|(c, s, height)| height * gauss(flat, Vec2::from(*c), Vec2::from(*s))).sum();
        let brow = self.identity.brow_ridge
            * (2.8 * gauss(flat, Vec2::new(20.0, 54.5), Vec2::new(13.0, 5.0))
                + 3.2 * gauss(flat, Vec2::new(42.0, 53.0), Vec2::new(10.0, 6.0)));
        let cheek = self.identity.cheekbone * 3.6 * gauss(flat, Vec2::new(45.0, 12.0), Vec2::new(14.0, 11.0));
        let chin = 4.6 * gauss(flat, Vec2::new(0.0, -69.0), Vec2::new(13.0, 9.0));
        fixed + brow + cheek + chin
    }

    /// Skin near the eye lies on the lids' sphere where that stands before the socket.
    fn over_eye(&self, at: Vec3) -> f32 {
        let beside = (at - self.eye).truncate().length() / LID_RADIUS;
        soft_max(at.z, self.eye.z + LID_RADIUS * dome(beside), 4.0)
    }

    fn nose(&self, mut at: Vec3) -> Vec3 {
        if at.x > 32.0 || !(-18.0..55.0).contains(&at.y) {
            return at;
        }
        let [height, width] = interpolate(&BRIDGE, at.y);
        let x = at.x / (width * (0.4 + 0.6 * self.identity.nose_width));
        let hump = self.identity.nose_hump * gauss(Vec2::new(0.0, at.y), Vec2::new(0.0, 20.0), Vec2::new(1.0, 8.0));
        let bridge = (height * self.identity.nose_projection + hump) * (-(x * x) * 0.62).exp();
        // Flanks rise from the cheek to the bridge.
        let flank = 3.4 * gauss(Vec2::new(at.x, at.y), Vec2::new(11.0, 4.0), Vec2::new(6.5, 11.0));
        let base = at.z;
        let ball =
            |centre: Vec3, radius: Vec3| centre.z + radius.z * dome(((at - centre) / radius).truncate().length());
        let wide = self.identity.nose_width;
        let tip = ball(Vec3::new(0.0, -0.6, 10.5 * self.identity.nose_projection), Vec3::new(9.6 * wide, 8.8, 12.8));
        let wing = ball(Vec3::new(10.8 * wide, -4.6, -1.0), Vec3::new(7.8 * wide, 8.0, 12.0));
        let mut rise = bridge + flank;
        rise = soft_max(rise, tip, 6.0);
        rise = soft_max(rise, wing, 3.5);
        // Nostrils: hollows under the wings.
        let nostril = gauss(Vec2::new(at.x, at.y), Vec2::new(6.2 * wide, -9.8), Vec2::new(2.6, 1.8));
        rise -= 4.5 * nostril;
        at.z = base + rise;
        // The underside leans forward a little: the tip hangs over the lip.
        at.y -= 0.10 * (rise - 4.0).max(0.0) * smoothstep(4.0, -4.0, at.y);
        at
    }

    fn lips(&self, u: f32, v: f32, side: Side, flat: Vec2) -> f32 {
        let distance = (v - V_MOUTH).abs() / LIP_CHART;
        if distance > 3.0 {
            return 0.0;
        }
        let above = v > V_MOUTH || (v == V_MOUTH && side == Side::Upper);
        let s = u / self.mouth();
        let profile = interpolate(&LIP_PROFILE, distance)[usize::from(!above)];
        // At the corner all rows meet, and the profile's height must not depend on the row.
        let profile = profile + (3.0 - profile) * smoothstep(0.8, 1.0, s) * (1.0 - smoothstep(1.0, 3.0, distance));
        let taper = (1.0 - (s / 1.14).powi(2)).max(0.0).powf(1.25);
        let corner = -1.9 * gauss(flat, Vec2::new(self.mouth() + 0.5, V_MOUTH - 0.9), Vec2::new(4.5, 4.0));
        // The philtrum: a groove with two ridges above the upper lip's middle.
        let philtrum = if above {
            let band = smoothstep(0.7, 1.3, distance) * (1.0 - smoothstep(2.1, 2.9, distance));
            band * (-1.1 * (-(u / 2.6).powi(2)).exp() + 0.7 * (-((u - 5.2) / 2.4).powi(2)).exp())
        } else {
            0.0
        };
        let full = 1.0 + 0.5 * (self.identity.lip_fullness - 1.0);
        profile * taper * full + corner + philtrum
    }
}
