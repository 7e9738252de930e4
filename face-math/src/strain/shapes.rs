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

use super::error::{StrainError, same};
use super::matrix::{outer, pieces, product};
use faer::linalg::solvers::Llt;
use faer::prelude::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;

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
    let mut strains = measured.clone();
    let mut shapes = expression_shapes(targets, &strains, penalties, options.distance_penalty)?;
    let penalty = |shapes: &Mat<f64>| distance_loss(shapes, penalties, options.distance_penalty * frames as f64);
    let mut losses_m2 = vec![loss(targets, &shapes, &strains, measured, options.prior_m2) + penalty(&shapes)];
    go_on(0, losses_m2[0])?;
    for round in 0..options.rounds {
        strains = refined_strains(targets, &shapes, measured, options.prior_m2)?;
        losses_m2.push(loss(targets, &shapes, &strains, measured, options.prior_m2) + penalty(&shapes));
        shapes = expression_shapes(targets, &strains, penalties, options.distance_penalty)?;
        losses_m2.push(loss(targets, &shapes, &strains, measured, options.prior_m2) + penalty(&shapes));
        go_on(round + 1, losses_m2[losses_m2.len() - 1])?;
    }
    Ok(StrainShapes { shapes, strains, losses_m2 })
}

/// The least ridge of a vertex' system, as a share of its greatest diagonal entry: strains that never differ share alike.
const RIDGE: f64 = 1e-12;

/// E for given Γ.
///
/// # Errors
/// Where a system cannot be solved.
pub fn expression_shapes(
    targets: &Mat<f64>,
    strains: &Mat<f64>,
    penalties: &[f32],
    distance_penalty: f64,
) -> Result<Mat<f64>, StrainError> {
    let (count, frames, vertices) = (strains.nrows(), strains.ncols(), targets.nrows() / 3);
    let gram = product(strains.as_ref(), strains.transpose());
    let largest = (0..count).map(|s| gram[(s, s)]).fold(f64::MIN_POSITIVE, f64::max);
    let right = product(strains.as_ref(), targets.transpose());
    let weight = distance_penalty * frames as f64;
    let columns: Vec<Mat<f64>> = (0..vertices)
        .into_par_iter()
        .map(|vertex| {
            let own = &penalties[vertex * count..(vertex + 1) * count];
            // Skin that never moves has E = 0, whatever the system.
            let moves = (0..3).any(|axis| (0..count).any(|s| right[(s, 3 * vertex + axis)] != 0.0));
            let near: Vec<usize> = (0..count).filter(|s| moves && own[*s].is_finite()).collect();
            let mut system = if near.len() == count {
                gram.clone()
            } else {
                Mat::<f64>::from_fn(near.len(), near.len(), |i, j| gram[(near[i], near[j])])
            };
            for (i, s) in near.iter().enumerate() {
                system[(i, i)] += weight * f64::from(own[*s]).powi(2) + RIDGE * largest;
            }
            let mut solved = Mat::<f64>::from_fn(near.len(), 3, |i, axis| right[(near[i], 3 * vertex + axis)]);
            if !near.is_empty() {
                let factor = Llt::new(system.as_ref(), Side::Lower);
                factor
                    .map_err(|_| StrainError::Decomposition { what: "the strains around a vertex" })?
                    .solve_in_place(&mut solved);
            }
            let mut column = Mat::<f64>::zeros(count, 3);
            for (i, s) in near.iter().enumerate() {
                for axis in 0..3 {
                    column[(*s, axis)] = solved[(i, axis)];
                }
            }
            Ok(column)
        })
        .collect::<Result<_, StrainError>>()?;
    let mut shapes = Mat::<f64>::zeros(3 * vertices, count);
    pieces(shapes.as_mut(), |first, mut out| {
        for strain in 0..out.ncols() {
            for (vertex, column) in columns.iter().enumerate() {
                for axis in 0..3 {
                    out[(3 * vertex + axis, strain)] = column[(first + strain, axis)];
                }
            }
        }
    });
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
    let count = shapes.ncols();
    let mut system = outer(shapes.transpose());
    let largest = (0..count).map(|s| system[(s, s)]).fold(f64::MIN_POSITIVE, f64::max);
    for s in 0..count {
        system[(s, s)] += prior_m2 + RIDGE * largest;
    }
    // Offsets from the measured strains are solved for, so that the ridge too draws towards those.
    let residual = targets - &product(shapes.as_ref(), measured.as_ref());
    let right = product(shapes.transpose(), residual.as_ref());
    let factor = Llt::new(system.as_ref(), Side::Lower);
    let factor = factor.map_err(|_| StrainError::Decomposition { what: "the expression shapes" })?;
    let mut moved = right;
    pieces(moved.as_mut(), |_, out| factor.solve_in_place(out));
    Ok(measured + &moved)
}

/// `Σ ‖Ṽ − E γ‖² + λ Σ ‖γ_p − γ‖²`.
fn loss(targets: &Mat<f64>, shapes: &Mat<f64>, strains: &Mat<f64>, measured: &Mat<f64>, prior_m2: f64) -> f64 {
    (targets - &product(shapes.as_ref(), strains.as_ref())).squared_norm_l2()
        + prior_m2 * (measured - strains).squared_norm_l2()
}

/// `μ T Σ ‖E_s D_s‖²`.
fn distance_loss(shapes: &Mat<f64>, penalties: &[f32], weight: f64) -> f64 {
    let count = shapes.ncols();
    let of = |vertex: usize, strain: usize| {
        let penalty = f64::from(penalties[vertex * count + strain]);
        let square: f64 = (0..3).map(|axis| shapes[(3 * vertex + axis, strain)].powi(2)).sum();
        if penalty.is_finite() { penalty.powi(2) * square } else { 0.0 }
    };
    weight * (0..penalties.len()).map(|at| of(at / count, at % count)).sum::<f64>()
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
        loss(&case.targets, shapes, strains, &case.measured, options.prior_m2)
            + distance_loss(shapes, &case.penalties, options.distance_penalty * 50.0)
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
