//! The quadratic part of what [`solve_strains`](super::solve_strains()) makes least (section B.3 of Animatomy).
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
//! take a handful of steps.

use super::banded::{Banded, Factor, acceleration, acceleration_loss};
use super::error::{StrainError, same};
use super::hanging::{Hanging, HangingSums};
use super::joints::{Poses, joints};
use super::matrix::{pieces, product};
use super::skinning::check_meshes;
use super::solve_strains::StrainSolveOptions;
use super::strain_sums::{Skin, StrainSums};
use crate::data::{Curves, Meshes, Rig};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Side};
use rayon::prelude::*;

/// The quadratic part of the loss, ready to be solved.
pub(super) struct StrainProblem {
    pub count: usize,
    pub frames: usize,
    normal: Mat<f64>,
    /// G, and by what they count in each frame.
    sums: Vec<HangingSums>,
    factors: Vec<Vec<[f64; 6]>>,
    /// `Σ_i` `E_iᵀ` `B_iᵀ` (V − M(θ, 0)), S × T.
    pub right: Mat<f64>,
    /// ‖V − M(θ, 0)‖² of each frame.
    squares: Vec<f64>,
    acceleration: f64,
    ridge: f64,
    vectors: Mat<f64>,
    systems: Vec<Factor>,
}

impl StrainProblem {
    /// # Errors
    /// Where meshes, poses and rig do not fit, or a setting is out of range.
    pub fn new(
        rig: &Rig,
        meshes: &Meshes,
        poses: &Curves,
        names: &[String],
        options: &StrainSolveOptions,
        with_manifold: bool,
    ) -> Result<Self, StrainError> {
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
        let at = Poses::new(rig, poses)?;
        let weights: Vec<&[f32]> = joints(rig).iter().map(|joint| joint.skin.weights.as_slice()).collect();
        let hanging = Hanging::new(&weights);
        let skin = Skin::new(rig, meshes, poses, names, &weights)?;
        let StrainSums { normal, hanging: sums, right, squares } = skin.sums(&at, &hanging);
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
        Ok(Self {
            count,
            frames,
            factors: (0..frames).map(|frame| hanging.factors(at.frame(frame))).collect(),
            normal,
            sums,
            right,
            squares,
            acceleration: options.acceleration_m2,
            ridge,
            vectors: eigen.U().to_owned(),
            systems,
        })
    }

    /// H Γ, Γ of S × T.
    pub fn apply(&self, strains: &Mat<f64>) -> Mat<f64> {
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
            for (place, sums) in self.sums.iter().enumerate() {
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
    pub fn misfit(&self, strains: &Mat<f64>) -> Vec<f64> {
        let data = self.data_term(strains);
        (0..self.frames)
            .map(|t| {
                let of = |s: usize| strains[(s, t)] * (data[(s, t)] - 2.0 * self.right[(s, t)]);
                (self.squares[t] + (0..self.count).map(of).sum::<f64>()).max(0.0)
            })
            .collect()
    }

    pub fn quadratic(&self, strains: &Mat<f64>) -> f64 {
        let values = by_frame(strains);
        self.misfit(strains).iter().sum::<f64>()
            + self.acceleration * acceleration_loss(&values, self.count)
            + self.ridge * strains.squared_norm_l2()
    }

    /// The preconditioner: exact but for the skin that hangs between.
    pub fn settle(&self, right: &Mat<f64>) -> Mat<f64> {
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
    pub fn solve(&self, mut go_on: impl FnMut() -> bool) -> Option<Mat<f64>> {
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

pub(super) fn dot(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.ncols()).map(|j| (0..a.nrows()).map(|i| a[(i, j)] * b[(i, j)]).sum::<f64>()).sum()
}

/// S × T as curves lie: frame after frame.
pub(super) fn by_frame(strains: &Mat<f64>) -> Vec<f64> {
    (0..strains.ncols()).flat_map(|t| (0..strains.nrows()).map(move |s| strains[(s, t)])).collect()
}
