//! How noisy markers are, told from a take itself: what [`super::finetune`](super::finetune()) weighs them by, and what
//! training data is shaken with (Σ in section 4.1 of FDLS, "analyzing the jitter of the tracked markers").
//!
//! Faces move smoothly from frame to frame, noise does not. The fourth difference of a coordinate over time,
//!
//! ```text
//! δₜ = xₜ₋₂ − 4 xₜ₋₁ + 6 xₜ − 4 xₜ₊₁ + xₜ₊₂
//! ```
//!
//! is 0 for motion up to a cubic, and for noise that is new in every frame its variance is 1² + 4² + 6² + 4² + 1² = 70 times
//! the noise's. Blinks and plosives are faster than a cubic but rare, so the middle of |δ| is taken instead of its mean:
//! σ = median |δ| / (0.6745 √70), 0.6745 being the median of |z| for a standard normal z. Noise that lasts from frame to frame
//! (a slipping mask, a filter) is not seen.

use crate::data::Markers;
use std::collections::BTreeSet;

/// The noise of one marker.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerJitter {
    /// The marker.
    pub marker: String,
    /// Standard deviation of each coordinate (x, y, z), in millimetres.
    pub by_axis_mm: [f64; 3],
    /// Root mean square of the three: the standard deviation of a coordinate, in millimetres.
    pub sigma_mm: f64,
    /// Runs of five seen frames that it was told from.
    pub runs: usize,
}

/// Fewer runs than this tell little: the median of 50 is good to about a sixth.
pub const NEEDED_RUNS: usize = 50;

/// The noise of the markers of `takes` (metres), over all of them together, in the order in which they first stand there.
/// Markers that are seen in fewer than `needed_runs` runs of five consecutive frames are left out.
pub fn measure_jitter(takes: &[&Markers], needed_runs: usize) -> Vec<MarkerJitter> {
    let scale = 1000.0 / (0.6745 * 70.0_f64.sqrt());
    let mut names: Vec<&String> = Vec::new();
    let mut known = BTreeSet::new();
    for name in takes.iter().flat_map(|take| take.names()) {
        if known.insert(name) {
            names.push(name);
        }
    }
    let mut found = Vec::with_capacity(names.len());
    for name in names {
        let mut sizes = [const { Vec::new() }; 3];
        for take in takes {
            if let Some(marker) = take.index(name) {
                differences(take, marker, &mut sizes);
            }
        }
        let runs = sizes[0].len();
        if runs < needed_runs.max(1) {
            continue;
        }
        let by_axis_mm = sizes.map(|mut sizes| scale * median(&mut sizes));
        let sigma_mm = (by_axis_mm.iter().map(|sigma| sigma * sigma).sum::<f64>() / 3.0).sqrt();
        found.push(MarkerJitter { marker: name.clone(), by_axis_mm, sigma_mm, runs });
    }
    found
}

/// |δ| of each axis, in metres, wherever the marker is seen in five frames on end.
fn differences(take: &Markers, marker: usize, sizes: &mut [Vec<f64>; 3]) {
    for frame in 2..take.frames().saturating_sub(2) {
        let at = |frame: usize| take.frame(frame)[marker].as_dvec3();
        let ends = at(frame - 2) + at(frame + 2);
        let delta = ends - 4.0 * (at(frame - 1) + at(frame + 1)) + 6.0 * at(frame);
        if delta.is_finite() {
            for (sizes, delta) in sizes.iter_mut().zip(delta.to_array()) {
                sizes.push(delta.abs());
            }
        }
    }
}

/// The middle of a list of sizes; of an even number, the mean of the two in the middle.
fn median(sizes: &mut [f64]) -> f64 {
    let count = sizes.len();
    let (below, upper, _) = sizes.select_nth_unstable_by(count / 2, f64::total_cmp);
    let lower = if count % 2 == 1 { *upper } else { below.iter().copied().fold(0.0, f64::max) };
    0.5 * (lower + *upper)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;
    use glam::Vec3;
    use wire::FrameAxis;

    /// Markers on slow paths with a blink now and then, shaken by the given noise (millimetres).
    fn take(frames: usize, noise_mm: &[f32]) -> Markers {
        let mut dice = Dice(71);
        // The sum of twelve evenly spread numbers in −1..1 is nearly normal, with variance 4.
        let mut normal = || (0..12).map(|_| dice.roll()).sum::<f32>() / 2.0;
        let mut positions = Vec::new();
        for frame in 0..frames {
            let time = frame as f32 / 60.0;
            let blink = if frame % 90 < 6 { 4e-3 } else { 0.0 };
            for sigma in noise_mm {
                let path = Vec3::new(0.005 * (3.0 * time).sin(), 0.01 * time.cos() + blink, 0.1);
                positions.push(path + Vec3::new(normal(), normal(), normal()) * *sigma * 1e-3);
            }
        }
        let names = (0..noise_mm.len()).map(|marker| format!("m{marker}")).collect();
        Markers::new(FrameAxis::new(frames, 60.0), names, positions).unwrap()
    }

    #[test]
    fn the_noise_is_found_under_motion_and_blinks() {
        let noise = [0.05, 0.1, 0.2];
        for (found, known) in measure_jitter(&[&take(3000, &noise)], NEEDED_RUNS).iter().zip(noise) {
            let ratio = found.sigma_mm / f64::from(known);
            assert!((0.93..1.1).contains(&ratio), "{found:?}");
            assert_eq!(found.runs, 2996);
        }
    }

    #[test]
    fn a_still_take_has_no_noise_and_gaps_are_passed_over() {
        let still = Markers::new(FrameAxis::new(80, 60.0), vec!["a".into()], vec![Vec3::ONE; 80]).unwrap();
        assert!(measure_jitter(&[&still], NEEDED_RUNS)[0].sigma_mm < 1e-9);
        let take = take(400, &[0.1]);
        let mut positions = take.positions().to_vec();
        positions[100..200].fill(Vec3::NAN);
        let found = measure_jitter(&[&take.with_positions(positions.clone()).unwrap()], NEEDED_RUNS);
        assert_eq!(found[0].runs, 96 + 196);
        positions[40..].fill(Vec3::NAN);
        let short = take.with_positions(positions).unwrap();
        assert_eq!(measure_jitter(&[&short], NEEDED_RUNS), []);
        assert_eq!(measure_jitter(&[&short, &short], NEEDED_RUNS)[0].runs, 72, "takes are measured together");
    }

    #[test]
    fn the_median_stands_in_the_middle() {
        assert!((median(&mut [5.0, 1.0, 3.0]) - 3.0).abs() < 1e-12);
        assert!((median(&mut [4.0, 1.0, 3.0, 9.0]) - 3.5).abs() < 1e-12);
    }
}
