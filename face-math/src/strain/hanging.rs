//! Skin that hangs between skull and joints: what makes the normal matrix of [`solve_strains`](super::solve_strains()) differ
//! from frame to frame, as a few constant matrices and a few numbers a frame.

use super::matrix::product;
use crate::rig::JawPose;
use faer::Mat;
use glam::DMat3;
use rayon::prelude::*;

/// The sums G with the skin they belong to.
pub(super) struct Hanging {
    /// For each joint, or pair of joints with shared skin, six matrices: xx, yy, zz, xy, xz, yz (the last three doubled).
    pub sums: Vec<(usize, Option<usize>, Vec<Mat<f64>>)>,
}

const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

impl Hanging {
    /// The sums for E (`3 N × S`) on skin of the given weights.
    pub fn new(weights: &[&[f32]], shapes: &Mat<f64>) -> Self {
        let mut sums = Vec::new();
        for (k, own) in weights.iter().enumerate() {
            let own = |vertex: usize| f64::from(own[vertex]);
            sums.extend(Self::of(shapes, |vertex| own(vertex) * (1.0 - own(vertex))).map(|sum| (k, None, sum)));
            for (l, other) in weights.iter().enumerate().skip(k + 1) {
                let both = |vertex: usize| own(vertex) * f64::from(other[vertex]);
                sums.extend(Self::of(shapes, both).map(|sum| (k, Some(l), sum)));
            }
        }
        Self { sums }
    }

    fn of(shapes: &Mat<f64>, weight: impl Fn(usize) -> f64) -> Option<Vec<Mat<f64>>> {
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
        let (weighed, plain) = ([0, 1, 2].map(|axis| rows(axis, true)), [0, 1, 2].map(|axis| rows(axis, false)));
        let sum = |(a, b): &(usize, usize)| {
            let sum = product(weighed[*a].as_ref(), plain[*b].transpose());
            if a == b { sum } else { &sum + sum.transpose() }
        };
        Some(PAIRS.par_iter().map(sum).collect())
    }

    /// The numbers by which the sums count in a frame.
    pub fn factors(&self, poses: &[JawPose]) -> Vec<[f64; 6]> {
        let delta = |joint: usize| poses[joint].rotation - DMat3::IDENTITY;
        let of = |(k, l, _): &(usize, Option<usize>, Vec<Mat<f64>>)| {
            let symmetric = match l {
                None => delta(*k) + delta(*k).transpose(),
                Some(l) => delta(*k).transpose() * delta(*l) + delta(*l).transpose() * delta(*k),
            };
            PAIRS.map(|(a, b)| symmetric.col(b)[a])
        };
        self.sums.iter().map(of).collect()
    }
}
