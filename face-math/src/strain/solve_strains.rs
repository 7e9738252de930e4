//! From meshes and poses to strains (section B.3 of Animatomy), in time that grows with the number of frames.
//!
//! With M(θ, γ) the rig, V(t) the meshes (metres), AE an autoencoder of plausible strains:
//!
//! ```text
//! L(Γ) = Σ_t ‖V(t) − M(θ(t), γ(t))‖² + α Σ_t ‖γ(t−1) − 2 γ(t) + γ(t+1)‖² + β Σ_t ‖AE(γ(t), θ(t)) − γ(t)‖²
//! ```
//!
//! M is linear in γ: vertex i is at `B_i` (`x_i` + `E_i` γ) + `b_i`, with `B_i` = I + `Σ_k` `m_ik` `Δ_k`, `Δ_k` = `R_k` − I. As R is a rotation,
//! Δᵀ Δ = −(Δ + Δᵀ), so
//!
//! ```text
//! Σ_i E_iᵀ B_iᵀ B_i E_i = EᵀE + Σ_k Σ_ab (Δ_k + Δ_kᵀ)_ab G_k,ab + Σ_{k<l} Σ_ab (Δ_kᵀ Δ_l + Δ_lᵀ Δ_k)_ab G_kl,ab
//! G_k,ab = Σ_i m_ik (1 − m_ik) E_i,aᵀ E_i,b        G_kl,ab = Σ_i m_ik m_il E_i,aᵀ E_i,b
//! ```
//!
//! The S × S matrices G are made once; a frame's matrix is a sum of a few of them. Only skin that hangs between skull and
//! joint makes it differ from `EᵀE`, and only little. `EᵀE` = Q Λ Qᵀ makes the rest fall apart into S systems over time of five
//! diagonals, `Λ_s` + β + α `D2ᵀ D2`; they precondition conjugate gradients (Hestenes and Stiefel 1952) for the whole, which
//! take a handful of steps. With β, the same systems precondition descent on the whole loss: each step is as long as the loss
//! falls (Armijo's rule), so it never rises.

use super::banded::{Banded, Factor, acceleration, acceleration_loss};
use super::error::{StrainError, same};
use super::hanging::Hanging;
use super::joints::{Poses, joints, pose_channels};
use super::matrix::{outer, pieces, product};
use super::skinning::check_meshes;
use super::unpose::{PoseShapes, blend};
use crate::data::{Curves, Driver, Meshes, Rig};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Side};
use glam::Vec3;
use rayon::prelude::*;

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

/// E as `3 N × S`.
fn expression_matrix(rig: &Rig, names: &[String]) -> Result<Mat<f64>, StrainError> {
    let mut shapes = Mat::<f64>::zeros(3 * rig.neutral.len(), names.len());
    for (column, name) in names.iter().enumerate() {
        let own = rig
            .channel(name)
            .and_then(|channel| rig.shapes.iter().find(|shape| shape.driver == Driver::Channel(channel as u32)));
        let own = own.ok_or_else(|| crate::data::DataError::Missing {
            what: "shape of strain",
            name: name.clone(),
            near: None,
        })?;
        for (vertex, delta) in own.vertices.iter().zip(&own.deltas) {
            for axis in 0..3 {
                shapes[(3 * *vertex as usize + axis, column)] = f64::from(delta[axis]);
            }
        }
    }
    Ok(shapes)
}

/// The quadratic part of the loss, made ready.
struct Problem {
    count: usize,
    frames: usize,
    normal: Mat<f64>,
    hanging: Hanging,
    factors: Vec<Vec<[f64; 6]>>,
    /// `Σ_i` `E_iᵀ` `B_iᵀ` (V − M(θ, 0)), S × T.
    right: Mat<f64>,
    /// ‖V − M(θ, 0)‖² of each frame.
    squares: Vec<f64>,
    acceleration: f64,
    ridge: f64,
    vectors: Mat<f64>,
    systems: Vec<Factor>,
}

impl Problem {
    /// H Γ, Γ of S × T.
    fn apply(&self, strains: &Mat<f64>) -> Mat<f64> {
        let mut out = self.data_term(strains);
        let mut add = |t: usize, s: usize, factor: f64| {
            for row in 0..self.count {
                out[(row, t)] += self.acceleration * factor * strains[(row, s)];
                if t != s {
                    out[(row, s)] += self.acceleration * factor * strains[(row, t)];
                }
            }
        };
        if self.acceleration > 0.0 {
            acceleration(self.frames, &mut add);
        }
        out + strains * faer::Scale(self.ridge)
    }

