//! What strains do to skin: expression shapes E and refined strains Γ in turns (section A.3 of Animatomy).
//!
//! With Ṽ(t) the unposed targets less the rest (metres), γ(t) the strains of S muscles, `γ_p(t)` those measured:
//!
//! ```text
//! L(E, Γ) = Σ_t ( ‖Ṽ(t) − E γ(t)‖² + λ ‖γ_p(t) − γ(t)‖² ) + μ T Σ_s ‖E_s D_s‖²
//! ```
//!
//! Both halves have exact answers. E, for each vertex i with its penalties `D_i` = diag(d_{1,i} … d_{S,i}):
//!
//! ```text
//! (Γ Γᵀ + μ T D_i²) E_iᵀ = Γ Ṽ_iᵀ
//! ```
//!
//! S × S, three right sides. Γ, for each frame with one matrix for all: (Eᵀ E + λ I) γ(t) = `Eᵀ Ṽ(t) + λ γ_p(t)`. As each
//! half takes the loss to its least in one of the two, the loss never rises. A frame at rest (`Ṽ = 0`, `γ_p = 0`) stays at rest.
//!
//! d_{s,i} is the distance of vertex i from the curve s over `falloff_m`; a vertex beyond `reach_m` of a curve is out of its
//! reach for good (an infinite d), which makes shapes small and the systems smaller.

use super::cholesky::Cholesky;
use super::error::{StrainError, same};
use super::matrix::{outer, pieces, product};
use faer::linalg::solvers::Llt;
use faer::prelude::Solve;
use faer::{Mat, Side};
use std::sync::atomic::{AtomicBool, Ordering};

/// How E and Γ are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrainShapeOptions {
    /// Times that E and Γ are found in turns; 0 finds E once, for the strains as they are.
    pub rounds: usize,
    /// λ in square metres: what a strain that differs by 1 from its measured value costs.
    pub prior_m2: f64,
    /// μ, a share: 0 lets every strain move every vertex within reach.
    pub distance_penalty: f64,
}

/// E and Γ, and how the loss fell.
#[derive(Debug, Clone)]
pub struct StrainShapes {
    /// E: `3 N × S`, metres a unit of strain.
    pub shapes: Mat<f64>,
    /// Γ: `S × T`.
    pub strains: Mat<f64>,
    /// L after the first E, and after each half of a round.
    pub losses_m2: Vec<f64>,
}

/// Finds E and Γ for `targets` (Ṽ, `3 N × T`, metres) from measured strains (`γ_p`, `S × T`) and `penalties` (d, `S × N`, not
/// finite where out of reach), vertex after vertex. `go_on` is asked between halves, with the loss so far.
///
/// # Errors
/// Where sizes do not fit, a setting is out of range, or `go_on` says so.
pub fn fit_strain_shapes<E: From<StrainError>>(
    targets: &Mat<f64>,
    measured: &Mat<f64>,
    penalties: &[f32],
    options: &StrainShapeOptions,
    mut go_on: impl FnMut(usize, f64) -> Result<(), E>,
) -> Result<StrainShapes, E> {
    let (strains_count, frames, vertices) = (measured.nrows(), measured.ncols(), targets.nrows() / 3);
    same("frames of the strains", targets.ncols(), frames)?;
    same("penalties of strains on vertices", strains_count * vertices, penalties.len())?;
    if frames == 0 || strains_count == 0 {
        return Err(StrainError::TooFewFrames { found: frames.min(strains_count), needed: 1 }.into());
    }
    for (what, value) in
        [("the weight of measured strains", options.prior_m2), ("the distance penalty", options.distance_penalty)]
    {
        if !(value.is_finite() && value >= 0.0) {
            return Err(StrainError::Setting { what, value, wanted: "0 or more" }.into());
        }
    }
    let turns = Turns { targets, measured, penalties, options, square: targets.squared_norm_l2() };
    let (mut strains, mut shapes) = (Strains::of(measured.clone(), 0.0), turns.shapes(measured)?);
    let mut losses_m2 = vec![turns.loss(shapes.cross, &shapes, &strains)];
    go_on(0, losses_m2[0])?;
    for round in 0..options.rounds {
        let refined = turns.strains(&shapes)?;
        strains = refined.0;
        losses_m2.push(turns.loss(refined.1, &shapes, &strains));
        shapes = turns.shapes(&strains.values)?;
        losses_m2.push(turns.loss(shapes.cross, &shapes, &strains));
        go_on(round + 1, losses_m2[losses_m2.len() - 1])?;
    }
    Ok(StrainShapes { shapes: shapes.transposed.transpose().to_owned(), strains: strains.values, losses_m2 })
}

