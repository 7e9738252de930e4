//! The jaw from meshes (section B.2 of Animatomy), for a whole take at once.
//!
//! ```text
//! L(Θ) = Σ_t ‖V(t) − M(θ(t), 0)‖²_W + λ Σ_t ‖θ(t−1) − 2 θ(t) + θ(t+1)‖²_ρ
//! ```
//!
//! θ are the jaw's three angles (radians) and three translations (metres, divided by the lever ρ in metres, so that both
//! weigh alike); first and last frames are repeated at the ends. Eyes are known. Gauss and Newton's steps: J(t)ᵀ J(t) of each
//! frame on the diagonal, λ `D2ᵀ D2` beside it, so the matrix is banded and a step takes time that grows with the frames; a
//! step that does not lower L is shortened by damping (Levenberg 1944, Marquardt 1963). Vertices are summed over but once, before
//! the first step: the misfit is a quadratic form of a few monomials of θ.
//!
//! Vertices weigh by W: 1 as in the paper, or less where expressions move them, 1 / (1 + `e_i²` / σ²), `e_i` the root mean square
//! of what strains did to the vertex in training. Lips and cheeks then do not pull the jaw along with a smile.

use super::banded::{Banded, acceleration, acceleration_loss};
use super::error::{StrainError, same};
use super::jaw_misfit::{ENTRIES, JawMisfit, Normal};
use super::joints::{Poses, pose_channels};
use super::skinning::check_meshes;
use crate::data::{Curves, Meshes, Rig};

/// How the jaw is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JawSolveOptions {
    /// λ in square metres (a radian to the fourth power over frames).
    pub acceleration_m2: f64,
    /// ρ: the translation that weighs as much as a radian, in metres.
    pub lever_m: f64,
    /// Steps at most.
    pub steps: usize,
}

impl Default for JawSolveOptions {
    fn default() -> Self {
        Self { acceleration_m2: 0.0, lever_m: 0.1, steps: 30 }
    }
}

/// A solved jaw.
#[derive(Debug, Clone, PartialEq)]
pub struct SolvedJaw {
    /// The poses of all joints: the jaw's solved, the others as given.
    pub poses: Curves,
    /// Root mean square distance that is left over the weighed vertices, in each frame, in metres.
    pub residual_m: Vec<f64>,
    /// L from the start on, in square metres.
    pub losses_m2: Vec<f64>,
}

/// A step that lowers L by a smaller share moves vertices by less than their places are kept to.
const SETTLED: f64 = 1e-10;

