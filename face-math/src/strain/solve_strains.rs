//! From meshes and poses to strains (section B.3 of Animatomy), in time that grows with the number of frames.
//!
//! With M(θ, γ) the rig, V(t) the meshes (metres), AE an autoencoder of plausible strains:
//!
//! ```text
//! L(Γ) = Σ_t ‖V(t) − M(θ(t), γ(t))‖² + α Σ_t ‖γ(t−1) − 2 γ(t) + γ(t+1)‖² + β Σ_t ‖AE(γ(t), θ(t)) − γ(t)‖²
//! ```
//!
//! The first two terms are quadratic, and solved by conjugate gradients (`strain_problem.rs`). With β, their preconditioner serves
//! descent on the whole loss: each step is as long as the loss falls (Armijo's rule), so it never rises.

use super::error::StrainError;
use super::joints::pose_channels;
use super::strain_problem::{StrainProblem, by_frame, dot};
use crate::data::{Curves, Meshes, Rig};
use faer::Mat;

/// The weights of the loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrainSolveOptions {
    /// α in square metres: what a second difference of 1 in a strain costs.
    pub acceleration_m2: f64,
    /// β in square metres: what leaving the manifold by 1 in a strain costs.
    pub manifold_m2: f64,
    /// Added to the diagonal, in square metres: strains that do nothing stay at 0.
    pub ridge_m2: f64,
    /// Steps of descent at most, where there is a manifold.
    pub steps: usize,
}

/// The space of plausible strains.
pub trait Manifold: Sync {
    /// AE(γ, θ) − γ for every frame: γ frame after frame (all strains), θ the pose channels.
    fn residual(&self, strains: &[f64], poses: &[f64]) -> Vec<f64>;
    /// The gradient by γ of Σ u · (AE(γ, θ) − γ), for given u of the size of γ.
    fn pull_back(&self, strains: &[f64], poses: &[f64], by: &[f64]) -> Vec<f64>;
}

/// Solved strains, and what is left of the loss.
#[derive(Debug, Clone, PartialEq)]
pub struct SolvedStrains {
    /// The strains.
    pub strains: Curves,
    /// Root mean square distance of a vertex in each frame, in metres.
    pub residual_m: Vec<f64>,
    /// The loss, from the start to the end, in square metres.
    pub losses_m2: Vec<f64>,
}

/// Names of the strains of a rig: its channels that move no joint and drive a shape each.
///
/// # Errors
/// Where the rig has no joints.
pub fn strain_channels(rig: &Rig) -> Result<Vec<String>, StrainError> {
    let poses = pose_channels(rig)?;
    Ok(rig.channels.iter().filter(|channel| !poses.contains(channel)).cloned().collect())
}

/// Solves the strains of `meshes` at `poses` on a strain rig. `go_on` is asked between steps.
///
/// # Errors
/// Where meshes, poses and rig do not fit, a setting is out of range, or `go_on` says no ([`None`]).
pub fn solve_strains(
    rig: &Rig,
    meshes: &Meshes,
    poses: &Curves,
    options: &StrainSolveOptions,
    manifold: Option<&dyn Manifold>,
    mut go_on: impl FnMut() -> bool,
) -> Result<Option<SolvedStrains>, StrainError> {
    let names = strain_channels(rig)?;
    let problem = StrainProblem::new(rig, meshes, poses, &names, options, manifold.is_some())?;
    let Some(mut strains) = problem.solve(&mut go_on) else { return Ok(None) };
    let mut losses_m2 = vec![problem.quadratic(&strains)];
    if let Some(manifold) = manifold.filter(|_| options.manifold_m2 > 0.0) {
        let pose_names = pose_channels(rig)?;
        let arranged = poses.arrange(&pose_names, None)?;
        let theta: Vec<f64> = arranged.values().iter().map(|value| f64::from(*value)).collect();
        let beta = options.manifold_m2;
        let loss = |strains: &Mat<f64>| {
            let residual = manifold.residual(&by_frame(strains), &theta);
            problem.quadratic(strains) + beta * residual.iter().map(|r| r * r).sum::<f64>()
        };
        let mut now = loss(&strains);
        losses_m2 = vec![now];
        for _ in 0..options.steps {
            if !go_on() {
                return Ok(None);
            }
            let values = by_frame(&strains);
            let residual = manifold.residual(&values, &theta);
            let pulled = manifold.pull_back(&values, &theta, &residual);
            let slope = problem.apply(&strains) - &problem.right
                + Mat::<f64>::from_fn(problem.count, problem.frames, |s, t| beta * pulled[t * problem.count + s]);
            let direction = problem.settle(&slope);
            let fall = dot(&slope, &direction);
            let mut step = 1.0;
            let next = loop {
                let moved = &strains - &direction * faer::Scale(step);
                let own = loss(&moved);
                if own <= now - 1e-4 * 2.0 * step * fall {
                    break Some((moved, own));
                }
                step *= 0.5;
                if step < 1e-6 {
                    break None;
                }
            };
            let Some((moved, own)) = next else { break };
            let gained = now - own;
            (strains, now) = (moved, own);
            losses_m2.push(now);
            if gained < 1e-6 * now {
                break;
            }
        }
    }
    let count = rig.neutral.len().max(1) as f64;
    let residual_m = problem.misfit(&strains).iter().map(|square| (square / count).sqrt()).collect();
    let values = by_frame(&strains).into_iter().map(|value| value as f32).collect();
    Ok(Some(SolvedStrains { strains: Curves::new(meshes.frame_axis(), names, values)?, residual_m, losses_m2 }))
}
