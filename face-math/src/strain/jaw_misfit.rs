//! How far a jaw is off, as a quadratic form: vertices are summed over once, and steps of
//! [`solve_jaw_pose`](super::solve_jaw_pose()) then cost nothing that grows with them.
//!
//! With Δ = R − I, s the translation (metres), u = (Δ row after row, s) the twelve features of the jaw's pose shapes `S_j`, and
//! g those of the eyes' `E_l`, which are known, a vertex with arm a = rest − pivot and skin weight m is off its rest by
//!
//! ```text
//! M − rest = Σ_l g_l E_l + Σ_j u_j S_j + m ( Δ ( a + Σ_l g_l E_l + Σ_j u_j S_j ) + s ) = Ψ ψ(u, g)
//! ```
//!
//! linear in the monomials ψ = (u, g, Δ ⊗ u, Δ ⊗ g), with a matrix Ψ of the vertex that no frame changes. With d = V − rest, the
//! misfit of a frame is
//!
//! ```text
//! Σ W ‖d − Ψ ψ‖² = Σ W ‖d‖² − 2 ψᵀ p + ψᵀ Q ψ        Q = Σ W Ψᵀ Ψ        p = Σ W Ψᵀ d
//! ```

use super::error::StrainError;
use super::joints::joints;
use super::matrix::{outer, pieces, product};
use super::unpose::PoseShapes;
use crate::data::{Curves, Driver, Meshes, Rig};
use crate::rig::JawPose;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use glam::DVec3;

/// Entries of θ: three angles (radians), three translations over the lever.
pub(super) const ENTRIES: usize = 6;

/// Entries of u: nine of Δ, three of s.
const FEATURES: usize = 12;

/// A jaw's misfit in every frame, ready to be asked at any θ.
pub(super) struct JawMisfit {
    monomials: Monomials,
    pivot: DVec3,
    lever: f64,
    /// g of every frame.
    eyes: Vec<Vec<f64>>,
    quadratic: Mat<f64>,
    /// p, a column a frame.
    linear: Mat<f64>,
    /// Σ W ‖d‖² of each frame.
    squares: Vec<f64>,
    /// Σ W.
    pub weight: f64,
}

/// J(t)ᵀ J(t) and J(t)ᵀ r of one frame.
pub(super) type Normal = ([[f64; ENTRIES]; ENTRIES], [f64; ENTRIES]);

/// A vertex that the jaw moves.
struct Follower {
    vertex: usize,
    weight: f64,
    share: f64,
    arm: DVec3,
    /// `S_j`, then `E_l`.
    shapes: Vec<DVec3>,
}

