//! The lids: they turn about the eye's left-right axis, so that they slide over the eyeball and meet when shut.

use crate::features::{Features, LID_RADIUS, Side, V_EYE};
use crate::numbers::smoothstep;
use crate::skin::{Place, Skin, SkinPoint};
use glam::Vec3;

/// How far a turn of the upper (lower) lid's edge reaches up (down) the skin, in the chart.
const UPPER_REACH: f32 = 13.0;
const LOWER_REACH: f32 = 11.0;

/// One column of the left eye's opening, seen along the turning axis.
#[derive(Debug, Clone, Copy)]
struct Column {
    u: f32,
    /// Where the edges meet, beside the eye's centre, in millimetres.
    x: f32,
    /// Elevation of the upper and of the lower edge, in radians above the horizontal through the eye.
    upper: f32,
    lower: f32,
    /// Distance from the axis at which both edges meet, in millimetres.
    radius: f32,
}

/// The lids of the left eye (the right eye's are its mirror image).
#[derive(Debug)]
pub struct Lids {
    eye: Vec3,
    columns: Vec<Column>,
}

/// How far the two edges go, in parts of the opening: the upper downwards, the lower upwards.
#[derive(Debug, Clone, Copy)]
pub struct LidMove {
    /// Upper edge, downwards.
    pub upper: f32,
    /// Lower edge, upwards.
    pub lower: f32,
}

impl LidMove {
    /// Shut: the edges meet a quarter up.
    pub const SHUT: Self = Self { upper: 0.78, lower: 0.22 };

    /// Part of the move.
    pub fn times(self, factor: f32) -> Self {
        Self { upper: self.upper * factor, lower: self.lower * factor }
    }
}

impl Lids {
    /// Measures the opening of the left eye.
    pub fn new(features: &Features, skin: &Skin) -> Self {
        let eye = features.eye;
        let columns = skin.eyes[0]
            .upper
            .iter()
            .zip(&skin.eyes[0].lower)
            .map(|(upper, lower)| {
                let [up, low] = [upper, lower].map(|vertex| skin.points[*vertex as usize].at - eye);
                let sphere = (LID_RADIUS * LID_RADIUS - up.x * up.x).max(0.0).sqrt();
                Column {
                    u: skin.points[*upper as usize].u,
                    x: 0.5 * (up.x + low.x),
                    upper: up.y.atan2(up.z),
                    lower: low.y.atan2(low.z),
                    radius: sphere.max(0.5 * (up.y.hypot(up.z) + low.y.hypot(low.z))),
                }
            })
            .collect();
        Self { eye, columns }
    }

    fn column(&self, u: f32) -> Option<Column> {
        let next = self.columns.iter().position(|column| column.u > u)?;
        let (a, b) = (self.columns.get(next.checked_sub(1)?)?, self.columns[next]);
        let t = (u - a.u) / (b.u - a.u);
        let mix = |x: f32, y: f32| x + (y - x) * t;
        Some(Column {
            u,
            x: mix(a.x, b.x),
            upper: mix(a.upper, b.upper),
            lower: mix(a.lower, b.lower),
            radius: mix(a.radius, b.radius),
        })
    }

    /// How much a point near the left eye belongs to a lid: 1 at its edge, 0 beyond its fold.
    pub fn hold(&self, point: &SkinPoint) -> f32 {
        if matches!(point.place, Place::BehindLid(_)) {
            return 1.0;
        }
        let (first, last) = (self.columns[0].u, self.columns[self.columns.len() - 1].u);
        let aside = (first - point.u).max(point.u - last).max(0.0);
        let along = point.v - V_EYE;
        let reach = if along > 0.0 { UPPER_REACH } else { LOWER_REACH };
        (1.0 - smoothstep(0.0, 5.0, aside)) * (1.0 - smoothstep(0.25 * reach, 0.9 * reach, along.abs()))
    }

    /// Displacement (mm) of a vertex of the left eye's lids.
    ///
    /// A vertex at distance ρ from the axis and elevation e goes to elevation e − f a (upper) or e + f b (lower), with
    /// f falling from 1 at the edge to 0 at the fold, and its ρ goes to the lids' sphere as far as it moves.
    pub fn delta(&self, point: &SkinPoint, go: LidMove) -> Vec3 {
        let above = point.v > V_EYE || (point.v == V_EYE && point.side == Side::Upper);
        let reach = if above { UPPER_REACH } else { LOWER_REACH };
        let along = (point.v - V_EYE).abs();
        if point.u <= 0.0 || along >= reach || matches!(point.place, Place::InsideLip(_)) {
            return Vec3::ZERO;
        }
        let Some(column) = self.column(point.u) else { return Vec3::ZERO };
        let opening = column.upper - column.lower;
        let fall = 1.0 - smoothstep(0.0, reach, along);
        let turn = if above { -go.upper } else { go.lower } * opening * fall;
        let out = point.at - self.eye;
        let (radius, elevation) = (out.y.hypot(out.z), out.y.atan2(out.z));
        // Edges that meet do so at one distance from the axis; rims keep theirs, inside the lid.
        let moved = (go.upper.abs().max(go.lower.abs()) / LidMove::SHUT.upper).min(1.0) * fall;
        let radius = match point.place {
            Place::BehindLid(_) => radius,
            _ if opening > 1e-4 => radius + (column.radius - radius) * moved,
            _ => radius,
        };
        let elevation = elevation + turn;
        let x = if opening > 1e-4 { out.x + (column.x - out.x) * moved } else { out.x };
        Vec3::new(x, radius * elevation.sin(), radius * elevation.cos()) - out
    }
}