/// Solves the jaw of `rig` in every frame of `meshes`. `others` holds the poses of the other joints (at rest where not given),
/// `weights` W, one a vertex.
///
/// # Errors
/// Where meshes and rig do not fit, the rig has no jaw that channels turn and move, or a setting is out of range.
pub fn solve_jaw_pose(
    rig: &Rig,
    meshes: &Meshes,
    others: Option<&Curves>,
    weights: &[f64],
    options: &JawSolveOptions,
    mut go_on: impl FnMut() -> bool,
) -> Result<Option<SolvedJaw>, StrainError> {
    same("vertices of the meshes", rig.neutral.len(), meshes.vertices())?;
    same("weights of the vertices", rig.neutral.len(), weights.len())?;
    check_meshes(meshes)?;
    let frames = meshes.frames();
    if frames == 0 {
        return Err(StrainError::TooFewFrames { found: 0, needed: 1 });
    }
    for (what, value, allowed) in [
        ("the acceleration's weight", options.acceleration_m2, options.acceleration_m2 >= 0.0),
        ("the lever", options.lever_m, options.lever_m > 0.0),
    ] {
        if !(value.is_finite() && allowed) {
            return Err(StrainError::Setting { what, value, wanted: "a positive number" });
        }
    }
    let names = pose_channels(rig)?;
    let six = rig.jaw.as_ref().is_some_and(|jaw| jaw.motions.len() == 6);
    if !six {
        return Err(StrainError::NoJoints { rig: rig.name.clone() });
    }
    let given = match others {
        Some(others) => {
            same("frames of the poses", frames, others.frames())?;
            others.arrange(&names, Some(0.0))?
        }
        None => Curves::new(meshes.frame_axis(), names.clone(), vec![0.0; frames * names.len()])?,
    };
    // The eyes' part of the pose, with the jaw at rest.
    let mut still = given.values().to_vec();
    still.chunks_exact_mut(names.len()).for_each(|row| row[..ENTRIES].fill(0.0));
    let still = Curves::new(meshes.frame_axis(), names.clone(), still)?;
    // Poses are looked at here, so that a channel that is not finite is named.
    Poses::new(rig, &still)?;
    let misfit = JawMisfit::new(rig, meshes, &still, weights, options.lever_m)?;
    let loss = |theta: &[f64]| {
        misfit.squares(theta).iter().sum::<f64>() + options.acceleration_m2 * acceleration_loss(theta, ENTRIES)
    };
    let mut theta = vec![0.0; ENTRIES * frames];
    let mut now = loss(&theta);
    let (mut losses_m2, mut damping) = (vec![now], 0.0);
    for _ in 0..options.steps {
        if !go_on() {
            return Ok(None);
        }
        let normals = misfit.normal(&theta);
        let mut lowered = false;
        for _ in 0..12 {
            let moved = damped_step(&theta, &normals, damping, options.acceleration_m2)?;
            let own = loss(&moved);
            if own <= now {
                lowered = now - own > SETTLED * now;
                (theta, now) = (moved, own);
                damping *= 0.1;
                break;
            }
            damping = if damping == 0.0 { 1e-6 } else { damping * 10.0 };
        }
        losses_m2.push(now);
        if !lowered {
            break;
        }
    }
    let residual_m = misfit.squares(&theta).iter().map(|square| (square / misfit.weight).sqrt()).collect();
    let mut values = given.values().to_vec();
    for (row, own) in values.chunks_exact_mut(names.len()).zip(theta.chunks_exact(ENTRIES)) {
        for place in 0..ENTRIES {
            row[place] = (own[place] * if place < 3 { 1.0 } else { options.lever_m }) as f32;
        }
    }
    Ok(Some(SolvedJaw { poses: Curves::new(meshes.frame_axis(), names, values)?, residual_m, losses_m2 }))
}

/// θ after one damped step.
fn damped_step(theta: &[f64], normals: &[Normal], damping: f64, acceleration_m2: f64) -> Result<Vec<f64>, StrainError> {
    let mut system = Banded::zeros(theta.len(), 3 * ENTRIES - 1);
    let mut right: Vec<f64> = normals.iter().flat_map(|(_, slope)| *slope).collect();
    let diagonal = normals.iter().flat_map(|(block, _)| (0..ENTRIES).map(|i| block[i][i]));
    let largest = diagonal.fold(f64::MIN_POSITIVE, f64::max);
    for (t, (block, _)) in normals.iter().enumerate() {
        for (i, row) in block.iter().enumerate() {
            for (j, entry) in row[..i].iter().enumerate() {
                system.add(ENTRIES * t + i, ENTRIES * t + j, *entry);
            }
            system.add(ENTRIES * t + i, ENTRIES * t + i, row[i] * (1.0 + damping) + 1e-12 * largest);
        }
    }
    acceleration(normals.len(), |a, b, factor| {
        for i in 0..ENTRIES {
            system.add(ENTRIES * a + i, ENTRIES * b + i, acceleration_m2 * factor);
            right[ENTRIES * a + i] -= acceleration_m2 * factor * theta[ENTRIES * b + i];
            if a != b {
                right[ENTRIES * b + i] -= acceleration_m2 * factor * theta[ENTRIES * a + i];
            }
        }
    });
    system.factored()?.solve(&mut right);
    Ok(theta.iter().zip(right).map(|(theta, step)| theta + step).collect())
}

#[cfg(test)]
#[path = "solve_jaw_tests.rs"]
mod tests;
