//! Savitzky–Golay smoothing: each value becomes that of a parabola fitted to its neighbourhood (Analytical Chemistry 36, 1964).

use grimace_plugin::{Call, Fault, Node, Outputs, Schema};

/// Smooths without flattening peaks.
pub struct SavitzkyGolay;

/// Weights of the frames −m to m for the value at 0 of the least-squares parabola:
/// w(i) = (3m² + 3m − 1 − 5i²) · 3 / ((4m² − 1)(2m + 3)), the closed form of the paper's table I. They sum to 1.
fn weights(half: i64) -> Vec<f32> {
    let m = half as f64;
    let scale = 3.0 / ((4.0 * m * m - 1.0) * (2.0 * m + 3.0));
    (-half..=half).map(|i| ((3.0 * m * m + 3.0 * m - 1.0 - 5.0 * (i * i) as f64) * scale) as f32).collect()
}

/// The frames `values` (rows of `channels`), each smoothed over `half` frames on either side; near the ends over as many as
/// there are on both.
pub fn smooth(values: &[f32], channels: usize, half: usize) -> Vec<f32> {
    let frames = values.len() / channels.max(1);
    let table: Vec<Vec<f32>> = (0..=half as i64).map(weights).collect();
    let mut smoothed = vec![0.0_f32; values.len()];
    for (t, row) in smoothed.chunks_exact_mut(channels.max(1)).enumerate() {
        let reach = half.min(t).min(frames - 1 - t);
        let window = &values[(t - reach) * channels..][..(2 * reach + 1) * channels];
        match channels {
            0..4 => middle::<1>(&table[reach], window, row),
            4..32 => middle::<4>(&table[reach], window, row),
            _ => middle::<32>(&table[reach], window, row),
        }
    }
    smoothed
}

/// The rows of `window` times the `weights`, summed, for `N` channels at a time, whose sums stay in registers while the window
/// passes. The last `N` may overlap those before.
fn middle<const N: usize>(weights: &[f32], window: &[f32], row: &mut [f32]) {
    let channels = row.len();
    for first in (0..channels).step_by(N).map(|first| first.min(channels - N)) {
        let mut sums = [0.0; N];
        for (weight, values) in weights.iter().zip(window.chunks_exact(channels)) {
            for (sum, value) in sums.iter_mut().zip(&values[first..first + N]) {
                *sum += weight * value;
            }
        }
        row[first..first + N].copy_from_slice(&sums);
    }
}

impl Node for SavitzkyGolay {
    fn schema() -> Schema {
        Schema::new(
            "savitzky_golay",
            "Fits a parabola around each frame and takes its middle: noise goes, peaks keep their height.",
        )
        .takes("curves", "Curves", "one value per channel and frame")
        .gives("curves", "Curves", "the same channels and frames, smoothed")
        .integer(
            "half_window_frames",
            4,
            1..=100,
            "Frames on either side that the parabola is fitted to. More is calmer.",
        )
        .per_frame_by("half_window_frames")
    }

    fn evaluate(call: &mut Call) -> Result<Outputs, Fault> {
        let half = call.integer("half_window_frames") as usize;
        let mut curves = call.curves("curves")?;
        curves.values = smooth(&curves.values, curves.channels.len(), half);
        Ok(Outputs::of("curves", curves))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_of_the_paper_and_parabolas_stay() {
        let known: Vec<f32> = [-3.0, 12.0, 17.0, 12.0, -3.0].iter().map(|weight| weight / 35.0).collect();
        assert!(weights(2).iter().zip(&known).all(|(found, known)| (found - known).abs() < 1e-6));
        assert_eq!(weights(0), [1.0]);
        let parabola: Vec<f32> = (0..40).map(|t| 0.01 * (t * t) as f32 - 0.3 * t as f32 + 2.0).collect();
        let smoothed = smooth(&parabola, 1, 5);
        assert!(smoothed.iter().zip(&parabola).all(|(found, known)| (found - known).abs() < 1e-4));
    }

    #[test]
    fn a_channel_is_smoothed_alike_whichever_stand_beside_it() {
        let alone: Vec<f32> = (0..50).map(|t| (t as f32 * 0.7).sin()).collect();
        let known = smooth(&alone, 1, 4);
        for channels in [2, 4, 7, 31, 32, 33, 70] {
            let rows: Vec<f32> = alone.iter().flat_map(|value| std::iter::repeat_n(*value, channels)).collect();
            let found = smooth(&rows, channels, 4);
            assert!(
                found.chunks_exact(channels).zip(&known).all(|(row, known)| row.iter().all(|value| value == known))
            );
        }
        assert!(smooth(&[], 0, 4).is_empty());
    }
}
