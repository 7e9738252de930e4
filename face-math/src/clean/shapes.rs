//! Learns the shapes that a face's markers take, from frames in which all are seen; what [`fill_gaps`](super::fill_gaps)
//! tells lost markers by.
//!
//! Principal component analysis of probabilistic kind (Tipping and Bishop, "Probabilistic principal component analysis",
//! 1999): with all coordinates of a frame as one vector x (metres), the head's motion taken out, x = μ + P c + e, where
//! the columns of P are the eigenvectors of the covariance with the largest eigenvalues λₖ, c is normal with the variances
//! λₖ, and e is noise whose variance is the mean of the eigenvalues left out.

use crate::data::{DataError, Markers, ShapeSpace};
use crate::rig::fit_rigid;
use faer::{Mat, Side};
use glam::{DVec3, Vec3};

/// Frames that are learned from at most, spread evenly over those there are.
const MOST_FRAMES: usize = 2000;

/// Fewer complete frames than this show too little of a face.
const LEAST_FRAMES: usize = 20;

/// Noise is not taken to be less than this (metres): exact data still has the rounding of files.
const LEAST_REMAINDER_M: f64 = 1e-6;

/// Why no shapes can be learned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// Too few frames show all markers.
    #[error(
        "{frames} frames show all {markers} markers, {needed} are needed{}; give other takes, or leave out markers that \
         are seldom seen", worst.as_ref().map(|(name, seen)| format!(" (`{name}` is seen in {seen})")).unwrap_or_default()
    )]
    Frames {
        /// Complete frames.
        frames: usize,
        /// Markers.
        markers: usize,
        /// Frames needed.
        needed: usize,
        /// The marker seen least, and in how many frames.
        worst: Option<(String, usize)>,
    },
    /// Too few markers are in all takes.
    #[error("{markers} markers are in all takes; at least four are needed")]
    Markers {
        /// Their number.
        markers: usize,
    },
    /// The covariance has no decomposition.
    #[error("the motion of the markers cannot be decomposed; check them for points that are far away")]
    Decomposition,
    /// The results do not fit together.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// The shapes of the markers `names` in the complete frames of `takes` (metres), as at most `modes` modes.
///
/// # Errors
/// Where a take lacks one of the markers, or fewer than four are asked for, or too few frames show all of them.
pub fn learn_shapes(takes: &[&Markers], names: &[String], modes: usize) -> Result<ShapeSpace, ShapeError> {
    if names.len() < 4 {
        return Err(ShapeError::Markers { markers: names.len() });
    }
    let picked = takes.iter().map(|take| take.pick(names)).collect::<Result<Vec<_>, _>>()?;
    let complete: Vec<&[Vec3]> = picked
        .iter()
        .flat_map(|take| (0..take.frames()).map(move |frame| take.frame(frame)))
        .filter(|points| points.iter().all(|point| point.is_finite()))
        .collect();
    if complete.len() < LEAST_FRAMES {
        let seen = |marker: usize| {
            let points = picked.iter().flat_map(|take| (0..take.frames()).map(move |frame| take.frame(frame)[marker]));
            points.filter(|point| point.is_finite()).count()
        };
        let worst = (0..names.len()).map(|marker| (seen(marker), marker)).min();
        let worst = worst.map(|(seen, marker)| (names[marker].clone(), seen));
        let (frames, markers) = (complete.len(), names.len());
        return Err(ShapeError::Frames { frames, markers, needed: LEAST_FRAMES, worst });
    }
    let step = complete.len().div_ceil(MOST_FRAMES);
    let mut frames: Vec<Vec<DVec3>> =
        complete.iter().step_by(step).map(|points| points.iter().map(|point| point.as_dvec3()).collect()).collect();
    let mean = aligned(&mut frames);
    decompose(names, &mean, &frames, modes)
}

/// Turns and moves every frame onto their common mean (Procrustes analysis: Gower, 1975), which it gives.
fn aligned(frames: &mut [Vec<DVec3>]) -> Vec<DVec3> {
    let mut mean = frames[0].clone();
    for _ in 0..3 {
        for frame in &mut *frames {
            if let Ok(fit) = fit_rigid(frame, &mean, None) {
                for point in frame.iter_mut() {
                    *point = fit.motion.apply(*point);
                }
            }
        }
        let count = frames.len() as f64;
        mean = (0..mean.len()).map(|marker| frames.iter().map(|frame| frame[marker]).sum::<DVec3>() / count).collect();
    }
    mean
}

