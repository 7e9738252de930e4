//! Calms a rigid motion over time, and drops what is within its noise: that of few markers shakes the whole head. Called by
//! [`stabilize`](super::stabilize()).
//!
//! Around frame t, motions are told relative to that of t, as a rotation vector and the way of a centre c, each fitted
//! over time by a quadratic with Gaussian weights exp(−k² / 2 s²), k frames away (local regression; Cleveland 1979); its
//! value at t is taken. Where all frames around are there, noise falls to about 0.69 / √s of itself (standard deviation),
//! and even acceleration passes unchanged.

use crate::rig::Rigid;
use glam::{DMat3, DQuat, DVec3};

/// Frames on either side that [`calm_motion`] looks at.
pub fn calm_reach(smoothing_frames: f64) -> usize {
    (3.0 * smoothing_frames).ceil() as usize
}

/// The motions, calmed over `smoothing_frames` (0: as they are) around `centre`, a point at rest (metres). Frames
/// without a motion have none afterwards.
pub fn calm_motion(motions: &[Option<Rigid>], centre: DVec3, smoothing_frames: f64) -> Vec<Option<Rigid>> {
    let reach = calm_reach(smoothing_frames);
    if reach == 0 {
        return motions.to_vec();
    }
    let calm = |frame: usize, own: &Rigid| {
        let (first, end) = (frame.saturating_sub(reach), (frame + reach + 1).min(motions.len()));
        let back = own.rotation.transpose();
        let mut around = Vec::with_capacity(end - first);
        for (other, motion) in motions.iter().enumerate().take(end).skip(first) {
            if let Some(motion) = motion {
                let turn = DQuat::from_mat3(&(back * motion.rotation)).to_scaled_axis();
                around.push((other as f64 - frame as f64, turn, motion.apply(centre) - own.apply(centre)));
            }
        }
        let times: Vec<f64> = around.iter().map(|(time, _, _)| *time).collect();
        let shares = shares(&times, smoothing_frames);
        let (mut turn, mut way) = (DVec3::ZERO, DVec3::ZERO);
        for ((_, own_turn, own_way), share) in around.iter().zip(shares) {
            turn += share * *own_turn;
            way += share * *own_way;
        }
        let rotation = own.rotation * DMat3::from_quat(DQuat::from_scaled_axis(turn));
        Rigid { rotation, translation_m: own.apply(centre) + way - rotation * centre }
    };
    motions.iter().enumerate().map(|(frame, own)| own.as_ref().map(|own| calm(frame, own))).collect()
}

/// A motion without what may be noise: 1 − (n / r)² of it, where r is how far it moves the points `rest` (root mean
/// square, metres) and n is `least_m`; none of it where r < n. (The estimator of James and Stein, 1961, with n² as the noise;
/// its positive part.) Turns go about the middle of `rest`.
pub fn shrink_motion(motion: &Rigid, rest: &[DVec3], least_m: f64) -> Rigid {
    if least_m <= 0.0 || rest.is_empty() {
        return *motion;
    }
    let count = rest.len() as f64;
    let squares = rest.iter().map(|point| motion.apply(*point).distance_squared(*point)).sum::<f64>() / count;
    let share = 1.0 - least_m * least_m / squares;
    if squares <= least_m * least_m {
        return Rigid { rotation: DMat3::IDENTITY, translation_m: DVec3::ZERO };
    }
    let centre = rest.iter().sum::<DVec3>() / count;
    let turn = share * DQuat::from_mat3(&motion.rotation).to_scaled_axis();
    let rotation = DMat3::from_quat(DQuat::from_scaled_axis(turn));
    let way = share * (motion.apply(centre) - centre);
    Rigid { rotation, translation_m: centre + way - rotation * centre }
}

