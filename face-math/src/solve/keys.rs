//! Keys over a solved curve: the change that they make in every frame. `edit_curves` adds it.

use crate::data::KeyCurve;

/// A key whose change is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Position of its frame in the curve.
    pub at: usize,
    /// What is added there, in weights.
    pub by: f64,
    /// Frames over which it fades on either side.
    pub falloff: usize,
    /// How it passes.
    pub curve: KeyCurve,
}

/// What `changes`, in the order of their frames, add to each of `frames` frames, in weights.
///
/// Let o be the change of a key at its frame f and r its falloff, and o′, f′, r′ those of the next one. Where the falloffs meet,
/// f′ − f ≤ r + r′, the change passes from one to the other: d(t) = o + (o′ − o) s((t − f) / (f′ − f)). Elsewhere each fades to
/// nothing by itself: d(t) = o (1 − s(|t − f| / (r + 1))) within its falloff. s(u) is 3u² − 2u³ for smooth keys, u for linear
/// ones, and 0 for those that hold. At f itself d is o.
pub fn layer(changes: &[Change], frames: usize) -> Vec<f64> {
    let mut added = vec![0.0; frames];
    let mut fill = |from: usize, to: usize, change: &dyn Fn(usize) -> f64| {
        let to = to.min(frames);
        for (at, added) in (from.min(to)..).zip(&mut added[from.min(to)..to]) {
            *added = change(at);
        }
    };
    for (index, key) in changes.iter().enumerate() {
        let meets = |other: &&Change| key.at.abs_diff(other.at) <= key.falloff + other.falloff;
        let before = index.checked_sub(1).and_then(|before| changes.get(before)).filter(meets);
        let next = changes.get(index + 1).filter(meets);
        let reach = key.falloff as f64 + 1.0;
        let fade = |at: usize| key.by * (1.0 - passed(key.curve, at.abs_diff(key.at) as f64 / reach));
        if before.is_none() {
            fill(key.at.saturating_sub(key.falloff), key.at, &fade);
        }
        fill(key.at, key.at + 1, &|_| key.by);
        match next {
            Some(next) => {
                let apart = (next.at - key.at) as f64;
                let between = |at: usize| passed(key.curve, (at - key.at) as f64 / apart);
                fill(key.at + 1, next.at, &|at| key.by + (next.by - key.by) * between(at));
            }
            None => fill(key.at + 1, key.at + key.falloff + 1, &fade),
        }
    }
    added
}

/// How much of the way is passed at `u`, 0 to 1.
fn passed(curve: KeyCurve, u: f64) -> f64 {
    match curve {
        KeyCurve::Smooth => u * u * (3.0 - 2.0 * u),
        KeyCurve::Linear => u,
        KeyCurve::Hold => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn key(at: usize, by: f64, falloff: usize, curve: KeyCurve) -> Change {
        Change { at, by, falloff, curve }
    }

    #[test]
    fn a_key_alone_fades_to_both_sides() {
        assert_eq!(layer(&[key(3, 1.0, 1, KeyCurve::Linear)], 6), [0.0, 0.0, 0.5, 1.0, 0.5, 0.0]);
        assert_eq!(layer(&[key(1, 2.0, 2, KeyCurve::Hold)], 6), [2.0, 2.0, 2.0, 2.0, 0.0, 0.0]);
        assert_eq!(layer(&[key(0, 1.0, 0, KeyCurve::Smooth)], 2), [1.0, 0.0]);
    }

    #[test]
    fn neighbours_that_meet_pass_into_one_another() {
        let keys = [key(0, 1.0, 2, KeyCurve::Linear), key(4, 3.0, 2, KeyCurve::Hold)];
        assert_eq!(layer(&keys, 9), [1.0, 1.5, 2.0, 2.5, 3.0, 3.0, 3.0, 0.0, 0.0]);
        let apart = [key(0, 1.0, 1, KeyCurve::Hold), key(4, 3.0, 1, KeyCurve::Hold)];
        assert_eq!(layer(&apart, 6), [1.0, 1.0, 0.0, 3.0, 3.0, 3.0]);
    }

    proptest! {
        /// Whatever the falloffs: each key has its own change at its frame, nothing lies beyond the keys' own changes, and
        /// nothing changes outside of their falloffs.
        #[test]
        fn keys_are_met_and_bound_what_is_between(
            keys in prop::collection::btree_map(0_usize..60, (-1.0..1.0_f64, 0_usize..20, 0_usize..3), 1..6),
        ) {
            let curves = [KeyCurve::Smooth, KeyCurve::Linear, KeyCurve::Hold];
            let keys: Vec<_> = keys.into_iter().map(|(at, (by, falloff, curve))| key(at, by, falloff, curves[curve])).collect();
            let added = layer(&keys, 60);
            let low = keys.iter().map(|key| key.by).fold(0.0, f64::min);
            let high = keys.iter().map(|key| key.by).fold(0.0, f64::max);
            for key in &keys {
                prop_assert_eq!(added[key.at].to_bits(), key.by.to_bits());
            }
            for (at, by) in added.iter().enumerate() {
                prop_assert!((low..=high).contains(by));
                let near = keys.iter().any(|key| at.abs_diff(key.at) <= key.falloff);
                let between = keys.windows(2).any(|pair| {
                    (pair[0].at..=pair[1].at).contains(&at)
                        && pair[1].at - pair[0].at <= pair[0].falloff + pair[1].falloff
                });
                prop_assert!(*by == 0.0 || near || between);
            }
        }
    }
}
