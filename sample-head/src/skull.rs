//! The head without its features: a smooth surface over the chart coordinates (u, v), in millimetres.
//!
//! Each v names one closed curve around the head, which passes the front, side and back points of the table. u runs
//! along it: over the face u is simply x, the side of the head lies at ±[`U_SIDE`], the back at ±[`U_BACK`].

use crate::identity::Identity;
use crate::numbers::{interpolate, smoothstep};
use glam::Vec3;

/// u of the side of the head.
pub const U_SIDE: f32 = 110.0;
/// u of the back of the head.
pub const U_BACK: f32 = 220.0;
/// Up to here u equals x over the face.
const U_FACE: f32 = 50.0;
/// v of the lowest curve, round the base of the neck.
pub const V_LOW: f32 = -150.0;
/// v of the crown, where the curve shrinks to a point.
pub const V_HIGH: f32 = 160.0;

/// v; front y and z; half width, side y and z; back y and z; roundness of the front.
type Curve = [f32; 8];

#[rustfmt::skip]
const CURVES: [(f32, Curve); 24] = [
    (-150.0, [-150.0,  44.0, 60.0, -156.0, -20.0, -150.0, -74.0, 1.0]),
    (-130.0, [-122.0,  43.0, 55.5, -124.0, -17.0, -122.0, -66.0, 1.0]),
    (-112.0, [-101.0,  49.0, 53.0,  -88.0, -12.0,  -95.0, -62.0, 1.0]),
    (-100.0, [ -92.0,  63.0, 53.5,  -72.0,  -5.0,  -80.0, -61.0, 1.0]),
    ( -92.0, [ -87.5,  80.0, 54.5,  -63.0,   1.0,  -73.0, -61.0, 1.04]),
    ( -84.0, [ -83.0,  95.5, 55.5,  -57.0,   4.0,  -68.0, -61.5, 1.08]),
    ( -76.0, [ -76.0, 103.0, 57.0,  -52.5,   6.0,  -64.0, -62.0, 1.06]),
    ( -66.0, [ -66.0, 105.5, 59.5,  -46.5,   8.0,  -58.0, -62.5, 1.0]),
    ( -55.0, [ -55.0, 106.5, 62.5,  -40.5,   9.0,  -52.0, -63.0, 0.92]),
    ( -40.0, [ -40.0, 109.0, 66.0,  -31.0,  10.0,  -43.0, -64.0, 0.82]),
    ( -25.0, [ -25.0, 110.0, 69.0,  -20.0,  10.0,  -33.0, -66.0, 0.74]),
    ( -10.0, [ -10.0, 108.5, 71.5,   -7.0,  10.0,  -22.0, -69.0, 0.68]),
    (   5.0, [   5.0, 106.0, 72.5,    6.0,   9.0,  -10.0, -74.0, 0.64]),
    (  20.0, [  20.0, 104.0, 73.5,   19.0,   8.0,    3.0, -80.0, 0.62]),
    (  35.0, [  35.0, 102.5, 74.5,   32.0,   6.0,   17.0, -86.0, 0.64]),
    (  50.0, [  50.0, 102.5, 75.5,   45.0,   4.0,   32.0, -91.5, 0.68]),
    (  65.0, [  65.0, 102.0, 76.5,   58.0,   2.0,   47.0, -95.5, 0.72]),
    (  80.0, [  80.0,  99.5, 77.0,   71.0,   0.0,   63.0, -97.5, 0.77]),
    (  95.0, [  95.0,  93.5, 76.0,   86.0,  -1.0,   82.0, -96.5, 0.82]),
    ( 110.0, [ 109.0,  83.0, 72.0,  101.0,  -2.5,  101.0, -91.0, 0.88]),
    ( 125.0, [ 122.0,  68.5, 64.5,  117.0,  -4.0,  118.5, -80.0, 0.93]),
    ( 140.0, [ 134.0,  48.0, 50.5,  132.0,  -5.5,  133.0, -60.0, 0.97]),
    ( 151.0, [ 142.0,  26.0, 31.0,  141.5,  -7.0,  142.0, -38.0, 1.0]),
    ( 160.0, [ 145.5,  -8.0,  0.0,  145.5,  -8.0,  145.5,  -8.0, 1.0]),
];

