//! A rigid motion fitted to points of which some may be wrong: a marker that slipped, was mixed up, or sits on skin after
//! all. Called by [`stabilize`](super::stabilize()).
//!
//! With aₖ the points at rest, bₖ where they are seen (metres) and τ the tolerance (metres), the motion is the one of least
//!
//! ```text
//! Σₖ min(‖R aₖ + t − bₖ‖² / τ², 1)
//! ```
//!
//! (MSAC; Torr and Zisserman, "MLESAC", 2000). Every three points propose a motion, or a fixed choice of threes where
//! there are many; the cheapest is refined by least squares on the points within τ, told anew until they stay the same.
//! So two of five points may be wrong, by any distance, and do not count at all.

use crate::rig::{Rigid, fit_rigid};
use glam::DVec3;

/// A rigid motion and the points that it rests on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Steady {
    /// The motion from rest to where the points are seen.
    pub motion: Rigid,
    /// Whether each point counted.
    pub used: Vec<bool>,
    /// Root mean square distance of those that did, in metres.
    pub residual_m: f64,
}

/// Threes that are tried at most: 3 % of wrong picks remain of half the points being wrong after 28.
const MOST_THREES: usize = 84;

/// The motion from `rest` to `seen` (metres, as many); none where no three points agree, or they are on a line.
pub(super) fn steady(rest: &[DVec3], seen: &[DVec3], tolerance_m: f64) -> Option<Steady> {
    let cost = |motion: &Rigid| {
        let apart = |(a, b): (&DVec3, &DVec3)| motion.apply(*a).distance_squared(*b) / tolerance_m.powi(2);
        rest.iter().zip(seen).map(|pair| apart(pair).min(1.0)).sum::<f64>()
    };
    let proposals = threes(rest.len()).into_iter().filter_map(|three| {
        let pick = |points: &[DVec3]| three.map(|index| points[index]);
        Some(fit_rigid(&pick(rest), &pick(seen), None).ok()?.motion)
    });
    let all = fit_rigid(rest, seen, None).ok().map(|fit| fit.motion);
    let best = proposals.chain(all).map(|motion| (cost(&motion), motion)).min_by(|a, b| a.0.total_cmp(&b.0))?.1;
    let within = |motion: &Rigid| -> Vec<bool> {
        rest.iter().zip(seen).map(|(a, b)| motion.apply(*a).distance(*b) <= tolerance_m).collect()
    };
    let mut used = within(&best);
    for _ in 0..10 {
        let weights: Vec<f64> = used.iter().map(|used| f64::from(u8::from(*used))).collect();
        if used.iter().filter(|used| **used).count() < 3 {
            return None;
        }
        let fit = fit_rigid(rest, seen, Some(&weights)).ok()?;
        let now = within(&fit.motion);
        if now == used {
            return Some(Steady { motion: fit.motion, used, residual_m: fit.residual_rms_m });
        }
        used = now;
    }
    // The points at the edge of the tolerance come and go; the last choice is as good as the one before.
    let weights: Vec<f64> = used.iter().map(|used| f64::from(u8::from(*used))).collect();
    let fit = fit_rigid(rest, seen, Some(&weights)).ok()?;
    Some(Steady { motion: fit.motion, used, residual_m: fit.residual_rms_m })
}

/// All threes of `count` points where these are few, else as many as are tried, spread evenly over all of them.
fn threes(count: usize) -> Vec<[usize; 3]> {
    let all = count * count.saturating_sub(1) * count.saturating_sub(2) / 6;
    let each = all.div_ceil(MOST_THREES).max(1);
    let mut order = 0;
    let mut threes = Vec::new();
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                if order % each == 0 {
                    threes.push([a, b, c]);
                }
                order += 1;
            }
        }
    }
    threes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;
    use glam::DMat3;

    fn points(count: usize, seed: u64) -> Vec<DVec3> {
        let mut dice = Dice(seed);
        (0..count).map(|_| dice.point().as_dvec3() * 0.1).collect()
    }

    fn known() -> Rigid {
        let rotation = DMat3::from_axis_angle(DVec3::new(0.2, 1.0, -0.4).normalize(), 0.7);
        Rigid { rotation, translation_m: DVec3::new(0.3, -0.1, 1.2) }
    }

    #[test]
    fn wrong_points_do_not_bend_the_motion_however_far_they_are() {
        for (count, wrong) in [(4, 1), (5, 2), (8, 3), (30, 10)] {
            for far in [0.003, 0.05, 5.0] {
                let rest = points(count, count as u64);
                let mut seen: Vec<_> = rest.iter().map(|point| known().apply(*point)).collect();
                let shifts = points(wrong, 77);
                for (index, shift) in shifts.iter().enumerate() {
                    seen[index * count / wrong.max(1)] += shift.normalize() * far;
                }
                let found = steady(&rest, &seen, 1e-3).unwrap();
                assert!(found.motion.rotation.abs_diff_eq(known().rotation, 1e-9), "{count} {wrong} {far}");
                assert_eq!(found.used.iter().filter(|used| !**used).count(), wrong);
                assert!(found.residual_m < 1e-9);
            }
        }
    }

    #[test]
    fn noise_below_the_tolerance_is_averaged_over_all_points() {
        let rest = points(20, 3);
        let mut dice = Dice(4);
        let seen: Vec<_> = rest.iter().map(|point| known().apply(*point) + dice.point().as_dvec3() * 1e-4).collect();
        let found = steady(&rest, &seen, 1e-3).unwrap();
        let direct = fit_rigid(&rest, &seen, None).unwrap();
        assert!(found.used.iter().all(|used| *used));
        assert_eq!(found.motion, direct.motion);
    }

    #[test]
    fn nothing_is_found_where_no_three_agree() {
        let rest = points(5, 1);
        assert!(steady(&rest[..2], &rest[..2], 1e-3).is_none());
        assert!(steady(&rest, &points(5, 2), 1e-6).is_none());
        assert!(threes(102).len() <= 2 * MOST_THREES && threes(9).len() == 84);
    }
}