fn decompose(names: &[String], mean: &[DVec3], frames: &[Vec<DVec3>], modes: usize) -> Result<ShapeSpace, ShapeError> {
    let size = 3 * mean.len();
    let mut offsets = Mat::<f64>::zeros(size, frames.len());
    for (column, frame) in frames.iter().enumerate() {
        for (marker, (point, middle)) in frame.iter().zip(mean).enumerate() {
            for axis in 0..3 {
                offsets[(3 * marker + axis, column)] = (*point - *middle)[axis];
            }
        }
    }
    let covariance = (&offsets * offsets.transpose()) * faer::Scale(1.0 / frames.len() as f64);
    let eigen = covariance.self_adjoint_eigen(Side::Lower).map_err(|_| ShapeError::Decomposition)?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    // They come smallest first. Six are lost to the head's motion, and as many as frames are at most told.
    let largest = values[size - 1].max(f64::MIN_POSITIVE);
    let told = (0..size).rev().filter(|place| values[*place] > 1e-9 * largest);
    let told: Vec<usize> = told.take(modes.min(frames.len() - 1)).collect();
    let rest: f64 = (0..size - told.len()).map(|place| values[place].max(0.0)).sum();
    let remainder_m = (rest / (size - told.len()).max(1) as f64).sqrt().max(LEAST_REMAINDER_M);
    let mode = |place: usize| {
        (0..mean.len()).map(move |marker| {
            DVec3::from_array(std::array::from_fn(|axis| vectors[(3 * marker + axis, place)])).as_vec3()
        })
    };
    let spreads_m = told.iter().map(|place| values[*place].sqrt()).collect();
    let modes = told.iter().flat_map(|place| mode(*place)).collect();
    let mean = mean.iter().map(|point| point.as_vec3()).collect();
    Ok(ShapeSpace::new(names.to_vec(), mean, modes, spreads_m, remainder_m)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clean::motion_of;
    use crate::rig::toy::Dice;
    use wire::FrameAxis;

    /// Frames of a face with two ways to move, on a head that turns.
    fn take(frames: usize, noise_m: f32) -> Markers {
        let mut dice = Dice(40);
        let rest: Vec<Vec3> = (0..15).map(|_| dice.point() * 0.08).collect();
        let ways: Vec<Vec<Vec3>> = (0..2).map(|_| (0..15).map(|_| dice.point() * 3e-3).collect()).collect();
        let mut positions = Vec::new();
        for frame in 0..frames {
            let time = frame as f64 * 0.07;
            let motion = motion_of([time, 0.1, 0.2, 0.3 * time.sin(), 0.2 * time, 0.1]);
            let by = [time.sin() as f32, (1.7 * time).cos() as f32];
            for marker in 0..15 {
                let place = rest[marker] + by[0] * ways[0][marker] + by[1] * ways[1][marker];
                positions.push(motion.apply(place.as_dvec3()).as_vec3() + dice.point() * noise_m);
            }
        }
        let names = (0..15).map(|marker| format!("m{marker}")).collect();
        Markers::new(FrameAxis::new(frames, 60.0), names, positions).unwrap()
    }

    #[test]
    fn two_ways_to_move_are_two_modes_at_right_angles() {
        let take = take(400, 0.0);
        let space = learn_shapes(&[&take], take.names(), 10).unwrap();
        let spreads = space.spreads_m();
        assert!(spreads[1] > 1e-3 && (spreads.len() < 3 || spreads[2] < 0.1 * spreads[1]), "{spreads:?}");
        let product = |a: usize, b: usize| space.mode(a).iter().zip(space.mode(b)).map(|(a, b)| a.dot(*b)).sum::<f32>();
        assert!((product(0, 0) - 1.0).abs() < 1e-5 && product(0, 1).abs() < 1e-5);
    }

    #[test]
    fn noise_is_what_is_left_over() {
        let take = take(1500, 2e-4);
        let space = learn_shapes(&[&take], take.names(), 3).unwrap();
        // Evenly spread noise in −1..1 has the deviation 1/√3.
        let ratio = space.remainder_m() / (2e-4 / 3.0_f64.sqrt());
        assert!((0.8..1.1).contains(&ratio), "{ratio}");
    }

    #[test]
    fn what_shows_too_little_is_refused() {
        let take = take(60, 0.0);
        let mut positions = take.positions().to_vec();
        for frame in 5..60 {
            positions[frame * 15 + 3] = Vec3::NAN;
        }
        let error = learn_shapes(&[&take.with_positions(positions).unwrap()], take.names(), 3).unwrap_err().to_string();
        assert!(error.contains("5 frames show all 15 markers") && error.contains("`m3` is seen in 5"), "{error}");
        assert_eq!(learn_shapes(&[&take], &take.names()[..3], 3).unwrap_err(), ShapeError::Markers { markers: 3 });
        assert!(learn_shapes(&[&take], &["x".to_owned(), "m0".into(), "m1".into(), "m2".into()], 3).is_err());
    }
}
