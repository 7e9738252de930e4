//! Visibility: which triangle is seen at each sample. Depth buffer over perspective-projected triangles.

use super::camera::Projector;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

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

/// How far outside a triangle (in its own size) a sample still counts as on its edge, so that no gaps open.
const ON_EDGE: f32 = 1e-5;

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
    let prepared: Vec<Option<Prepared>> = triangles
        .par_iter()
        .map(|corners| {
            let [Some(a), Some(b), Some(c)] = corners.map(|vertex| placed[vertex as usize]) else { return None };
            Prepared::new([a, b, c], width_px, height_px)
        })
        .collect();
    let mut samples = vec![EMPTY; width_px * height_px];
    // Bands of rows are independent of each other, so the outcome does not depend on how they are shared out.
    let band_rows = 64;
    samples.par_chunks_mut(width_px.max(1) * band_rows).enumerate().for_each(|(band, rows)| {
        let first = band * band_rows;
        let band = first..first + rows.len() / width_px;
        for (index, triangle) in prepared.iter().enumerate() {
            if let Some(triangle) = triangle
                && triangle.rows.0 < band.end
                && triangle.rows.1 >= band.start
            {
                triangle.fill(rows, width_px, &band, index as u32);
            }
        }
    });
    samples
}

/// Twice the signed area of the triangle a, b, c on the screen: (b − a) × (c − a), in px².
fn area(a: Vec2, b: Vec2, c: Vec2) -> f32 {
    (b - a).perp_dot(c - a)
}

/// A triangle made ready to be filled: the pixels it may cover, and its barycentric weights as functions on the screen.
struct Prepared {
    /// First and last column and row.
    columns: (usize, usize),
    rows: (usize, usize),
    /// Gradient (1/px) of the weights of the second and third corner, and where on the screen each is 0.
    slopes: [(Vec2, Vec2); 2],
    inverse_depths: [f32; 3],
}

impl Prepared {
    fn new([a, b, c]: [Placed; 3], width_px: usize, height_px: usize) -> Option<Self> {
        let low = a.at_px.min(b.at_px).min(c.at_px) - 0.5;
        let high = a.at_px.max(b.at_px).max(c.at_px) - 0.5;
        let whole = area(a.at_px, b.at_px, c.at_px);
        let outside = high.x < 0.0 || high.y < 0.0 || low.x > width_px as f32 || low.y > height_px as f32;
        if outside || whole.abs() < 1e-9 {
            return None;
        }
        let span = |low: f32, high: f32, size: usize| {
            (low.ceil().max(0.0) as usize, (high.floor().max(0.0) as usize).min(size.saturating_sub(1)))
        };
        let slope = |from: Vec2, to: Vec2| (Vec2::new(from.y - to.y, to.x - from.x) / whole, from);
        Some(Self {
            columns: span(low.x, high.x, width_px),
            rows: span(low.y, high.y, height_px),
            slopes: [slope(c.at_px, a.at_px), slope(a.at_px, b.at_px)],
            inverse_depths: [a.inverse_depth, b.inverse_depth, c.inverse_depth],
        })
    }

    /// Fills the rows of a band.
    fn fill(&self, samples: &mut [Sample], width_px: usize, band: &Range<usize>, triangle: u32) {
        let [(slope_b, zero_b), (slope_c, zero_c)] = self.slopes;
        let [a, b, c] = self.inverse_depths;
        for y in self.rows.0.max(band.start)..=self.rows.1.min(band.end - 1) {
            let row = &mut samples[(y - band.start) * width_px..][..width_px];
            for (x, sample) in row.iter_mut().enumerate().take(self.columns.1 + 1).skip(self.columns.0) {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let wb = slope_b.dot(at - zero_b);
                let wc = slope_c.dot(at - zero_c);
                let wa = 1.0 - wb - wc;
                if wa < -ON_EDGE || wb < -ON_EDGE || wc < -ON_EDGE {
                    continue;
                }
                // 1/depth is linear on the screen; attributes times 1/depth are too.
                let inverse_depth = wa * a + wb * b + wc * c;
                if inverse_depth > sample.inverse_depth {
                    let weights = [wb * b / inverse_depth, wc * c / inverse_depth];
                    *sample = Sample { triangle, inverse_depth, weights };
                }
            }
        }
    }
}
