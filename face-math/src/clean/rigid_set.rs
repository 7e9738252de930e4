//! Finds the markers that move with the skull alone: those whose distances from one another vary least. For takes whose
//! head markers nobody named; before [`stabilize`](super::stabilize()).
//!
//! The distance dᵢⱼ between two markers of a rigid body never changes. How much it does is told by the spread sᵢⱼ that
//! nine of ten frames stay within, |dᵢⱼ(t) − median dᵢⱼ|, so that a few frames of bad tracking do not decide. What counts
//! is eᵢⱼ = sᵢⱼ / dᵢⱼ: near markers always keep their distance, and tell little of how the head turns.
//!
//! The three markers with the least e between them begin the set, where they are no line; then the marker whose greatest
//! e to the set is least joins, one after the other.

use crate::data::Markers;

/// Frames that are looked at, spread over the take.
const FRAMES: usize = 500;

/// Share of frames within whose spread a distance counts as varying.
const SHARE: f64 = 0.9;

/// The set grows while a newcomer strains at most so many times more than its first four.
const GROWTH: f64 = 1.5;

/// Least height of the first triangle, as a share of its longest side.
const LEAST_HEIGHT: f64 = 0.3;

/// Rigid markers of a take.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidSet {
    /// Their names, in the order of the take.
    pub names: Vec<String>,
    /// Greatest spread of a distance between two of them, in millimetres.
    pub spread_mm: f64,
}

/// Why no rigid markers are found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RigidSetError {
    /// Too few markers are seen together.
    #[error(
        "no three markers of the {markers} are seen together in {needed} frames and off a line; name rigid markers instead"
    )]
    None {
        /// Markers of the take.
        markers: usize,
        /// Frames needed.
        needed: usize,
    },
}

/// Frames in which two markers must be seen together.
const NEEDED_FRAMES: usize = 10;

/// The markers of `take` (metres) that move most rigidly with one another, at most `most` of them and at least three.
///
/// # Errors
/// Where no three markers are seen together often enough.
pub fn find_rigid(take: &Markers, most: usize) -> Result<RigidSet, RigidSetError> {
    let count = take.names().len();
    let step = take.frames().div_ceil(FRAMES).max(1);
    let frames: Vec<usize> = (0..take.frames()).step_by(step).collect();
    // Distance and spread of each pair, in metres.
    let mut pairs = vec![None; count * count];
    let mut distances = Vec::new();
    for a in 0..count {
        for b in a + 1..count {
            distances.clear();
            distances.extend(frames.iter().filter_map(|frame| {
                let points = take.frame(*frame);
                let apart = points[a].as_dvec3().distance(points[b].as_dvec3());
                apart.is_finite().then_some(apart)
            }));
            if distances.len() < NEEDED_FRAMES {
                continue;
            }
            let middle = ranked(&mut distances, 0.5);
            for distance in &mut distances {
                *distance = (*distance - middle).abs();
            }
            let pair = Some((middle, ranked(&mut distances, SHARE)));
            pairs[a * count + b] = pair;
            pairs[b * count + a] = pair;
        }
    }
    let strain = |a: usize, b: usize| {
        pairs[a * count + b].map_or(f64::INFINITY, |(apart, spread): (f64, f64)| spread / apart.max(1e-6))
    };
    let (_, first) =
        seed(count, &pairs, &strain).ok_or(RigidSetError::None { markers: count, needed: NEEDED_FRAMES })?;
    let mut set = first.to_vec();
    let mut limit = f64::INFINITY;
    while set.len() < most.max(3) {
        let worst = |marker: usize| set.iter().map(|other| strain(marker, *other)).fold(0.0, f64::max);
        let newcomers = (0..count).filter(|marker| !set.contains(marker));
        let next = newcomers.map(|marker| (worst(marker), marker)).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((strained, marker)) = next.filter(|(strained, _)| strained.is_finite() && *strained <= limit) else {
            break;
        };
        set.push(marker);
        if set.len() == 4 {
            limit = GROWTH * strained;
        }
    }
    set.sort_unstable();
    let spread = |a: usize, b: usize| pairs[a * count + b].map_or(0.0, |(_, spread)| spread);
    let spread_m = set.iter().flat_map(|a| set.iter().map(move |b| spread(*a, *b))).fold(0.0, f64::max);
    let names = set.iter().map(|marker| take.names()[*marker].clone()).collect();
    Ok(RigidSet { names, spread_mm: 1000.0 * spread_m })
}