    /// `Σ_i` `E_iᵀ` `B_iᵀ` `B_i` `E_i` γ for every frame.
    fn data_term(&self, strains: &Mat<f64>) -> Mat<f64> {
        let mut out = product(self.normal.as_ref(), strains.as_ref());
        pieces(out.as_mut(), |first, mut out| {
            let own = strains.subcols(first, out.ncols());
            for (place, (.., sums)) in self.hanging.sums.iter().enumerate() {
                for (pair, sum) in sums.iter().enumerate() {
                    let scaled = Mat::<f64>::from_fn(self.count, out.ncols(), |row, t| {
                        self.factors[first + t][place][pair] * own[(row, t)]
                    });
                    matmul(out.as_mut(), Accum::Add, sum, scaled.as_ref(), 1.0, Par::Seq);
                }
            }
        });
        out
    }

    /// Σ ‖V − M‖² of each frame.
    fn misfit(&self, strains: &Mat<f64>) -> Vec<f64> {
        let data = self.data_term(strains);
        (0..self.frames)
            .map(|t| {
                let of = |s: usize| strains[(s, t)] * (data[(s, t)] - 2.0 * self.right[(s, t)]);
                (self.squares[t] + (0..self.count).map(of).sum::<f64>()).max(0.0)
            })
            .collect()
    }

    fn quadratic(&self, strains: &Mat<f64>) -> f64 {
        let values = by_frame(strains);
        self.misfit(strains).iter().sum::<f64>()
            + self.acceleration * acceleration_loss(&values, self.count)
            + self.ridge * strains.squared_norm_l2()
    }

    /// The preconditioner: exact but for the skin that hangs between.
    fn settle(&self, right: &Mat<f64>) -> Mat<f64> {
        let turned = product(self.vectors.transpose(), right.as_ref());
        let rows: Vec<Vec<f64>> = (0..self.count)
            .into_par_iter()
            .map(|s| {
                let mut row: Vec<f64> = (0..self.frames).map(|t| turned[(s, t)]).collect();
                self.systems[s].solve(&mut row);
                row
            })
            .collect();
        let solved = Mat::<f64>::from_fn(self.count, self.frames, |s, t| rows[s][t]);
        product(self.vectors.as_ref(), solved.as_ref())
    }

    /// Conjugate gradients to the least of the quadratic part.
    fn solve(&self, mut go_on: impl FnMut() -> bool) -> Option<Mat<f64>> {
        let mut strains = Mat::<f64>::zeros(self.count, self.frames);
        let mut residual = self.right.clone();
        let mut settled = self.settle(&residual);
        let mut direction = settled.clone();
        let mut size = dot(&residual, &settled);
        // Strains are kept in single precision, a few parts in 10⁸.
        let goal = 1e-20 * size;
        for _ in 0..200 {
            if size <= goal || size == 0.0 {
                break;
            }
            if !go_on() {
                return None;
            }
            let applied = self.apply(&direction);
            let step = size / dot(&direction, &applied);
            strains += &direction * faer::Scale(step);
            residual -= &applied * faer::Scale(step);
            settled = self.settle(&residual);
            let next = dot(&residual, &settled);
            direction = &settled + &direction * faer::Scale(next / size);
            size = next;
        }
        Some(strains)
    }
}

fn dot(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.ncols()).map(|j| (0..a.nrows()).map(|i| a[(i, j)] * b[(i, j)]).sum::<f64>()).sum()
}

