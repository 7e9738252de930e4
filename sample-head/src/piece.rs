//! Pieces: the parts of the head besides the skin while they are being made, and what each of them follows.

use glam::Vec3;

/// What a piece moves with.
#[derive(Debug, Clone)]
pub enum Follow {
    /// The jaw, each vertex by its share: 0 stays with the skull, 1 goes with the jaw.
    Jaw(Vec<f32>),
    /// The eyeball: 0 the performer's left, 1 the right.
    Eye(usize),
    /// The inside of the mouth: each vertex by a share of one vertex of the skin, and a share of the jaw.
    Lining(Vec<(u32, f32, f32)>),
    /// The skin: each vertex by a weighted sum of three of the skin's.
    Skin(Vec<[(u32, f32); 3]>),
}

/// A part of the head, in millimetres.
#[derive(Debug, Clone)]
pub struct Piece {
    /// Name of the part.
    pub name: &'static str,
    /// Neutral positions.
    pub points: Vec<Vec3>,
    /// Triangles over the piece's own vertices, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// Linear RGB.
    pub colour: [f32; 3],
    /// What it moves with.
    pub follow: Follow,
}

/// A sheet of `rows × columns` vertices, from `place(row, column)` in 0..1 each, with its triangles and texture
/// coordinates. Triangles are counter-clockwise where rows run up and columns to the left of the performer.
pub fn sheet(
    rows: usize,
    columns: usize,
    place: impl Fn(f32, f32) -> Vec3,
) -> (Vec<Vec3>, Vec<[u32; 3]>, Vec<[f32; 2]>) {
    let part = |i: usize, count: usize| i as f32 / (count - 1) as f32;
    let (mut points, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..rows {
        for column in 0..columns {
            points.push(place(part(row, rows), part(column, columns)));
            uvs.push([part(column, columns), 1.0 - part(row, rows)]);
        }
    }
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let a = (row * columns + column) as u32;
            let (b, c, d) = (a + 1, a + columns as u32, a + columns as u32 + 1);
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    (points, triangles, uvs)
}

/// Turns triangles to face the other way.
pub fn flip(triangles: &mut [[u32; 3]]) {
    for corners in triangles {
        corners.swap(1, 2);
    }
}
