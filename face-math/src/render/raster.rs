//! Visibility: which triangle is seen at each sample. Depth buffer over perspective-projected triangles.

use super::camera::Projector;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// No triangle covers this sample.
pub const NOTHING: u32 = u32::MAX;

/// One sample of the picture: the nearest triangle, and where on it.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Index of the triangle, or [`NOTHING`].
    pub triangle: u32,
    /// 1 / depth (1/m); 0 at the background.
    pub inverse_depth: f32,
    /// Barycentric weights of the second and third vertex, in space (not on the screen).
    pub weights: [f32; 2],
}

const EMPTY: Sample = Sample { triangle: NOTHING, inverse_depth: 0.0, weights: [0.0; 2] };

/// A vertex on the screen: pixels, and 1 / depth.
#[derive(Debug, Clone, Copy)]
struct Placed {
    at_px: Vec2,
    inverse_depth: f32,
}

/// The samples of a `width × height` picture, rows from the top.
pub fn rasterise(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    projector: &Projector,
    width_px: usize,
    height_px: usize,
) -> Vec<Sample> {
    let placed: Vec<Option<Placed>> = positions
        .iter()
        .map(|point| projector.project(*point).map(|(at_px, depth)| Placed { at_px, inverse_depth: 1.0 / depth }))
        .collect();
    let mut samples = vec![EMPTY; width_px * height_px];
    // Bands of rows are independent of each other, so the outcome does not depend on how they are shared out.
    let band_rows = 64;
    samples.par_chunks_mut(width_px.max(1) * band_rows).enumerate().for_each(|(band, rows)| {
        let first = (band * band_rows) as f32;
        let last = first + (rows.len() / width_px) as f32;
        for (index, corners) in triangles.iter().enumerate() {
            let [Some(a), Some(b), Some(c)] = corners.map(|vertex| placed[vertex as usize]) else { continue };
            let low = a.at_px.min(b.at_px).min(c.at_px);
            let high = a.at_px.max(b.at_px).max(c.at_px);
            if high.y < first || low.y > last || high.x < 0.0 || low.x > width_px as f32 {
                continue;
            }
            fill(rows, width_px, (first, last), (low, high), index as u32, [a, b, c]);
        }
    });
    samples
}

/// Twice the signed area of the triangle a, b, c on the screen: (b − a) × (c − a), in px².
fn area(a: Vec2, b: Vec2, c: Vec2) -> f32 {
    (b - a).perp_dot(c - a)
}

fn fill(
    rows: &mut [Sample],
    width_px: usize,
    (first, last): (f32, f32),
    (low, high): (Vec2, Vec2),
    triangle: u32,
    [a, b, c]: [Placed; 3],
) {
    let whole = area(a.at_px, b.at_px, c.at_px);
    if whole.abs() < 1e-9 {
        return;
    }
    let (x0, x1) = ((low.x - 0.5).ceil().max(0.0) as usize, (high.x - 0.5).floor().min(width_px as f32 - 1.0));
    let (y0, y1) = ((low.y - 0.5).ceil().max(first) as usize, (high.y - 0.5).floor().min(last - 1.0));
    if x1 < 0.0 || y1 < 0.0 {
        return;
    }
    for y in y0..=y1 as usize {
        let row = (y - first as usize) * width_px;
        for x in x0..=x1 as usize {
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let wb = area(a.at_px, at, c.at_px) / whole;
            let wc = area(a.at_px, b.at_px, at) / whole;
            let wa = 1.0 - wb - wc;
            if wa < 0.0 || wb < 0.0 || wc < 0.0 {
                continue;
            }
            // 1/depth is linear on the screen; attributes times 1/depth are too.
            let inverse_depth = wa * a.inverse_depth + wb * b.inverse_depth + wc * c.inverse_depth;
            let sample = &mut rows[row + x];
            if inverse_depth > sample.inverse_depth {
                let weights = [wb * b.inverse_depth / inverse_depth, wc * c.inverse_depth / inverse_depth];
                *sample = Sample { triangle, inverse_depth, weights };
            }
        }
    }
}
