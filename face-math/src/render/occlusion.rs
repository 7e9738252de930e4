//! Screen-space ambient occlusion: how much of the sky a visible point loses to what stands before it nearby.
//! It lets mouths, nostrils and lid folds read as deep without any shadow computation.

use rayon::prelude::*;

/// Pairs of opposite directions around a point.
const PAIRS: usize = 5;
/// Distances of the samples in metres, and how much each counts: folds first, then cavities.
const RINGS: [(f32, f32); 4] = [(0.0012, 0.28), (0.0032, 0.34), (0.007, 0.36), (0.014, 0.36)];

/// Occlusion of each pixel, 0 (open) to 1 (shut in), from a depth map in metres (infinite at the background);
/// `scale_px` is the focal length in pixels.
///
/// Two opposite neighbours at distance d that stand h₁ and h₂ nearer to the camera make a hollow of depth
/// h = (h₁ + h₂) / 2 (all in metres), which is nothing on any slope; it counts by its steepness, h / √(h² + d²).
pub fn occlusion(depths_m: &[f32], width_px: usize, height_px: usize, scale_px: f32) -> Vec<f32> {
    // Every ring is turned a little against the one before, so that no direction stands out.
    let taps: Vec<(f32, f32, f32, f32)> = RINGS
        .iter()
        .enumerate()
        .flat_map(|(ring, (distance, share))| {
            (0..PAIRS).map(move |pair| {
                let turn = (pair as f32 + ring as f32 * 0.29) * std::f32::consts::PI / PAIRS as f32;
                (turn.cos() * distance, turn.sin() * distance, *distance, share * 2.0 / PAIRS as f32)
            })
        })
        .collect();
    let (right, bottom) = (width_px as f32, height_px as f32);
    let mut shade = vec![0.0; depths_m.len()];
    shade.par_chunks_mut(width_px.max(1)).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            let depth = depths_m[y * width_px + x];
            if !depth.is_finite() {
                continue;
            }
            let pixels_a_metre = scale_px / depth;
            let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
            let mut sum = 0.0;
            for (across, down, beside, share) in &taps {
                let (dx, dy) = (across * pixels_a_metre, down * pixels_a_metre);
                let inside = |sx: f32, sy: f32| sx >= 0.0 && sy >= 0.0 && sx < right && sy < bottom;
                if !inside(x + dx, y + dy) || !inside(x - dx, y - dy) {
                    continue;
                }
                let height = |sx: f32, sy: f32| {
                    // What stands far before is another thing, and what lies far behind opens no more than a cliff.
                    let height = depth - depths_m[sy as usize * width_px + sx as usize];
                    height.max(-3.0 * beside) * (1.0 - height / 0.03).clamp(0.0, 1.0)
                };
                let hollow = 0.5 * (height(x + dx, y + dy) + height(x - dx, y - dy));
                if hollow > 0.0 {
                    sum += share * hollow / (hollow * hollow + beside * beside).sqrt();
                }
            }
            *out = sum.min(1.0);
        }
    });
    soften(&shade, width_px, height_px)
}

/// The mean over each pixel and its eight neighbours: few samples leave rings, which this washes out.
fn soften(shade: &[f32], width_px: usize, height_px: usize) -> Vec<f32> {
    let mut soft = vec![0.0; shade.len()];
    soft.par_chunks_mut(width_px.max(1)).enumerate().for_each(|(y, row)| {
        let rows = y.saturating_sub(1)..(y + 2).min(height_px);
        for (x, out) in row.iter_mut().enumerate() {
            let columns = x.saturating_sub(1)..(x + 2).min(width_px);
            let count = rows.len() * columns.len();
            let sum: f32 = rows.clone().map(|r| shade[r * width_px..][columns.clone()].iter().sum::<f32>()).sum();
            *out = sum / count as f32;
        }
    });
    soft
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Depths (m) over a picture of 81 x 81 pixels at 2 pixels a millimetre and half a metre away.
    fn middle(depth: impl Fn(f32, f32) -> f32) -> f32 {
        let depths: Vec<f32> = (0..81 * 81)
            .map(|i| 0.5 + depth((i % 81) as f32 / 2000.0 - 0.02, (i / 81) as f32 / 2000.0 - 0.02))
            .collect();
        occlusion(&depths, 81, 81, 1000.0)[40 * 81 + 40]
    }

    #[test]
    fn planes_and_hills_are_open_and_pits_are_dark() {
        assert!(middle(|_, _| 0.0) < 1e-6);
        assert!(middle(|x, y| 0.8 * x - 0.3 * y) < 0.02, "a slope");
        assert!(middle(|x, y| 20.0 * (x * x + y * y)) < 1e-6, "a hill");
        let (shallow, deep) = (middle(|x, _| -10.0 * x * x), middle(|x, y| -60.0 * (x * x + y * y)));
        assert!(shallow > 0.01 && deep > 2.0 * shallow, "{shallow} {deep}");
    }
}