impl JawMisfit {
    /// The misfit of `rig`'s jaw to `meshes`; `still` holds the poses of the eyes with the jaw at rest, `weights` W.
    ///
    /// # Errors
    /// Where the rig has no jaw, or it moves nothing that weighs.
    pub fn new(rig: &Rig, meshes: &Meshes, still: &Curves, weights: &[f64], lever: f64) -> Result<Self, StrainError> {
        let Some(jaw) = &rig.jaw else { return Err(StrainError::NoJoints { rig: rig.name.clone() }) };
        let pivot = jaw.pivot_m.as_dvec3();
        let pose_shapes = PoseShapes::new(rig, still)?;
        let moving = pose_shapes.moving();
        let mut shapes = vec![vec![DVec3::ZERO; FEATURES + moving.len()]; rig.neutral.len()];
        for (index, shape) in rig.shapes.iter().enumerate() {
            let feature = match shape.driver {
                Driver::Turn { joint: 0, row, column } => Some(3 * row as usize + column as usize),
                _ => match jaw.motions.iter().position(|motion| motion.shape as usize == index) {
                    Some(motion) if motion >= 3 => Some(6 + motion),
                    _ => moving.iter().position(|place| pose_shapes.shapes()[*place] == index).map(|l| FEATURES + l),
                },
            };
            let Some(feature) = feature else { continue };
            for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
                shapes[*vertex as usize][feature] = delta.as_dvec3();
            }
        }
        let eyeballs: Vec<&[f32]> = joints(rig)[1..].iter().map(|joint| joint.skin.weights.as_slice()).collect();
        let followers: Vec<Follower> = shapes
            .into_iter()
            .enumerate()
            .filter(|(vertex, shapes)| {
                let bent = shapes[..FEATURES].iter().any(|shape| *shape != DVec3::ZERO);
                // Skin that rides on an eye tells the eye, not the jaw.
                let rides = eyeballs.iter().any(|eye| eye[*vertex] != 0.0);
                (jaw.weights[*vertex] != 0.0 || bent) && weights[*vertex] > 0.0 && !rides
            })
            .map(|(vertex, shapes)| Follower {
                vertex,
                weight: weights[vertex],
                share: jaw.weights[vertex].into(),
                arm: rig.neutral[vertex].as_dvec3() - pivot,
                shapes,
            })
            .collect();
        if followers.is_empty() {
            return Err(StrainError::NothingRigid { joint: "jaw".to_owned() });
        }
        let monomials = Monomials {
            bent: followers.iter().any(|own| own.shapes[..FEATURES].iter().any(|shape| *shape != DVec3::ZERO)),
            eyes: moving.len(),
        };
        let eyes = (0..meshes.frames())
            .map(|frame| moving.iter().map(|place| f64::from(pose_shapes.weights(frame)[*place])).collect())
            .collect();
        let size = monomials.size();
        let mut misfit = Self {
            monomials,
            pivot,
            lever,
            eyes,
            quadratic: Mat::zeros(size, size),
            linear: Mat::zeros(size, meshes.frames()),
            squares: vec![0.0; meshes.frames()],
            weight: followers.iter().map(|follower| follower.weight).sum(),
        };
        (0..3).for_each(|axis| misfit.sum(axis, rig, meshes, &followers));
        Ok(misfit)
    }

    /// Adds what one coordinate of the vertices says to Q, p and the squares.
    fn sum(&mut self, axis: usize, rig: &Rig, meshes: &Meshes, followers: &[Follower]) {
        let places = self.monomials.of_axis(axis);
        let mut rows = Mat::<f64>::zeros(places.len(), followers.len());
        for (column, follower) in followers.iter().enumerate() {
            let root = follower.weight.sqrt();
            self.monomials.row(axis, follower, |place, value| rows[(place, column)] += root * value);
        }
        let own = outer(rows.as_ref());
        for (i, row) in places.iter().enumerate() {
            for (j, column) in places.iter().enumerate() {
                self.quadratic[(*row, *column)] += own[(i, j)];
            }
        }
        let mut pulled = Mat::<f64>::zeros(places.len(), meshes.frames());
        let off = |frame: usize, follower: &Follower| {
            let (posed, rest) = (meshes.frame(frame)[follower.vertex], rig.neutral[follower.vertex]);
            follower.weight.sqrt() * (f64::from(posed[axis]) - f64::from(rest[axis]))
        };
        pieces(pulled.as_mut(), |first, mut out| {
            let offs = Mat::from_fn(followers.len(), out.ncols(), |at, t| off(first + t, &followers[at]));
            matmul(out.as_mut(), Accum::Replace, rows.as_ref(), offs.as_ref(), 1.0, Par::Seq);
        });
        for frame in 0..meshes.frames() {
            for (i, place) in places.iter().enumerate() {
                self.linear[(*place, frame)] += pulled[(i, frame)];
            }
            self.squares[frame] += followers.iter().map(|follower| off(frame, follower).powi(2)).sum::<f64>();
        }
    }

    fn features(&self, theta: &[f64]) -> ([f64; FEATURES], JawPose) {
        let shift = self.lever * DVec3::new(theta[3], theta[4], theta[5]);
        let pose = JawPose::about(self.pivot, DVec3::new(theta[0], theta[1], theta[2]), shift);
        let features = std::array::from_fn(|at| match at {
            0..9 => pose.rotation.col(at % 3)[at / 3] - f64::from(u8::from(at / 3 == at % 3)),
            _ => shift[at - 9],
        });
        (features, pose)
    }

    /// ∂u/∂θ of one entry of θ.
    fn features_slope(&self, pose: &JawPose, entry: usize) -> [f64; FEATURES] {
        std::array::from_fn(|at| match (entry, at) {
            (0..3, 0..9) => pose.turns[entry].col(at % 3)[at / 3],
            (3.., 9..) if at - 9 == entry - 3 => self.lever,
            _ => 0.0,
        })
    }

    /// Σ W ‖V − M(θ)‖² of every frame, in square metres.
    pub fn squares(&self, theta: &[f64]) -> Vec<f64> {
        let at = self.monomials_at(theta);
        let applied = product(self.quadratic.as_ref(), at.as_ref());
        let of = |t: usize| {
            let bend = |place: usize| at[(place, t)] * (applied[(place, t)] - 2.0 * self.linear[(place, t)]);
            (self.squares[t] + (0..at.nrows()).map(bend).sum::<f64>()).max(0.0)
        };
        (0..at.ncols()).map(of).collect()
    }

    /// `JᵀJ` and Jᵀr of every frame, r = V − M.
    pub fn normal(&self, theta: &[f64]) -> Vec<Normal> {
        let at = self.monomials_at(theta);
        let rest = &self.linear - product(self.quadratic.as_ref(), at.as_ref());
        let mut slopes = Mat::<f64>::zeros(at.nrows(), ENTRIES * at.ncols());
        for t in 0..at.ncols() {
            let (features, pose) = self.features(&theta[ENTRIES * t..]);
            for entry in 0..ENTRIES {
                let slope = self.features_slope(&pose, entry);
                let column = slopes.col_mut(ENTRIES * t + entry);
                self.monomials.slope(&features, &slope, &self.eyes[t], column);
            }
        }
        let applied = product(self.quadratic.as_ref(), slopes.as_ref());
        (0..at.ncols())
            .map(|t| {
                let slope = |entry: usize| slopes.col(ENTRIES * t + entry);
                let block = std::array::from_fn(|i| {
                    std::array::from_fn(|j| slope(i).transpose() * applied.col(ENTRIES * t + j))
                });
                (block, std::array::from_fn(|i| slope(i).transpose() * rest.col(t)))
            })
            .collect()
    }

    /// ψ of every frame.
    fn monomials_at(&self, theta: &[f64]) -> Mat<f64> {
        let mut at = Mat::<f64>::zeros(self.monomials.size(), self.eyes.len());
        for (t, eyes) in self.eyes.iter().enumerate() {
            let (features, _) = self.features(&theta[ENTRIES * t..]);
            self.monomials.values(&features, eyes, at.col_mut(t));
        }
        at
    }
}