/// E, transposed (S × `3 N`), and what the loss needs of it.
struct Shapes {
    transposed: Mat<f64>,
    /// `EᵀE`.
    gram: Mat<f64>,
    /// ⟨V, E Γ⟩ for the strains they were found from.
    cross: f64,
    /// `μ T Σ ‖E_s D_s‖²`.
    penalty: f64,
}

/// Γ, and what the loss needs of it.
struct Strains {
    values: Mat<f64>,
    /// Γ Γᵀ.
    gram: Mat<f64>,
    /// `λ Σ ‖γ_p − γ‖²`.
    prior: f64,
}

impl Strains {
    fn of(values: Mat<f64>, prior: f64) -> Self {
        Self { gram: product(values.as_ref(), values.transpose()), values, prior }
    }
}

/// The two halves of a round. `‖V − E Γ‖²` = `‖V‖² − 2 ⟨V, E Γ⟩ + ⟨EᵀE, Γ Γᵀ⟩`, of which each half has all parts at hand.
struct Turns<'a> {
    targets: &'a Mat<f64>,
    measured: &'a Mat<f64>,
    penalties: &'a [f32],
    options: &'a StrainShapeOptions,
    square: f64,
}

impl Turns<'_> {
    fn loss(&self, cross: f64, shapes: &Shapes, strains: &Strains) -> f64 {
        let misfit = self.square - 2.0 * cross + inner(&shapes.gram, &strains.gram);
        misfit.max(0.0) + strains.prior + shapes.penalty
    }

    fn shapes(&self, strains: &Mat<f64>) -> Result<Shapes, StrainError> {
        let gram = product(strains.as_ref(), strains.transpose());
        let pulled = product(strains.as_ref(), self.targets.transpose());
        let weight = self.options.distance_penalty * self.targets.ncols() as f64;
        let transposed = solved_shapes(&gram, &pulled, self.penalties, weight)?;
        Ok(Shapes {
            gram: outer(transposed.as_ref()),
            cross: inner(&pulled, &transposed),
            penalty: distance_loss(&transposed, self.penalties, weight),
            transposed,
        })
    }

    /// Γ, and ⟨V, E Γ⟩.
    fn strains(&self, shapes: &Shapes) -> Result<(Strains, f64), StrainError> {
        let pulled = product(shapes.transposed.as_ref(), self.targets.as_ref());
        let values = solved_strains(&shapes.gram, &pulled, self.measured, self.options.prior_m2)?;
        let (cross, off) = (inner(&pulled, &values), (self.measured - &values).squared_norm_l2());
        Ok((Strains::of(values, self.options.prior_m2 * off), cross))
    }
}

fn inner(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.ncols()).map(|j| (0..a.nrows()).map(|i| a[(i, j)] * b[(i, j)]).sum::<f64>()).sum()
}

/// The least ridge of a system, as a share of its greatest diagonal entry: strains that never differ share alike.
const RIDGE: f64 = 1e-12;

fn ridge(gram: &Mat<f64>) -> f64 {
    RIDGE * (0..gram.nrows()).map(|s| gram[(s, s)]).fold(f64::MIN_POSITIVE, f64::max)
}

/// E (`3 N × S`) for given Γ.
///
/// # Errors
/// Where a system cannot be solved.
pub fn expression_shapes(
    targets: &Mat<f64>,
    strains: &Mat<f64>,
    penalties: &[f32],
    distance_penalty: f64,
) -> Result<Mat<f64>, StrainError> {
    let gram = product(strains.as_ref(), strains.transpose());
    let pulled = product(strains.as_ref(), targets.transpose());
    let weight = distance_penalty * strains.ncols() as f64;
    Ok(solved_shapes(&gram, &pulled, penalties, weight)?.transpose().to_owned())
}

