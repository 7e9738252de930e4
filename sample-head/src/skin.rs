//! The skin's mesh: a grid over the chart with slits at the eyes and the mouth, and rims folded in behind them.
//!
//! The grid's lines follow lids and lips, since the chart is bent around the slits. The right half is the exact mirror
//! image of the left.

use crate::features::{EYE_RADIUS, Features, LIP_CHART, Side, V_EYE, V_MOUTH};
use crate::skull::{U_BACK, U_SIDE, V_HIGH, V_LOW};
use glam::Vec3;

/// How many rings of rim are folded in behind the lips.
pub const LIP_RINGS: usize = 5;
/// How many rings of rim are folded in behind the lids.
pub const LID_RINGS: usize = 3;

/// What a vertex of the skin is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// On the outside.
    Outside,
    /// Inside the lips, on the given ring from the edge (1…).
    InsideLip(usize),
    /// Behind the lids, on the given ring from the edge (1…).
    BehindLid(usize),
}

/// One vertex of the skin.
#[derive(Debug, Clone, Copy)]
pub struct SkinPoint {
    /// Chart coordinate around the head, signed: positive on the performer's left.
    pub u: f32,
    /// Chart coordinate up the head.
    pub v: f32,
    /// Side of the slit, for vertices on one.
    pub side: Side,
    /// Outside, or on which rim.
    pub place: Place,
    /// The vertex of the slit's edge that a rim's vertex hangs on; the vertex itself on the outside.
    pub edge: u32,
    /// Neutral position in millimetres.
    pub at: Vec3,
    /// Texture coordinates.
    pub uv: [f32; 2],
}

/// The two edges of a slit, each from the corner of smaller u to the other, corners included.
#[derive(Debug, Clone, Default)]
pub struct Slit {
    /// Vertices of the upper edge.
    pub upper: Vec<u32>,
    /// Vertices of the lower edge; its ends are those of the upper.
    pub lower: Vec<u32>,
}

/// The skin.
#[derive(Debug)]
pub struct Skin {
    /// Vertices.
    pub points: Vec<SkinPoint>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex its mirror image.
    pub mirror: Vec<u32>,
    /// The mouth.
    pub mouth: Slit,
    /// The eyes: the performer's left, then right.
    pub eyes: [Slit; 2],
}

/// From `low` to `high` in `count` steps; the last is left to the next run.
fn run(out: &mut Vec<f32>, low: f32, high: f32, count: f32, density: f32) {
    let steps = (count * density).round().max(1.0) as usize;
    out.extend((0..steps).map(|i| low + (high - low) * i as f32 / steps as f32));
}

fn columns(features: &Features, density: f32) -> Vec<f32> {
    let [inner, outer] = features.eye_corners;
    let mut out = Vec::new();
    run(&mut out, 0.0, inner, 13.0, density);
    run(&mut out, inner, features.mouth(), 6.0, density);
    run(&mut out, features.mouth(), outer, 15.0, density);
    run(&mut out, outer, 60.0, 7.0, density);
    run(&mut out, 60.0, U_SIDE, 12.0, density);
    run(&mut out, U_SIDE, U_BACK, 13.0, density);
    out.push(U_BACK);
    out
}

fn rows(density: f32) -> Vec<f32> {
    let lip = LIP_CHART;
    let mut out = Vec::new();
    run(&mut out, V_LOW, -104.0, 7.0, density);
    run(&mut out, -104.0, -80.0, 8.0, density);
    run(&mut out, -80.0, -57.0, 8.0, density);
    run(&mut out, -57.0, V_MOUTH - lip, 8.0, density);
    run(&mut out, V_MOUTH - lip, V_MOUTH - 2.4, 4.0, density);
    run(&mut out, V_MOUTH - 2.4, V_MOUTH, 4.0, density);
    run(&mut out, V_MOUTH, V_MOUTH + 2.4, 4.0, density);
    run(&mut out, V_MOUTH + 2.4, V_MOUTH + lip, 4.0, density);
    run(&mut out, V_MOUTH + lip, -14.0, 7.0, density);
    run(&mut out, -14.0, 2.0, 15.0, density);
    run(&mut out, 2.0, 21.0, 10.0, density);
    run(&mut out, 21.0, V_EYE - 4.0, 6.0, density);
    run(&mut out, V_EYE - 4.0, V_EYE, 5.0, density);
    run(&mut out, V_EYE, V_EYE + 4.0, 5.0, density);
    run(&mut out, V_EYE + 4.0, 48.0, 8.0, density);
    run(&mut out, 48.0, 66.0, 8.0, density);
    run(&mut out, 66.0, 96.0, 9.0, density);
    run(&mut out, 96.0, V_HIGH, 11.0, density);
    out.push(V_HIGH);
    out
}