/// The order of ψ: u, g, then for each row of Δ its three entries, each times u (where pose shapes bend the skin) and g.
struct Monomials {
    bent: bool,
    eyes: usize,
}

impl Monomials {
    fn size(&self) -> usize {
        FEATURES + self.eyes + 9 * self.factors()
    }

    /// What an entry of Δ is multiplied by: u and g, as places among `S_j` and `E_l`.
    fn multiplied(&self) -> std::ops::Range<usize> {
        if self.bent { 0..FEATURES + self.eyes } else { FEATURES..FEATURES + self.eyes }
    }

    fn factors(&self) -> usize {
        self.multiplied().len()
    }

    /// Places of the monomials that move a vertex along one axis.
    fn of_axis(&self, axis: usize) -> Vec<usize> {
        let alone = FEATURES + self.eyes;
        let first = alone + axis * 3 * self.factors();
        (0..alone).chain(first..first + 3 * self.factors()).collect()
    }

    /// The row of Ψ of a vertex along one axis, in the order of [`Self::of_axis`]; entries are to be added up.
    fn row(&self, axis: usize, follower: &Follower, mut add: impl FnMut(usize, f64)) {
        for (place, shape) in follower.shapes.iter().enumerate() {
            add(place, shape[axis]);
        }
        for column in 0..3 {
            add(3 * axis + column, follower.share * follower.arm[column]);
            let first = FEATURES + self.eyes + column * self.factors();
            for (place, factor) in self.multiplied().enumerate() {
                add(first + place, follower.share * follower.shapes[factor][column]);
            }
        }
        add(9 + axis, follower.share);
    }

    fn values(&self, features: &[f64; FEATURES], eyes: &[f64], mut out: faer::ColMut<'_, f64>) {
        let alone: Vec<f64> = features.iter().chain(eyes).copied().collect();
        let products =
            features[..9].iter().flat_map(|delta| alone[self.multiplied()].iter().map(move |own| delta * own));
        for (place, value) in alone.iter().copied().chain(products).enumerate() {
            out[place] = value;
        }
    }

    /// ∂ψ for ∂u = `slope`.
    fn slope(&self, features: &[f64; FEATURES], slope: &[f64; FEATURES], eyes: &[f64], mut out: faer::ColMut<'_, f64>) {
        let alone: Vec<f64> = features.iter().chain(eyes).copied().collect();
        let turned: Vec<f64> = slope.iter().copied().chain(eyes.iter().map(|_| 0.0)).collect();
        let product = |entry: usize, place: usize| slope[entry] * alone[place] + features[entry] * turned[place];
        let products = (0..9).flat_map(|entry| self.multiplied().map(move |place| product(entry, place)));
        for (place, value) in turned.iter().copied().chain(products).enumerate() {
            out[place] = value;
        }
    }
}

#[cfg(test)]
#[path = "jaw_misfit_tests.rs"]
mod tests;