/// The featureless head of one identity.
#[derive(Debug)]
pub struct Skull {
    curves: Vec<(f32, Curve)>,
}

/// A point of the surface, with the direction in which features stand out.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// Where it is, in millimetres.
    pub at: Vec3,
    /// Horizontal unit vector outwards.
    pub outwards: Vec3,
}

impl Skull {
    /// The table, widened to the identity.
    pub fn new(identity: &Identity) -> Self {
        let curves = CURVES
            .iter()
            .map(|(v, curve)| {
                let mut curve = *curve;
                let low = smoothstep(-10.0, -60.0, *v) * smoothstep(-130.0, -95.0, *v);
                curve[2] *= identity.face_width * (1.0 - low) + identity.jaw_width * low;
                curve[1] += (identity.chin - 1.0) * 2.0 * smoothstep(-45.0, -70.0, *v) * smoothstep(-105.0, -90.0, *v);
                (*v, curve)
            })
            .collect();
        Self { curves }
    }

    /// The point at chart coordinates u (0 to [`U_BACK`], the performer's left half) and v.
    ///
    /// Front quarter: x = w sin ψ, z = s + (f − s) cosᵖ ψ (f, s the front's and side's z, w the half width), with
    /// ψ = asin(u / w) over the face, then even steps
    /// to the side; the back quarter is an ellipse. y goes from the front's to the side's (the back's) by 1 − cos ψ.
    pub fn at(&self, u: f32, v: f32) -> Surface {
        let [y_front, z_front, width, y_side, z_side, y_back, z_back, power] = interpolate(&self.curves, v);
        let quarter = std::f32::consts::FRAC_PI_2;
        let even = quarter * u / U_SIDE;
        // Where the head is narrower than the face's stretch, u equals x up to near the side.
        let face = U_FACE.min(0.95 * width).max(1e-3);
        let edge = (face / width.max(1e-3)).min(1.0).asin();
        let facial = if u <= face {
            (u / width.max(1e-3)).min(1.0).asin()
        } else {
            edge + (quarter - edge) * (u - face) / (U_SIDE - face)
        };
        // Above the forehead the curves grow small, and even steps serve better.
        let share = smoothstep(92.0, 128.0, v);
        let psi = if u >= U_SIDE { even } else { facial + (even - facial) * share };
        let (sin, cos) = psi.sin_cos();
        if psi <= quarter {
            let cos = cos.max(0.0);
            let z = z_side + (z_front - z_side) * cos.powf(power);
            let y = y_front + (y_side - y_front) * (1.0 - cos);
            let outwards = Vec3::new(sin, 0.0, cos + 0.25 * (1.0 - sin)).normalize_or(Vec3::Z);
            Surface { at: Vec3::new(width * sin, y, z), outwards }
        } else {
            let back = (-cos).clamp(0.0, 1.0);
            let z = z_side + (z_back - z_side) * back.powf(0.95);
            let y = y_side + (y_back - y_side) * back;
            let x = if u >= U_BACK { 0.0 } else { width * sin.max(0.0) };
            Surface { at: Vec3::new(x, y, z), outwards: Vec3::new(sin, 0.0, cos).normalize_or(-Vec3::Z) }
        }
    }

    /// Depth z of the front surface at (x, y), for skin that slides over the head; x beyond the side is held there.
    pub fn depth(&self, x: f32, y: f32) -> f32 {
        let [_, z_front, width, _, z_side, _, _, power] = interpolate(&self.curves, y);
        let sin = (x.abs() / width.max(1.0)).min(0.985);
        z_side + (z_front - z_side) * (1.0 - sin * sin).sqrt().powf(power)
    }
}
