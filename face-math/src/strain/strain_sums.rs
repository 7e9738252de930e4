//! All that skin says of strains, summed over in one pass: a run of vertices at a time, so that a run's part of E stays in the cache
//! while normal matrices and right sides are taken from it. Runs are fixed, and added up in their order.

use super::error::StrainError;
use super::hanging::{Hanging, HangingSums};
use super::joints::Poses;
use super::unpose::PoseShapes;
use crate::data::{Curves, DataError, Driver, Meshes, Rig, Shape};
use crate::rig::JawPose;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::ops::Range;

/// The sums over a rig's skin.
pub(super) struct StrainSums {
    /// `EᵀE`.
    pub normal: Mat<f64>,
    /// G, for each place that skin hangs on.
    pub hanging: Vec<HangingSums>,
    /// `Eᵀ Bᵀ (V − M(θ, 0))`, S × T.
    pub right: Mat<f64>,
    /// `‖V − M(θ, 0)‖²` of each frame.
    pub squares: Vec<f64>,
}

impl StrainSums {
    fn add(&mut self, other: Self) {
        self.normal += other.normal;
        self.right += other.right;
        for (own, more) in self.hanging.iter_mut().flatten().zip(other.hanging.into_iter().flatten()) {
            *own += more;
        }
        self.squares.iter_mut().zip(other.squares).for_each(|(own, more)| *own += more);
    }
}

/// A rig beside the meshes that it is held against.
pub(super) struct Skin<'a> {
    rig: &'a Rig,
    meshes: &'a Meshes,
    weights: &'a [&'a [f32]],
    /// The shapes of the strains.
    shapes: Vec<&'a Shape>,
    /// The shapes of the pose, and their weights, P × T.
    bends: Vec<&'a Shape>,
    bent: Mat<f64>,
}

/// Vertices of a run.
const RUN: usize = 512;

impl<'a> Skin<'a> {
    /// # Errors
    /// Where a name is not that of a strain, or the poses are not those of the rig.
    pub fn new(
        rig: &'a Rig,
        meshes: &'a Meshes,
        poses: &Curves,
        names: &[String],
        weights: &'a [&'a [f32]],
    ) -> Result<Self, StrainError> {
        let shape_of = |name: &String| {
            let driven = |channel| rig.shapes.iter().find(|shape| shape.driver == Driver::Channel(channel as u32));
            let missing = || DataError::Missing { what: "shape of strain", name: name.clone(), near: None };
            rig.channel(name).and_then(driven).ok_or_else(missing)
        };
        let shapes = names.iter().map(shape_of).collect::<Result<Vec<_>, _>>()?;
        let pose_shapes = PoseShapes::new(rig, poses)?;
        let bends: Vec<&Shape> = pose_shapes.shapes().iter().map(|shape| &rig.shapes[*shape]).collect();
        let bent = Mat::from_fn(bends.len(), meshes.frames(), |shape, t| f64::from(pose_shapes.weights(t)[shape]));
        Ok(Self { rig, meshes, weights, shapes, bends, bent })
    }

    /// The sums over all vertices.
    pub fn sums(&self, poses: &Poses, hanging: &Hanging<'_>) -> StrainSums {
        let vertices = self.meshes.vertices();
        let firsts: Vec<usize> = (0..vertices).step_by(RUN).collect();
        let runs: Vec<StrainSums> = firsts
            .into_par_iter()
            .map(|first| self.sums_of(first..(first + RUN).min(vertices), poses, hanging))
            .collect();
        let mut runs = runs.into_iter();
        let mut sums = runs.next().unwrap_or_else(|| self.sums_of(0..0, poses, hanging));
        runs.for_each(|run| sums.add(run));
        sums
    }

    fn sums_of(&self, run: Range<usize>, poses: &Poses, hanging: &Hanging<'_>) -> StrainSums {
        let (count, frames) = (self.shapes.len(), self.meshes.frames());
        let (shapes, bends) = (dense(&self.shapes, &run), dense(&self.bends, &run));
        let mut off = Mat::<f64>::zeros(shapes.nrows(), frames);
        matmul(off.as_mut(), Accum::Replace, bends.as_ref(), self.bent.as_ref(), 1.0, Par::Seq);
        let pull = |t: usize| self.pull(poses.frame(t), run.clone(), t, off.col_as_slice_mut(t));
        let squares = (0..frames).map(pull).collect();
        let mut right = Mat::<f64>::zeros(count, frames);
        matmul(right.as_mut(), Accum::Replace, shapes.transpose(), off.as_ref(), 1.0, Par::Seq);
        let mut normal = Mat::<f64>::zeros(count, count);
        matmul(normal.as_mut(), Accum::Replace, shapes.transpose(), shapes.as_ref(), 1.0, Par::Seq);
        StrainSums { normal, hanging: hanging.sums(&run, shapes.as_ref()), right, squares }
    }

    /// ‖V − M(θ, 0)‖² of a frame over a run of vertices, and Bᵀ (V − M(θ, 0)) in place of what pose shapes do to them.
    fn pull(&self, poses: &[JawPose], run: Range<usize>, frame: usize, column: &mut [f64]) -> f64 {
        let turned = |(pose, weights): (&JawPose, &&'a [f32])| {
            (pose.rotation - DMat3::IDENTITY, pose.translation_m, &weights[run.clone()])
        };
        let joints: Vec<(DMat3, DVec3, &[f32])> = poses.iter().zip(self.weights).map(turned).collect();
        let (posed, neutral) = (&self.meshes.frame(frame)[run.clone()], &self.rig.neutral[run.clone()]);
        let mut square = 0.0;
        for (row, bend) in column.chunks_exact_mut(3).enumerate() {
            let rest = neutral[row].as_dvec3() + DVec3::from_slice(bend);
            let mut residual = posed[row].as_dvec3() - rest;
            for (delta, shift, weights) in &joints {
                if weights[row] != 0.0 {
                    residual -= f64::from(weights[row]) * (*delta * rest + *shift);
                }
            }
            square += residual.length_squared();
            let mut back = residual;
            for (delta, _, weights) in &joints {
                if weights[row] != 0.0 {
                    // Δᵀ r, as products with the columns of Δ.
                    back += f64::from(weights[row])
                        * DVec3::from_array(delta.to_cols_array_2d().map(|own| DVec3::from_array(own).dot(residual)));
                }
            }
            bend.copy_from_slice(&back.to_array());
        }
        square
    }
}

/// What shapes do to a run of vertices at weight 1: a column a shape, metres.
fn dense(shapes: &[&Shape], run: &Range<usize>) -> Mat<f64> {
    let mut out = Mat::<f64>::zeros(3 * run.len(), shapes.len());
    for (shape, column) in shapes.iter().zip(out.col_iter_mut()) {
        let first = shape.vertices.partition_point(|vertex| (*vertex as usize) < run.start);
        let mut column = column;
        for (vertex, delta) in shape.vertices[first..].iter().zip(&shape.deltas[first..]) {
            let Some(row) = (*vertex as usize).checked_sub(run.start).filter(|row| *row < run.len()) else { break };
            for axis in 0..3 {
                column[3 * row + axis] = f64::from(delta[axis]);
            }
        }
    }
    out
}
