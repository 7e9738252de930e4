//! From meshes and poses to strains (section B.3 of Animatomy), in time that grows with the number of frames.
//!
//! With M(θ, γ) the rig, V(t) the meshes (metres), AE an autoencoder of plausible strains:
//!
//! ```text
//! L(Γ) = Σ_t ‖V(t) − M(θ(t), γ(t))‖² + α Σ_t ‖γ(t−1) − 2 γ(t) + γ(t+1)‖² + β Σ_t ‖AE(γ(t), θ(t)) − γ(t)‖²
//! ```
//!
//! M is linear in γ: vertex i is at `B_i` (x_i + E_i γ) + b_i, with B_i = I + `Σ_k` `m_ik` Δ_k, Δ_k = R_k − I. As R is a rotation,
//! Δᵀ Δ = −(Δ + Δᵀ), so
//!
//! ```text
//! Σ_i E_iᵀ B_iᵀ B_i E_i = EᵀE + Σ_k Σ_ab (Δ_k + Δ_kᵀ)_ab G_k,ab + Σ_{k<l} Σ_ab (Δ_kᵀ Δ_l + Δ_lᵀ Δ_k)_ab G_kl,ab
//! G_k,ab = Σ_i m_ik (1 − m_ik) E_i,aᵀ E_i,b        G_kl,ab = Σ_i m_ik m_il E_i,aᵀ E_i,b
//! ```
//!
//! The S × S matrices G are made once; a frame's matrix is a sum of a few of them. Only skin that hangs between skull and
//! joint makes it differ from EᵀE, and only little. EᵀE = Q Λ Qᵀ makes the rest fall apart into S systems over time of five
//! diagonals, Λ_s + β + α `D2ᵀ D2`; they precondition conjugate gradients (Hestenes and Stiefel 1952) for the whole, which
//! take a handful of steps. With β, the same systems precondition descent on the whole loss: each step is as long as the loss
//! falls (Armijo's rule), so it never rises.

use super::banded::{Banded, Factor, acceleration, acceleration_loss};
use super::error::{StrainError, same};
use super::joints::{Poses, joints, pose_channels};
use super::matrix::{outer, pieces, product};
use super::skinning::check_meshes;
use super::unpose::{PoseShapes, blend};
use crate::data::{Curves, Driver, Meshes, Rig};
use crate::rig::JawPose;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Side};
use glam::{DMat3, Vec3};
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
        let own = rig.channel(name).and_then(|channel| {
            rig.shapes.iter().find(|shape| shape.driver == Driver::Channel(channel as u32))
        });
        let own = own.ok_or_else(|| crate::data::DataError::Missing { what: "shape of strain", name: name.clone(), near: None })?;
        for (vertex, delta) in own.vertices.iter().zip(&own.deltas) {
            for axis in 0..3 {
                shapes[(3 * *vertex as usize + axis, column)] = f64::from(delta[axis]);
            }
        }
    }
    Ok(shapes)
}

/// The sums G with the skin they belong to.
struct Hanging {
    /// For each joint, or pair of joints with shared skin, six matrices: xx, yy, zz, xy, xz, yz (the last three doubled).
    sums: Vec<(usize, Option<usize>, [Mat<f64>; 6])>,
}

const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

impl Hanging {
    fn new(weights: &[&[f32]], shapes: &Mat<f64>) -> Self {
        let mut sums = Vec::new();
        for k in 0..weights.len() {
            let own = |vertex: usize| f64::from(weights[k][vertex]);
            sums.extend(Self::of(shapes, |vertex| own(vertex) * (1.0 - own(vertex))).map(|sum| (k, None, sum)));
            for l in k + 1..weights.len() {
                let both = |vertex: usize| own(vertex) * f64::from(weights[l][vertex]);
                sums.extend(Self::of(shapes, both).map(|sum| (k, Some(l), sum)));
            }
        }
        Self { sums }
    }