/// Eᵀ from Γ Γᵀ and Γ Vᵀ, a system a vertex.
fn solved_shapes(gram: &Mat<f64>, pulled: &Mat<f64>, penalties: &[f32], weight: f64) -> Result<Mat<f64>, StrainError> {
    let (count, ridge) = (gram.nrows(), ridge(gram));
    let mut shapes = Mat::<f64>::zeros(count, pulled.ncols());
    let failed = AtomicBool::new(false);
    pieces(shapes.as_mut(), |first, mut out| {
        let mut systems = Cholesky::new();
        for here in (0..out.ncols()).step_by(3) {
            let there = first + here;
            let own = &penalties[there / 3 * count..][..count];
            // Skin that never moves has E = 0, whatever the system.
            let moves = (0..3).any(|axis| pulled.col(there + axis).iter().any(|value| *value != 0.0));
            let near: Vec<usize> = (0..count).filter(|s| moves && own[*s].is_finite()).collect();
            let entry = |i: usize, j: usize| {
                let bend = if i == j { weight * f64::from(own[near[i]]).powi(2) + ridge } else { 0.0 };
                gram[(near[j], near[i])] + bend
            };
            let right = |axis: usize, i: usize| pulled[(near[i], there + axis)];
            let solved = systems.solve(near.len(), entry, right, |axis, i, value| out[(near[i], here + axis)] = value);
            if !solved {
                failed.store(true, Ordering::Relaxed);
            }
        }
    });
    if failed.into_inner() {
        return Err(StrainError::Decomposition { what: "the strains around a vertex" });
    }
    Ok(shapes)
}

/// Γ for given E, near the measured strains.
///
/// # Errors
/// Where E says nothing of some strains and λ is 0.
pub fn refined_strains(
    targets: &Mat<f64>,
    shapes: &Mat<f64>,
    measured: &Mat<f64>,
    prior_m2: f64,
) -> Result<Mat<f64>, StrainError> {
    let pulled = product(shapes.transpose(), targets.as_ref());
    solved_strains(&outer(shapes.transpose()), &pulled, measured, prior_m2)
}

/// Γ from `EᵀE` and Eᵀ V; the ridge draws towards the measured strains too.
fn solved_strains(
    gram: &Mat<f64>,
    pulled: &Mat<f64>,
    measured: &Mat<f64>,
    prior_m2: f64,
) -> Result<Mat<f64>, StrainError> {
    let pull = prior_m2 + ridge(gram);
    let mut system = gram.clone();
    (0..gram.nrows()).for_each(|s| system[(s, s)] += pull);
    let factor = Llt::new(system.as_ref(), Side::Lower);
    let factor = factor.map_err(|_| StrainError::Decomposition { what: "the expression shapes" })?;
    let mut values = pulled + measured * faer::Scale(pull);
    pieces(values.as_mut(), |_, out| factor.solve_in_place(out));
    Ok(values)
}

