//! Screen-space ambient occlusion: how much of the sky a visible point loses to what stands before it nearby.
//! It lets mouths, nostrils and lid folds read as deep without any shadow computation.

use rayon::prelude::*;

/// Directions of the samples around a point.
const SPOKES: usize = 8;
/// Distances of the samples, as parts of the radius.
const RINGS: [f32; 3] = [0.22, 0.55, 1.0];

/// Occlusion of each pixel, 0 (open) to 1 (shut in), from a depth map in metres (infinite at the background).
///
/// Each neighbour that stands nearer to the camera counts by the steepness of the line to it, h / √(h² + d²), with h
/// the height above the point and d the distance beside it (both in metres), and counts less beyond the radius.
pub fn occlusion(depths_m: &[f32], width_px: usize, height_px: usize, scale_px: f32, radius_m: f32) -> Vec<f32> {
    let spokes: Vec<(f32, f32)> = (0..SPOKES)
        .map(|i| {
            let angle = (i as f32 + 0.3) * std::f32::consts::TAU / SPOKES as f32;
            (angle.cos(), angle.sin())
        })
        .collect();
    let at = |x: usize, y: usize| depths_m[y * width_px + x];
    let mut shade = vec![0.0; depths_m.len()];
    shade.par_chunks_mut(width_px.max(1)).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            let depth = at(x, y);
            if !depth.is_finite() {
                continue;
            }
            let radius_px = scale_px * radius_m / depth;
            let mut sum = 0.0;
            for (cos, sin) in &spokes {
                for ring in RINGS {
                    let sx = x as f32 + cos * radius_px * ring;
                    let sy = y as f32 + sin * radius_px * ring;
                    if sx < 0.0 || sy < 0.0 || sx >= width_px as f32 || sy >= height_px as f32 {
                        continue;
                    }
                    let height = depth - at(sx as usize, sy as usize);
                    if height > 0.0 {
                        let beside = radius_m * ring;
                        let far = (1.0 - height / (4.0 * radius_m)).clamp(0.0, 1.0);
                        sum += height / height.hypot(beside) * far;
                    }
                }
            }
            *out = sum / (SPOKES * RINGS.len()) as f32;
        }
    });
    shade
}