impl Skin {
    /// Lays out the skin; `density` 1 gives about 15,000 vertices.
    pub fn new(features: &Features, density: f32) -> Self {
        Builder::new(features, density).build()
    }
}

struct Builder<'a> {
    features: &'a Features,
    columns: Vec<f32>,
    rows: Vec<f32>,
    points: Vec<SkinPoint>,
    mirror: Vec<u32>,
    /// Vertex at (row, column from the right back to the left back), as seen from above and from below.
    above: Vec<u32>,
    below: Vec<u32>,
}

impl<'a> Builder<'a> {
    fn new(features: &'a Features, density: f32) -> Self {
        let (columns, rows) = (columns(features, density), rows(density));
        Self { features, columns, rows, points: Vec::new(), mirror: Vec::new(), above: Vec::new(), below: Vec::new() }
    }

    fn width(&self) -> usize {
        self.columns.len() * 2 - 1
    }

    /// Signed u of a column counted from the right back.
    fn u(&self, column: usize) -> f32 {
        let middle = self.columns.len() - 1;
        if column >= middle { self.columns[column - middle] } else { -self.columns[middle - column] }
    }

    fn is_slit(&self, u: f32, v: f32) -> bool {
        let [inner, outer] = self.features.eye_corners;
        (v == V_MOUTH && u.abs() < self.features.mouth()) || (v == V_EYE && u.abs() > inner && u.abs() < outer)
    }

    fn add(&mut self, u: f32, v: f32, side: Side) -> u32 {
        let mut at = self.features.skin(u.abs(), v, side);
        if u == 0.0 {
            at.x = 0.0;
        }
        if u < 0.0 {
            at.x = -at.x;
        }
        // A hair's breadth keeps closed lips from standing in one another.
        if v == V_MOUTH && self.is_slit(u, v) {
            at.y += if side == Side::Upper { 0.02 } else { -0.02 };
        }
        let uv = [0.5 + 0.5 * u / U_BACK, (V_HIGH - v) / (V_HIGH - V_LOW)];
        let edge = self.points.len() as u32;
        self.points.push(SkinPoint { u, v, side, place: Place::Outside, edge, at, uv });
        edge
    }

    fn build(mut self) -> Skin {
        let (width, rows) = (self.width(), self.rows.clone());
        for v in &rows {
            for column in 0..width {
                let u = self.u(column);
                let lower = self.add(u, *v, Side::Lower);
                let upper = if self.is_slit(u, *v) { self.add(u, *v, Side::Upper) } else { lower };
                self.below.push(lower);
                self.above.push(upper);
            }
        }
        self.mirror_grid();
        let mut triangles = self.grid_triangles();
        let mouth = self.slit(V_MOUTH, -self.features.mouth(), self.features.mouth());
        let [inner, outer] = self.features.eye_corners;
        let left = self.slit(V_EYE, inner, outer);
        let right = self.slit(V_EYE, -outer, -inner);
        self.fold_in(&mouth, None, LIP_RINGS, &mut triangles);
        self.fold_in(&left, Some(1.0), LID_RINGS, &mut triangles);
        self.fold_in(&right, Some(-1.0), LID_RINGS, &mut triangles);
        self.mirror_rims(&mouth, &left, &right);
        Skin { points: self.points, triangles, mirror: self.mirror, mouth, eyes: [left, right] }
    }

    fn mirror_grid(&mut self) {
        let width = self.width();
        self.mirror = vec![0; self.points.len()];
        for table in [&self.below, &self.above] {
            for (index, vertex) in table.iter().enumerate() {
                let opposite = index - index % width + (width - 1 - index % width);
                self.mirror[*vertex as usize] = table[opposite];
            }
        }
    }

    fn grid_triangles(&self) -> Vec<[u32; 3]> {
        let width = self.width();
        let mut triangles = Vec::new();
        for row in 0..self.rows.len() - 1 {
            for column in 0..width - 1 {
                let low = row * width + column;
                let (a, b) = (self.above[low], self.above[low + 1]);
                let (c, d) = (self.below[low + width], self.below[low + width + 1]);
                if row == self.rows.len() - 2 {
                    triangles.push([a, b, d]);
                } else if column < width / 2 {
                    triangles.extend([[a, b, d], [a, d, c]]);
                } else {
                    triangles.extend([[a, b, c], [b, d, c]]);
                }
            }
        }
        triangles
    }

    fn slit(&self, v: f32, from: f32, to: f32) -> Slit {
        let width = self.width();
        let row = self.rows.iter().position(|own| (own - v).abs() < 1e-4).unwrap_or_default();
        let columns = (0..width).filter(|column| (from..=to).contains(&self.u(*column)));
        let pick = |table: &[u32]| columns.clone().map(|column| table[row * width + column]).collect();
        Slit { upper: pick(&self.above), lower: pick(&self.below) }
    }