/// `μ T Σ ‖E_s D_s‖²`.
fn distance_loss(transposed: &Mat<f64>, penalties: &[f32], weight: f64) -> f64 {
    let count = transposed.nrows();
    let of = |(vertex, penalties): (usize, &[f32])| -> f64 {
        let square = |s: usize| (0..3).map(|axis| transposed[(s, 3 * vertex + axis)].powi(2)).sum::<f64>();
        let finite = penalties.iter().enumerate().filter(|(_, penalty)| penalty.is_finite());
        finite.map(|(s, penalty)| f64::from(*penalty).powi(2) * square(s)).sum()
    };
    weight * penalties.chunks_exact(count).enumerate().map(of).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy::Dice;

    struct Case {
        targets: Mat<f64>,
        measured: Mat<f64>,
        penalties: Vec<f32>,
    }

    /// 20 vertices, 6 strains, 50 frames, the first at rest; noise that no strain explains.
    fn case() -> Case {
        let mut dice = Dice(51);
        let mut roll = || f64::from(dice.roll());
        let shapes = Mat::from_fn(60, 6, |_, _| roll() * 0.02);
        let measured = Mat::from_fn(6, 50, |_, t| if t == 0 { 0.0 } else { 0.3 * roll() });
        let noise = Mat::from_fn(60, 50, |_, t| if t == 0 { 0.0 } else { 1e-3 * roll() });
        let targets = &shapes * &measured + noise;
        let penalties =
            (0..120).map(|at| if at % 17 == 3 { f32::INFINITY } else { roll().abs() as f32 * 3.0 }).collect();
        Case { targets, measured, penalties }
    }

    fn total(case: &Case, options: &StrainShapeOptions, shapes: &Mat<f64>, strains: &Mat<f64>) -> f64 {
        (&case.targets - shapes * strains).squared_norm_l2()
            + options.prior_m2 * (&case.measured - strains).squared_norm_l2()
            + distance_loss(&shapes.transpose().to_owned(), &case.penalties, options.distance_penalty * 50.0)
    }

    const OPTIONS: StrainShapeOptions = StrainShapeOptions { rounds: 10, prior_m2: 1e-4, distance_penalty: 1e-3 };

    #[test]
    fn the_loss_falls_in_every_half_and_rest_stays_rest() {
        let case = case();
        let go_on = |_, _| Ok::<(), StrainError>(());
        let fitted = fit_strain_shapes(&case.targets, &case.measured, &case.penalties, &OPTIONS, go_on).unwrap();
        assert_eq!(fitted.losses_m2.len(), 21);
        assert!(fitted.losses_m2.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + 1e-12)), "{:?}", fitted.losses_m2);
        assert!(fitted.losses_m2[20] < 0.9 * fitted.losses_m2[0]);
        assert!((0..6).all(|s| fitted.strains[(s, 0)] == 0.0));
        let known = total(&case, &OPTIONS, &fitted.shapes, &fitted.strains);
        assert!((known - fitted.losses_m2[20]).abs() < 1e-12 * known);
    }

    /// The slope by finite differences is nought at each half's answer.
    #[test]
    fn each_half_is_at_its_least() {
        let case = case();
        let shapes =
            expression_shapes(&case.targets, &case.measured, &case.penalties, OPTIONS.distance_penalty).unwrap();
        let least = total(&case, &OPTIONS, &shapes, &case.measured);
        for at in 0..360 {
            let (row, strain) = (at / 6, at % 6);
            if !case.penalties[row / 3 * 6 + strain].is_finite() {
                assert!(shapes[(row, strain)] == 0.0);
                continue;
            }
            let moved = |by: f64| {
                let mut moved = shapes.clone();
                moved[(row, strain)] += by;
                total(&case, &OPTIONS, &moved, &case.measured)
            };
            let slope = (moved(1e-4) - moved(-1e-4)) / 2e-4;
            assert!(slope.abs() < 1e-8, "{row} {strain}: {slope} of {least}");
        }
        let strains = refined_strains(&case.targets, &shapes, &case.measured, OPTIONS.prior_m2).unwrap();
        for at in 0..300 {
            let moved = |by: f64| {
                let mut moved = strains.clone();
                moved[(at / 50, at % 50)] += by;
                total(&case, &OPTIONS, &shapes, &moved)
            };
            let slope = (moved(1e-4) - moved(-1e-4)) / 2e-4;
            assert!(slope.abs() < 1e-8, "{at}: {slope}");
        }
    }

    #[test]
    fn strains_that_explain_all_are_found_without_penalties() {
        let mut case = case();
        case.penalties.fill(0.0);
        let known = expression_shapes(&case.targets, &case.measured, &case.penalties, 0.0).unwrap();
        let exact = product(known.as_ref(), case.measured.as_ref());
        let again = expression_shapes(&exact, &case.measured, &case.penalties, 0.0).unwrap();
        assert!((&again - &known).norm_max() < 1e-10);
        let bad = StrainShapeOptions { prior_m2: -1.0, ..OPTIONS };
        let go_on = |_, _| Ok::<(), StrainError>(());
        assert!(fit_strain_shapes(&case.targets, &case.measured, &case.penalties, &bad, go_on).is_err());
        assert!(fit_strain_shapes(&case.targets, &case.measured, &case.penalties[1..], &OPTIONS, go_on).is_err());
    }
}