/// How much each sample counts for the value at time 0 of the quadratic fitted to samples at `times`: of a straight line
/// or a constant where there are fewer than five or three of them.
fn shares(times: &[f64], smoothing_frames: f64) -> Vec<f64> {
    let weight = |time: f64| (-0.5 * (time / smoothing_frames).powi(2)).exp();
    // Samples that hardly count do not fix a term.
    let powers = match times.iter().filter(|time| weight(**time) > 1e-3).count() {
        0..3 => 1,
        3..5 => 2,
        _ => 3,
    };
    // Moments of the weights; time in units of the smoothing, so that they are of one size.
    let mut moments = [0.0; 5];
    for time in times {
        for (power, moment) in moments.iter_mut().enumerate() {
            *moment += weight(*time) * (time / smoothing_frames).powi(power as i32);
        }
    }
    let mut matrix = DMat3::IDENTITY;
    for i in 0..powers {
        for j in 0..powers {
            matrix.col_mut(i)[j] = moments[i + j];
        }
    }
    // The value at 0 is the first coefficient: the first row of the inverse, times the moments of each sample.
    let first = matrix.inverse().transpose().col(0);
    let share = |time: &f64| {
        let unit = time / smoothing_frames;
        let terms = DVec3::new(1.0, unit, unit * unit);
        weight(*time) * (0..powers).map(|power| first[power] * terms[power]).sum::<f64>()
    };
    times.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    fn moved(turn: DVec3, way: DVec3) -> Rigid {
        Rigid { rotation: DMat3::from_quat(DQuat::from_scaled_axis(turn)), translation_m: way }
    }

    fn apart(a: &Rigid, b: &Rigid) -> f64 {
        let point = DVec3::new(0.03, -0.02, 0.1);
        a.apply(point).distance(b.apply(point))
    }

    #[test]
    fn even_acceleration_passes_and_gaps_stay() {
        let mut motions: Vec<Option<Rigid>> =
            (0..60).map(|t| Some(moved(DVec3::X * 0.01 * f64::from(t), DVec3::Y * 1e-5 * f64::from(t * t)))).collect();
        motions[20] = None;
        let calm = calm_motion(&motions, DVec3::ZERO, 6.0);
        for (frame, (calm, own)) in calm.iter().zip(&motions).enumerate() {
            match (calm, own) {
                (Some(calm), Some(own)) => assert!(apart(calm, own) < 1e-9, "frame {frame}: {}", apart(calm, own)),
                (calm, own) => assert!(calm.is_none() && own.is_none()),
            }
        }
        assert_eq!(calm_motion(&motions, DVec3::ZERO, 0.0), motions);
    }

    #[test]
    fn noise_falls_as_the_formula_says() {
        let mut dice = Dice(3);
        let mut noise = || DVec3::new(f64::from(dice.roll()), f64::from(dice.roll()), f64::from(dice.roll())) * 1e-4;
        let motions: Vec<Option<Rigid>> = (0..2000).map(|_| Some(moved(DVec3::ZERO, noise()))).collect();
        let size = |motions: &[Option<Rigid>]| -> f64 {
            motions.iter().flatten().map(|motion| motion.translation_m.length_squared()).sum::<f64>().sqrt()
        };
        let ratio = size(&calm_motion(&motions, DVec3::ZERO, 8.0)) / size(&motions);
        assert!((ratio - 0.69 / 8.0_f64.sqrt()).abs() < 0.02, "{ratio}");
    }

    #[test]
    fn motions_within_the_noise_are_none_and_large_ones_stay() {
        let rest = [DVec3::X * 0.05, DVec3::Y * 0.05, DVec3::Z * -0.05];
        let small = moved(DVec3::Z * 1e-4, DVec3::X * 1e-5);
        assert_eq!(shrink_motion(&small, &rest, 1e-4), moved(DVec3::ZERO, DVec3::ZERO));
        assert_eq!(shrink_motion(&small, &rest, 0.0), small);
        let large = moved(DVec3::new(0.3, -0.8, 0.2), DVec3::new(0.01, 0.2, 0.0));
        assert!(apart(&shrink_motion(&large, &rest, 1e-4), &large) < 1e-7);
        let some = moved(DVec3::ZERO, DVec3::X * 2e-4);
        assert!((shrink_motion(&some, &rest, 1e-4).translation_m.x - 1.5e-4).abs() < 1e-12);
    }

    #[test]
    fn few_samples_are_enough() {
        assert_eq!(shares(&[0.0], 4.0), [1.0]);
        assert!((shares(&[-1.0, 0.0, 1.0], 1e-4)[1] - 1.0).abs() < 1e-12);
        for times in [vec![0.0, 1.0], vec![-2.0, 0.0, 1.0], vec![0.0, 1.0, 2.0, 3.0, 4.0, 7.0]] {
            assert!((shares(&times, 4.0).iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }
}
