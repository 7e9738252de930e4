//! Painted on the skin: lips' red, brows, lashes, nostrils. Thin parts of their own colour, a fraction of a millimetre above
//! the skin, that move exactly with it.

use crate::features::{Features, LIP_CHART, Side, V_EYE, V_MOUTH};
use crate::piece::{Follow, Piece};
use crate::skin::{Place, Skin, SkinPoint};
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

/// The skin's triangles whose three vertices all fulfil `wanted`, lifted by `height` (mm) along the normals.
fn copy(
    skin: &Skin,
    normals: &[Vec3],
    (name, colour, height): (&'static str, [f32; 3], f32),
    wanted: impl Fn(&SkinPoint) -> bool,
) -> Piece {
    let mut place: BTreeMap<u32, u32> = BTreeMap::new();
    let mut triangles = Vec::new();
    let mut vertices = Vec::new();
    for corners in &skin.triangles {
        if corners.iter().all(|vertex| wanted(&skin.points[*vertex as usize])) {
            triangles.push(corners.map(|vertex| {
                *place.entry(vertex).or_insert_with(|| {
                    vertices.push(vertex);
                    vertices.len() as u32 - 1
                })
            }));
        }
    }
    let points = vertices.iter().map(|v| skin.points[*v as usize].at + normals[*v as usize] * height).collect();
    let uvs = vertices.iter().map(|v| skin.points[*v as usize].uv).collect();
    let follow = Follow::Skin(vertices.iter().map(|v| [(*v, 1.0), (*v, 0.0), (*v, 0.0)]).collect());
    Piece { name, points, triangles, uvs, colour, follow }
}

/// The lips' red, outside and in.
pub fn lips(skin: &Skin, normals: &[Vec3], features: &Features) -> Piece {
    let mouth = features.mouth();
    copy(skin, normals, ("lips", features.identity.colours.lips, 0.07), |point| match point.place {
        Place::InsideLip(_) => true,
        Place::BehindLid(_) => false,
        Place::Outside => (point.v - V_MOUTH).abs() <= LIP_CHART + 0.01 && point.u.abs() <= mouth + 0.01,
    })
}

/// A dark line along the upper lids.
pub fn lashes(skin: &Skin, normals: &[Vec3], features: &Features) -> Piece {
    let [inner, outer] = features.eye_corners;
    copy(skin, normals, ("lashes", [0.035, 0.022, 0.018], 0.09), |point| {
        let along = (point.u.abs() - inner) / (outer - inner);
        (0.10..=1.01).contains(&along)
            && (point.v > V_EYE || point.side == Side::Upper)
            && match point.place {
                Place::BehindLid(ring) => ring == 1,
                Place::InsideLip(_) => false,
                Place::Outside => point.v - V_EYE < 0.9,
            }
    })
}

/// Finds the skin's front under points of the face plane.
struct Front<'a> {
    skin: &'a Skin,
    triangles: Vec<[u32; 3]>,
}

impl<'a> Front<'a> {
    fn new(skin: &'a Skin, low: Vec2, high: Vec2) -> Self {
        let flat = |vertex: u32| skin.points[vertex as usize].at.truncate();
        let triangles = skin
            .triangles
            .iter()
            .filter(|corners| {
                let [a, b, c] = corners.map(flat);
                let outside = corners.iter().all(|v| skin.points[*v as usize].place == Place::Outside);
                let near = a.min(b).min(c).cmple(high).all() && a.max(b).max(c).cmpge(low).all();
                outside && near && (b - a).perp_dot(c - a) > 0.0 && skin.points[corners[0] as usize].at.z > 40.0
            })
            .copied()
            .collect();
        Self { skin, triangles }
    }

    /// The three vertices and their weights under (x, y), of the foremost triangle there.
    fn under(&self, at: Vec2) -> Option<[(u32, f32); 3]> {
        let mut best: Option<(f32, [(u32, f32); 3])> = None;
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|vertex| self.skin.points[vertex as usize].at);
            let area = |p: Vec2, q: Vec2, r: Vec2| (q - p).perp_dot(r - p);
            let whole = area(a.truncate(), b.truncate(), c.truncate());
            let wb = area(a.truncate(), at, c.truncate()) / whole;
            let wc = area(a.truncate(), b.truncate(), at) / whole;
            let wa = 1.0 - wb - wc;
            if wa >= -1e-4 && wb >= -1e-4 && wc >= -1e-4 {
                let z = a.z * wa + b.z * wb + c.z * wc;
                if best.is_none_or(|(depth, _)| z > depth) {
                    best = Some((z, [(corners[0], wa), (corners[1], wb), (corners[2], wc)]));
                }
            }
        }
        best.map(|(_, weights)| weights)
    }
}