    /// Adds rings behind the edge of a slit: behind the lips (`eye` is `None`), or behind the lids of the eye whose
    /// side has that sign.
    fn fold_in(&mut self, slit: &Slit, eye: Option<f32>, rings: usize, triangles: &mut Vec<[u32; 3]>) {
        let count = slit.upper.len();
        let (mut upper, mut lower) = (slit.upper.clone(), slit.lower.clone());
        for ring in 1..=rings {
            let fold = |builder: &mut Self, edge: u32| {
                let mut point = builder.points[edge as usize];
                point.at = match eye {
                    None => builder.behind_lip(&point, ring),
                    Some(sign) => builder.behind_lid(&point, sign, ring),
                };
                point.place = if eye.is_none() { Place::InsideLip(ring) } else { Place::BehindLid(ring) };
                let sign = if point.side == Side::Upper { -1.0 } else { 1.0 };
                point.uv[1] += 0.0004 * ring as f32 * sign;
                builder.points.push(point);
                builder.points.len() as u32 - 1
            };
            let next_upper: Vec<u32> = slit.upper.iter().map(|edge| fold(self, *edge)).collect();
            let mut next_lower = next_upper.clone();
            for (place, edge) in slit.lower.iter().enumerate().take(count - 1).skip(1) {
                next_lower[place] = fold(self, *edge);
            }
            for i in 0..count - 1 {
                let (a, b, c, d) = (upper[i], upper[i + 1], next_upper[i], next_upper[i + 1]);
                triangles.extend([[a, c, b], [b, c, d]]);
                let (a, b, c, d) = (lower[i], lower[i + 1], next_lower[i], next_lower[i + 1]);
                triangles.extend([[a, b, c], [b, d, c]]);
            }
            (upper, lower) = (next_upper, next_lower);
        }
    }

    /// Inside of the lips: back to before the teeth, then up (down) towards the gums.
    fn behind_lip(&self, edge: &SkinPoint, ring: usize) -> Vec3 {
        const BACK: [f32; LIP_RINGS] = [0.9, 1.9, 2.9, 3.6, 4.0];
        const AWAY: [f32; LIP_RINGS] = [0.25, 1.1, 3.0, 6.0, 10.0];
        let s = (edge.u / self.features.mouth()).abs();
        let open = (1.0 - s * s).max(0.0).sqrt();
        let sign = if edge.side == Side::Upper { 1.0 } else { -1.0 };
        // The corners go further back and in, along the row of teeth.
        let back = BACK[ring - 1] * (1.0 + 0.9 * s * s);
        let x = edge.at.x * (1.0 - 0.012 * ring as f32 * s);
        Vec3::new(x, edge.at.y + sign * AWAY[ring - 1] * open, edge.at.z - back)
    }

    /// Behind the lids: the edge's own thickness down to the eyeball, then hidden inside it.
    fn behind_lid(&self, edge: &SkinPoint, sign: f32, ring: usize) -> Vec3 {
        const RADIUS: [f32; LID_RINGS] = [0.35, -0.5, -2.0];
        let mut centre = self.features.eye;
        centre.x *= sign;
        let out = edge.at - centre;
        let wanted = EYE_RADIUS + RADIUS[ring - 1];
        let mut at = centre + out.normalize_or(Vec3::Z) * out.length().min(wanted);
        // Beyond the eyeball's edge, at the corners, the rim goes back instead, so that no gap opens.
        let aside = ((out.x.abs() - 10.0) / 4.0).clamp(0.0, 1.0);
        at.z -= aside * ring as f32 * 0.8;
        at
    }

    fn mirror_rims(&mut self, mouth: &Slit, left: &Slit, right: &Slit) {
        let start = self.mirror.len();
        self.mirror.resize(self.points.len(), 0);
        let ring_size = |slit: &Slit| slit.upper.len() * 2 - 2;
        // Within a ring the upper edge comes first, then the lower without its ends; mirrored, each runs backwards.
        let opposite = |slit: &Slit, place: usize| {
            let upper = slit.upper.len();
            if place < upper { upper - 1 - place } else { upper + (ring_size(slit) - 1 - place) }
        };
        let mut base = start;
        for _ in 0..LIP_RINGS {
            for place in 0..ring_size(mouth) {
                self.mirror[base + place] = (base + opposite(mouth, place)) as u32;
            }
            base += ring_size(mouth);
        }
        let span = LID_RINGS * ring_size(left);
        for ring in 0..LID_RINGS {
            for place in 0..ring_size(left) {
                let here = base + ring * ring_size(left) + place;
                let there = base + span + ring * ring_size(right) + opposite(left, place);
                self.mirror[here] = there as u32;
                self.mirror[there] = here as u32;
            }
        }
    }
}
