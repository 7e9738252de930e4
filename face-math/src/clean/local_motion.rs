//! How the skin around one place moves: a local motion fitted to the markers near it. Called by
//! [`fill_gaps`](super::fill_gaps).
//!
//! Moving least squares (Schaefer et al., "Image deformation using moving least squares", SIGGRAPH 2006, section 2): for
//! the place v at rest, neighbours at rest pᵢ and as they are seen qᵢ (metres) with the weights wᵢ = 1 / ‖pᵢ − v‖²
//! (their α = 1) that sum to 1 after scaling,
//!
//! ```text
//! f(v) = M (v − p*) + q*,   p* = Σ wᵢ pᵢ,   q* = Σ wᵢ qᵢ
//! ```
//!
//! Their M is either affine, which a nearly flat patch of skin does not fix, or rigid, which skin that stretches is
//! not. Here it is affine and drawn to the rigid one: with p̂ᵢ = pᵢ − p*, q̂ᵢ = qᵢ − q*, R the rotation that
//! [`fit_rigid`] finds and λ = s tr(Σ wᵢ p̂ᵢ p̂ᵢᵀ) / 3, M minimises Σ wᵢ ‖M p̂ᵢ − q̂ᵢ‖² + λ ‖M − R‖²:
//!
//! ```text
//! M = (Σ wᵢ q̂ᵢ p̂ᵢᵀ + λ R) (Σ wᵢ p̂ᵢ p̂ᵢᵀ + λ I)⁻¹
//! ```
//!
//! Rigid motions are met exactly whatever s is.

use crate::rig::fit_rigid;
use glam::{DMat3, DVec3};

/// s, unitless: how strongly M is drawn to the rigid motion. Known points that were taken out of takes of a whole face
/// came back nearly alike between 0.1 and 1 and best about here; the rigid motion alone was up to a tenth worse.
const STIFFNESS: f64 = 0.3;

/// Neighbours whose spread sideways is less than about 3 % of their length are a line, which leaves a turn free:
/// least share of λ₁λ₂ + λ₂λ₃ + λ₃λ₁ in (λ₁ + λ₂ + λ₃)², λ the eigenvalues of the spread.
const LEAST_SPREAD: f64 = 1e-3;

/// Nearer than this (metres, squared) neighbours count alike, so that one at the very place stays finite.
const NEAREST_M2: f64 = 1e-12;

/// The motion of the skin around one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct LocalMotion {
    /// R.
    pub rotation: DMat3,
    /// f(v): the place, moved (metres).
    pub moved: DVec3,
}

impl LocalMotion {
    /// The motion around `place` that takes the neighbours from `rest` to `seen` (metres); none where they do not fix it:
    /// fewer than three, or all on a line.
    pub fn fit(place: DVec3, rest: &[DVec3], seen: &[DVec3]) -> Option<Self> {
        if rest.len() < 3 {
            return None;
        }
        let mut weights: Vec<f64> =
            rest.iter().map(|point| 1.0 / point.distance_squared(place).max(NEAREST_M2)).collect();
        let total: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= total;
        }
        let middle = |points: &[DVec3]| points.iter().zip(&weights).map(|(point, weight)| *point * *weight).sum();
        let (rest_middle, seen_middle): (DVec3, DVec3) = (middle(rest), middle(seen));
        let (mut spread, mut moved) = (DMat3::ZERO, DMat3::ZERO);
        for ((from, to), weight) in rest.iter().zip(seen).zip(&weights) {
            let (from, to) = (*from - rest_middle, *to - seen_middle);
            spread += outer(from, from) * *weight;
            moved += outer(to, from) * *weight;
        }
        if pairs(&spread) < LEAST_SPREAD * trace(&spread).powi(2) {
            return None;
        }
        // What is left to refuse is refused above, or is the same: points that fix no rotation.
        let rotation = fit_rigid(rest, seen, Some(&weights)).ok()?.motion.rotation;
        let pull = STIFFNESS * trace(&spread) / 3.0;
        let matrix = (moved + rotation * pull) * (spread + DMat3::IDENTITY * pull).inverse();
        Some(Self { rotation, moved: matrix * (place - rest_middle) + seen_middle })
    }
}

/// a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// λ₁λ₂ + λ₂λ₃ + λ₃λ₁ of a symmetric matrix: half of (tr M)² − tr M².
fn pairs(m: &DMat3) -> f64 {
    0.5 * (trace(m).powi(2) - trace(&(*m * *m)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    fn patch() -> Vec<DVec3> {
        let mut dice = Dice(5);
        (0..8).map(|_| dice.point().as_dvec3() * DVec3::new(0.02, 0.02, 0.004)).collect()
    }

    #[test]
    fn rigid_motions_are_met_exactly() {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 2.5);
        let motion = |point: DVec3| turn * point + DVec3::new(0.3, 1.0, -0.2);
        let rest = patch();
        let seen: Vec<_> = rest.iter().map(|point| motion(*point)).collect();
        let place = DVec3::new(0.01, -0.03, 0.005);
        let local = LocalMotion::fit(place, &rest, &seen).unwrap();
        assert!(local.moved.abs_diff_eq(motion(place), 1e-12));
        assert!(local.rotation.abs_diff_eq(turn, 1e-10));
    }

    #[test]
    fn stretched_skin_is_followed_most_of_the_way() {
        let rest = patch();
        let seen: Vec<_> = rest.iter().map(|point| *point * DVec3::new(1.2, 1.0, 1.0)).collect();
        let place = DVec3::new(0.03, 0.0, 0.0);
        let found = LocalMotion::fit(place, &rest, &seen).unwrap().moved;
        assert!((found.x - 0.036).abs() < 0.003 && found.y.abs() < 1e-3, "{found}");
    }

    #[test]
    fn a_neighbour_at_the_very_place_decides() {
        let rest = patch();
        let seen: Vec<_> = rest.iter().map(|point| *point * 1.3 + DVec3::X).collect();
        let found = LocalMotion::fit(rest[3], &rest, &seen).unwrap().moved;
        assert!(found.abs_diff_eq(seen[3], 1e-7), "{found} {}", seen[3]);
    }

    #[test]
    fn too_few_neighbours_and_neighbours_on_a_line_fix_nothing() {
        let rest = patch();
        assert!(LocalMotion::fit(DVec3::ZERO, &rest[..2], &rest[..2]).is_none());
        let line: Vec<_> = (1..6).map(|i| DVec3::new(f64::from(i), 0.01 * f64::from(i % 2), 0.0)).collect();
        assert!(LocalMotion::fit(DVec3::ZERO, &line, &line).is_none());
    }
}
