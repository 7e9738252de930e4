//! Skin that hangs between skull and joints: what makes the normal matrix of [`solve_strains`](super::solve_strains()) differ
//! from frame to frame, as a few constant matrices and a few numbers a frame.

use crate::rig::JawPose;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use glam::DMat3;
use std::ops::Range;

/// For a joint, or a pair of joints with shared skin, six matrices G: xx, yy, zz, xy, xz, yz (the last three doubled).
pub(super) type HangingSums = [Mat<f64>; 6];

const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Joints and pairs of joints that skin hangs on.
pub(super) struct Hanging<'a> {
    weights: &'a [&'a [f32]],
    places: Vec<(usize, Option<usize>)>,
}

impl<'a> Hanging<'a> {
    /// By the weights of the joints' skin, one a vertex.
    pub fn new(weights: &'a [&'a [f32]]) -> Self {
        let mut own = Self { weights, places: Vec::new() };
        let joints = 0..weights.len();
        let places = joints
            .clone()
            .flat_map(|k| std::iter::once((k, None)).chain((k + 1..joints.end).map(move |l| (k, Some(l)))));
        let hangs =
            |place: &(usize, Option<usize>)| (0..weights[place.0].len()).any(|vertex| own.weight(*place, vertex) > 0.0);
        own.places = places.filter(hangs).collect();
        own
    }

    /// `m_k` (1 − `m_k`), or `m_k` `m_l`.
    fn weight(&self, (k, l): (usize, Option<usize>), vertex: usize) -> f64 {
        let own = f64::from(self.weights[k][vertex]);
        own * l.map_or(1.0 - own, |l| f64::from(self.weights[l][vertex]))
    }

    /// The sums over a run of vertices, `shapes` their rows of E.
    pub fn sums(&self, run: &Range<usize>, shapes: MatRef<'_, f64>) -> Vec<HangingSums> {
        self.places.iter().map(|place| self.sums_of(*place, run, shapes)).collect()
    }

    fn sums_of(&self, place: (usize, Option<usize>), run: &Range<usize>, shapes: MatRef<'_, f64>) -> HangingSums {
        let weights = run.clone().map(|vertex| self.weight(place, vertex)).enumerate();
        let chosen: Vec<(usize, f64)> =
            weights.filter(|(_, weight)| *weight > 0.0).map(|(row, weight)| (row, weight.sqrt())).collect();
        let weighed: [Mat<f64>; 3] = std::array::from_fn(|axis| {
            Mat::from_fn(chosen.len(), shapes.ncols(), |at, s| chosen[at].1 * shapes[(3 * chosen[at].0 + axis, s)])
        });
        PAIRS.map(|(a, b)| {
            let mut sum = Mat::<f64>::zeros(shapes.ncols(), shapes.ncols());
            matmul(sum.as_mut(), Accum::Replace, weighed[a].transpose(), weighed[b].as_ref(), 1.0, Par::Seq);
            if a == b { sum } else { &sum + sum.transpose() }
        })
    }

    /// The numbers by which the sums count in a frame.
    pub fn factors(&self, poses: &[JawPose]) -> Vec<[f64; 6]> {
        let delta = |joint: usize| poses[joint].rotation - DMat3::IDENTITY;
        let of = |(k, l): &(usize, Option<usize>)| {
            let symmetric = match l {
                None => delta(*k) + delta(*k).transpose(),
                Some(l) => delta(*k).transpose() * delta(*l) + delta(*l).transpose() * delta(*k),
            };
            PAIRS.map(|(a, b)| symmetric.col(b)[a])
        };
        self.places.iter().map(of).collect()
    }
}