fn by_frame(strains: &Mat<f64>) -> Vec<f64> {
    (0..strains.ncols()).flat_map(|t| (0..strains.nrows()).map(move |s| strains[(s, t)])).collect()
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
    let problem = prepare(rig, meshes, poses, &names, options, manifold.is_some())?;
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

/// Frames whose targets are pulled back together.
const PIECE: usize = 48;

fn prepare(
    rig: &Rig,
    meshes: &Meshes,
    poses: &Curves,
    names: &[String],
    options: &StrainSolveOptions,
    with_manifold: bool,
) -> Result<Problem, StrainError> {
    same("vertices of the meshes", rig.neutral.len(), meshes.vertices())?;
    same("frames of the poses", meshes.frames(), poses.frames())?;
    check_meshes(meshes)?;
    let settings = [
        ("the acceleration's weight", options.acceleration_m2),
        ("the manifold's weight", options.manifold_m2),
        ("the ridge", options.ridge_m2),
    ];
    for (what, value) in settings {
        if !(value.is_finite() && value >= 0.0) {
            return Err(StrainError::Setting { what, value, wanted: "0 or more" });
        }
    }
    let (count, frames) = (names.len(), meshes.frames());
    if frames == 0 || count == 0 {
        return Err(StrainError::TooFewFrames { found: frames.min(count), needed: 1 });
    }
    let shapes = expression_matrix(rig, names)?;
    let normal = outer(shapes.transpose());
    let weights: Vec<&[f32]> = joints(rig).iter().map(|joint| joint.skin.weights.as_slice()).collect();
    let hanging = Hanging::new(&weights, &shapes);
    let pose_shapes = PoseShapes::new(rig, poses)?;
    let at = Poses::new(rig, poses)?;
    // Bᵀ (V − M(θ, 0)), and its square without Bᵀ, a piece of the frames at a time.
    let firsts: Vec<usize> = (0..frames).step_by(PIECE).collect();
    let parts: Vec<(Mat<f64>, Vec<f64>)> = firsts
        .par_iter()
        .map(|first| {
            let last = (first + PIECE).min(frames);
            let pull = |frame| pulled(rig, meshes, &weights, &pose_shapes, &at, frame);
            let (columns, squares): (Vec<Vec<f64>>, Vec<f64>) = (*first..last).map(pull).unzip();
            let pulled = Mat::<f64>::from_fn(shapes.nrows(), last - first, |row, t| columns[t][row]);
            let mut own = Mat::<f64>::zeros(count, last - first);
            matmul(own.as_mut(), Accum::Replace, shapes.transpose(), pulled.as_ref(), 1.0, Par::Seq);
            (own, squares)
        })
        .collect();
    let (mut right, mut squares) = (Mat::<f64>::zeros(count, frames), Vec::with_capacity(frames));
    for (first, (own, some)) in firsts.iter().zip(parts) {
        right.subcols_mut(*first, own.ncols()).copy_from(&own);
        squares.extend(some);
    }
    let eigen = normal
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| StrainError::Decomposition { what: "the expression shapes" })?;
    let levels = eigen.S().column_vector();
    let largest = levels.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    // Directions that the shapes do not tell apart from rounding are held by a ridge.
    let ridge = options.ridge_m2.max(1e-12 * largest);
    let beta = if with_manifold { options.manifold_m2 } else { 0.0 };
    let system = |s: usize| {
        let mut band = Banded::zeros(frames, 2);
        acceleration(frames, |a, b, factor| band.add(a, b, options.acceleration_m2 * factor));
        (0..frames).for_each(|t| band.add(t, t, levels[s].max(0.0) + ridge + beta));
        band.factored()
    };
    let systems = (0..count).into_par_iter().map(system).collect::<Result<_, _>>()?;
    Ok(Problem {
        count,
        frames,
        factors: (0..frames).map(|frame| hanging.factors(at.frame(frame))).collect(),
        normal,
        hanging,
        right,
        squares,
        acceleration: options.acceleration_m2,
        ridge,
        vectors: eigen.U().to_owned(),
        systems,
    })
}

/// Bᵀ (V − M(θ, 0)) of a frame, and ‖V − M(θ, 0)‖².
fn pulled(
    rig: &Rig,
    meshes: &Meshes,
    weights: &[&[f32]],
    shapes: &PoseShapes,
    at: &Poses,
    frame: usize,
) -> (Vec<f64>, f64) {
    let mut offsets = vec![Vec3::ZERO; rig.neutral.len()];
    shapes.add(rig, frame, &mut offsets);
    let (mut column, mut square) = (Vec::with_capacity(3 * offsets.len()), 0.0);
    for (vertex, posed) in meshes.frame(frame).iter().enumerate() {
        let (matrix, shift) = blend(weights, vertex, at.frame(frame));
        let rest = rig.neutral[vertex].as_dvec3() + offsets[vertex].as_dvec3();
        let residual = posed.as_dvec3() - (matrix * rest + shift);
        square += residual.length_squared();
        column.extend((matrix.transpose() * residual).to_array());
    }
    (column, square)
}