    fn of(shapes: &Mat<f64>, weight: impl Fn(usize) -> f64) -> Option<[Mat<f64>; 6]> {
        let count = shapes.nrows() / 3;
        let chosen: Vec<usize> = (0..count).filter(|vertex| weight(*vertex) != 0.0).collect();
        if chosen.is_empty() {
            return None;
        }
        let rows = |axis: usize, weighed: bool| {
            Mat::<f64>::from_fn(shapes.ncols(), chosen.len(), |s, at| {
                shapes[(3 * chosen[at] + axis, s)] * if weighed { weight(chosen[at]) } else { 1.0 }
            })
        };
        Some(PAIRS.map(|(a, b)| {
            let sum = product(rows(a, true).as_ref(), rows(b, false).transpose());
            if a == b { sum } else { &sum + sum.transpose() }
        }))
    }

    /// The numbers by which the sums count in a frame.
    fn factors(&self, poses: &[JawPose]) -> Vec<[f64; 6]> {
        let delta = |joint: usize| poses[joint].rotation - DMat3::IDENTITY;
        let of = |(k, l, _): &(usize, Option<usize>, [Mat<f64>; 6])| {
            let symmetric = match l {
                None => delta(*k) + delta(*k).transpose(),
                Some(l) => delta(*k).transpose() * delta(*l) + delta(*l).transpose() * delta(*k),
            };
            PAIRS.map(|(a, b)| symmetric.col(b)[a])
        };
        self.sums.iter().map(of).collect()
    }
}

/// The quadratic part of the loss, made ready.
struct Problem {
    count: usize,
    frames: usize,
    normal: Mat<f64>,
    hanging: Hanging,
    factors: Vec<Vec<[f64; 6]>>,
    /// Σ_i E_iᵀ B_iᵀ (V − M(θ, 0)), S × T.
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

    /// Σ_i E_iᵀ B_iᵀ B_i E_i γ for every frame.
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
        let goal = 1e-22 * size;
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
    let settings =
        [("the acceleration's weight", options.acceleration_m2), ("the manifold's weight", options.manifold_m2), ("the ridge", options.ridge_m2)];
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
    let (mut right, mut squares) = (Mat::<f64>::zeros(count, frames), Vec::with_capacity(frames));
    for first in (0..frames).step_by(64) {
        let last = (first + 64).min(frames);
        let columns: Vec<(Vec<f64>, f64)> =
            (first..last).into_par_iter().map(|frame| pulled(rig, meshes, &weights, &pose_shapes, &at, frame)).collect();
        let pulled = Mat::<f64>::from_fn(shapes.nrows(), last - first, |row, t| columns[t].0[row]);
        let own = product(shapes.transpose(), pulled.as_ref());
        right.subcols_mut(first, last - first).copy_from(&own);
        squares.extend(columns.iter().map(|(_, square)| square));
    }
    let eigen = normal.self_adjoint_eigen(Side::Lower).map_err(|_| StrainError::Decomposition { what: "the expression shapes" })?;
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
fn pulled(rig: &Rig, meshes: &Meshes, weights: &[&[f32]], shapes: &PoseShapes, at: &Poses, frame: usize) -> (Vec<f64>, f64) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;

    const OPTIONS: StrainSolveOptions =
        StrainSolveOptions { acceleration_m2: 0.0, manifold_m2: 0.0, ridge_m2: 0.0, steps: 30 };

    fn case() -> (Rig, Curves, Curves, Meshes) {
        let rig = toy::with_shapes(&toy::jointed_head(), 5, 0.01);
        let (poses, strains) = (toy::pose_curves(&rig, 12), toy::values(&rig.channels[9..], 12, 0.5, 6));
        let meshes = toy::evaluated(&rig, &toy::beside(&poses, &strains));
        (rig, poses, strains, meshes)
    }