/// A patch of `rows × columns` points laid on the left half of the face by `place`, and its mirror image.
fn patch(
    skin: &Skin,
    normals: &[Vec3],
    (name, colour): (&'static str, [f32; 3]),
    (rows, columns): (usize, usize),
    place: impl Fn(f32, f32) -> (Vec2, f32),
) -> Piece {
    let part = |i: usize, count: usize| i as f32 / (count - 1) as f32;
    let spots: Vec<(Vec2, f32, [f32; 2])> = (0..rows * columns)
        .map(|i| {
            let (row, column) = (part(i / columns, rows), part(i % columns, columns));
            let (at, height) = place(row, column);
            (at, height, [column, 1.0 - row])
        })
        .collect();
    let low = spots.iter().fold(Vec2::INFINITY, |low, spot| low.min(spot.0)) - 1.0;
    let high = spots.iter().fold(Vec2::NEG_INFINITY, |high, spot| high.max(spot.0)) + 1.0;
    let front = Front::new(skin, low, high);
    let mut piece = Piece {
        name,
        points: Vec::new(),
        triangles: Vec::new(),
        uvs: Vec::new(),
        colour,
        follow: Follow::Skin(Vec::new()),
    };
    let mut weights = Vec::new();
    for mirrored in [false, true] {
        let base = piece.points.len() as u32;
        for (at, height, uv) in &spots {
            let Some(mut under) = front.under(*at) else { continue };
            if mirrored {
                under = under.map(|(vertex, weight)| (skin.mirror[vertex as usize], weight));
            }
            let sum = |of: &dyn Fn(usize) -> Vec3| under.iter().map(|(v, w)| of(*v as usize) * *w).sum::<Vec3>();
            piece.points.push(sum(&|v| skin.points[v].at) + sum(&|v| normals[v]).normalize_or(Vec3::Z) * *height);
            piece.uvs.push(*uv);
            weights.push(under);
        }
        if piece.points.len() as u32 - base < spots.len() as u32 {
            continue;
        }
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let a = base + (row * columns + column) as u32;
                let (b, c, d) = (a + 1, a + columns as u32, a + columns as u32 + 1);
                let pair = if mirrored { [[a, d, b], [a, c, d]] } else { [[a, b, d], [a, d, c]] };
                piece.triangles.extend(pair);
            }
        }
    }
    piece.follow = Follow::Skin(weights);
    piece
}

/// The eyebrows.
pub fn brows(skin: &Skin, normals: &[Vec3], features: &Features) -> Piece {
    let identity = &features.identity;
    patch(skin, normals, ("brows", identity.colours.brows), (9, 49), |row, column| {
        let x = 11.0 + 40.0 * column;
        let y = 54.5 + identity.brow_height + 6.2 * (std::f32::consts::PI * column.powf(1.25)).sin() - 1.0 * column;
        let half = (column / 0.16 + 0.02).min(1.0).sqrt() * (3.6 - 3.0 * column.powf(1.5)) * identity.brow_thickness;
        let across = row * 2.0 - 1.0;
        // Thickest in the middle, down on the skin at the edges.
        (Vec2::new(x, y + across * half), 0.05 + 0.6 * (1.0 - across * across))
    })
}

/// Dark nostrils.
pub fn nostrils(skin: &Skin, normals: &[Vec3], features: &Features) -> Piece {
    let wide = features.identity.nose_width;
    patch(skin, normals, ("nostrils", [0.05, 0.015, 0.012]), (7, 15), |row, column| {
        let turn = column * std::f32::consts::TAU;
        let reach = 0.02 + 0.98 * (1.0 - row);
        let at =
            Vec2::new(6.3 * wide + 2.7 * reach * turn.cos(), -10.6 + (1.2 * turn.sin() - 0.3 * turn.cos()) * reach);
        (at, 0.08)
    })
}