/// The three markers with the least strain that are no line, with that strain.
fn seed(
    count: usize,
    pairs: &[Option<(f64, f64)>],
    strain: &impl Fn(usize, usize) -> f64,
) -> Option<(f64, [usize; 3])> {
    let mut best: Option<(f64, [usize; 3])> = None;
    let better = |strained: f64, best: &Option<(f64, [usize; 3])>| best.is_none_or(|(least, _)| strained < least);
    for a in 0..count {
        for b in a + 1..count {
            if !strain(a, b).is_finite() || !better(strain(a, b), &best) {
                continue;
            }
            for c in b + 1..count {
                let strained = strain(a, b).max(strain(a, c)).max(strain(b, c));
                if strained.is_finite() && better(strained, &best) {
                    let sides = [(a, b), (a, c), (b, c)].map(|(a, b)| pairs[a * count + b].map_or(0.0, |pair| pair.0));
                    if height_share(sides) >= LEAST_HEIGHT {
                        best = Some((strained, [a, b, c]));
                    }
                }
            }
        }
    }
    best
}

/// Height of a triangle over its longest side, as a share of that side, by Heron's formula.
fn height_share(sides: [f64; 3]) -> f64 {
    let half = sides.iter().sum::<f64>() / 2.0;
    let square = half * (half - sides[0]) * (half - sides[1]) * (half - sides[2]);
    let longest = sides.into_iter().fold(0.0, f64::max);
    2.0 * square.max(0.0).sqrt() / longest.powi(2).max(f64::MIN_POSITIVE)
}

/// The number that the share `share` of all `numbers` does not exceed.
fn ranked(numbers: &mut [f64], share: f64) -> f64 {
    let place = (share * (numbers.len() - 1) as f64).round() as usize;
    *numbers.select_nth_unstable_by(place, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clean::motion_of;
    use crate::rig::toy::Dice;
    use glam::Vec3;
    use wire::FrameAxis;

    /// Five rigid markers among fifteen that the skin moves, on a head that turns, with noise and bad frames.
    fn take() -> Markers {
        let mut dice = Dice(12);
        let rest: Vec<Vec3> = (0..20).map(|_| dice.point() * 0.1).collect();
        let mut positions = Vec::new();
        for frame in 0..300 {
            let time = frame as f64 / 30.0;
            let motion = motion_of([0.1 * time.sin(), 1.0, 0.05 * time, time.sin(), 0.5 * time.cos(), 0.3 * time]);
            for (column, place) in rest.iter().enumerate() {
                let phase = time as f32 * (1.0 + column as f32 * 0.1);
                let skin = if column % 4 == 0 { Vec3::ZERO } else { Vec3::new(phase.sin(), phase.cos(), 0.0) * 2e-3 };
                let moved = motion.apply((*place + skin).as_dvec3()).as_vec3() + dice.point() * 5e-5;
                positions.push(if frame % 37 == column % 37 { Vec3::NAN } else { moved });
            }
            if frame % 25 == 0 {
                let last = positions.len();
                positions[last - 20] += Vec3::X * 0.05;
            }
        }
        let names = (0..20).map(|index| format!("m{index}")).collect();
        Markers::new(FrameAxis::new(300, 60.0), names, positions).unwrap()
    }

    #[test]
    fn the_rigid_markers_are_found_and_no_others() {
        let found = find_rigid(&take(), 8).unwrap();
        assert_eq!(found.names, ["m0", "m4", "m8", "m12", "m16"]);
        assert!(found.spread_mm < 0.2, "{}", found.spread_mm);
        assert_eq!(find_rigid(&take(), 3).unwrap().names.len(), 3);
    }

    #[test]
    fn a_take_without_three_markers_off_a_line_has_none() {
        let line: Vec<Vec3> = (0..30).flat_map(|_| (0..4).map(|index| Vec3::X * index as f32 * 0.02)).collect();
        let names = (0..4).map(|index| format!("m{index}")).collect();
        let take = Markers::new(FrameAxis::new(30, 60.0), names, line).unwrap();
        assert!(find_rigid(&take, 4).is_err());
    }
}