    /// L by the rig itself, with no algebra.
    fn loss(rig: &Rig, poses: &Curves, meshes: &Meshes, strains: &Curves, options: &StrainSolveOptions) -> f64 {
        let own = toy::evaluated(rig, &toy::beside(poses, strains));
        let data: f64 = own.positions().iter().zip(meshes.positions()).map(|(a, b)| a.as_dvec3().distance_squared(b.as_dvec3())).sum();
        let values: Vec<f64> = strains.values().iter().map(|value| f64::from(*value)).collect();
        data + options.acceleration_m2 * acceleration_loss(&values, strains.channels().len())
            + options.ridge_m2 * values.iter().map(|value| value * value).sum::<f64>()
    }

    #[test]
    fn strains_that_drove_meshes_are_found_again() {
        let (rig, poses, strains, meshes) = case();
        let solved = solve_strains(&rig, &meshes, &poses, &OPTIONS, None, || true).unwrap().unwrap();
        assert_eq!(solved.strains.channels(), strains.channels());
        for (a, b) in solved.strains.values().iter().zip(strains.values()) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
        assert!(solved.residual_m.iter().all(|residual| *residual < 1e-7));
        assert!(solve_strains(&rig, &meshes, &poses, &OPTIONS, None, || false).unwrap().is_none());
    }

    /// By finite differences of the loss as the rig itself gives it: its slope is nought at the answer.
    #[test]
    fn the_slope_of_the_whole_loss_is_nought() {
        let (rig, poses, strains, meshes) = case();
        let noisy = meshes.positions().iter().enumerate().map(|(at, point)| *point + Vec3::splat(((at * 7) % 11) as f32 * 1e-4));
        let meshes = Meshes::new(meshes.frame_axis(), meshes.parts().to_vec(), 96, noisy.collect()).unwrap();
        let options = StrainSolveOptions { acceleration_m2: 1e-3, ridge_m2: 1e-5, ..OPTIONS };
        let solved = solve_strains(&rig, &meshes, &poses, &options, None, || true).unwrap().unwrap().strains;
        let scale = loss(&rig, &poses, &meshes, &strains, &options);
        for at in 0..solved.values().len() {
            let moved = |by: f32| {
                let mut values = solved.values().to_vec();
                values[at] += by;
                let moved = Curves::new(solved.frame_axis(), solved.channels().to_vec(), values).unwrap();
                loss(&rig, &poses, &meshes, &moved, &options)
            };
            let (up, down) = (moved(0.02), moved(-0.02));
            let curve = up + down - 2.0 * moved(0.0);
            assert!((up - down).abs() < 2e-3 * curve.abs() + 1e-9 * scale, "{at}: {up} {down}");
        }
    }

    /// A manifold that wants every strain to be a tenth of a sine of itself.
    struct Sines;

    impl Manifold for Sines {
        fn residual(&self, strains: &[f64], _: &[f64]) -> Vec<f64> {
            strains.iter().map(|strain| 0.1 * (3.0 * strain).sin() - strain).collect()
        }

        fn pull_back(&self, strains: &[f64], _: &[f64], by: &[f64]) -> Vec<f64> {
            strains.iter().zip(by).map(|(strain, by)| by * (0.3 * (3.0 * strain).cos() - 1.0)).collect()
        }
    }

    #[test]
    fn with_a_manifold_the_loss_falls_to_where_its_slope_is_nought() {
        let (rig, poses, _, meshes) = case();
        let options = StrainSolveOptions { manifold_m2: 2e-3, acceleration_m2: 1e-4, steps: 200, ..OPTIONS };
        let solved = solve_strains(&rig, &meshes, &poses, &options, Some(&Sines), || true).unwrap().unwrap();
        assert!(solved.losses_m2.windows(2).all(|pair| pair[1] < pair[0]) && solved.losses_m2.len() > 2);
        let free = solve_strains(&rig, &meshes, &poses, &OPTIONS, None, || true).unwrap().unwrap();
        let size = |curves: &Curves| curves.values().iter().map(|value| value.abs()).sum::<f32>();
        assert!(size(&solved.strains) < 0.95 * size(&free.strains));
        let off = StrainSolveOptions { manifold_m2: f64::NAN, ..options };
        assert!(solve_strains(&rig, &meshes, &poses, &off, Some(&Sines), || true).is_err());
    }
}
