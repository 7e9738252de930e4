//! Joints besides the jaw, for the few markers that follow them (lids that ride on an eye): the part of
//! [`MarkerRig`](super::MarkerRig) that most rigs have none of.
//!
//! A joint adds R Y + m (T + c − R c) to a marker, with Y = Σₖ bₖ Mₖ (Nₖ + Σᵢ wᵢ Dᵢₖ) and m = Σₖ bₖ Mₖ as for the jaw.

use super::JawPose;
use crate::data::JawSkin;
use glam::DVec3;

/// One joint, with the markers that follow it.
#[derive(Debug, Clone)]
pub(super) struct Limb {
    /// Its motions and pivot; no weights.
    pub skin: JawSkin,
    markers: Vec<u32>,
    shares: Vec<f64>,
    rest: Vec<DVec3>,
    /// For each shape, what it adds to Y of which of the markers.
    terms: Vec<Vec<(u32, DVec3)>>,
}

/// A joint in one pose.
#[derive(Debug, Clone, Default)]
pub(super) struct LimbPose {
    pose: JawPose,
    followers: Vec<DVec3>,
}

impl Limb {
    /// From dense tables: for each marker its share and Y at rest, for each shape what it adds to which marker.
    pub fn new(skin: JawSkin, shares: &[f64], rest: &[DVec3], terms: &[Vec<(u32, DVec3)>]) -> Self {
        let markers: Vec<u32> = (0..shares.len() as u32).filter(|marker| shares[*marker as usize] != 0.0).collect();
        let local = |marker: u32| markers.binary_search(&marker).ok().map(|place| place as u32);
        let terms = terms
            .iter()
            .map(|terms| terms.iter().filter_map(|(marker, term)| Some((local(*marker)?, *term))).collect::<Vec<_>>());
        Self {
            skin,
            shares: markers.iter().map(|marker| shares[*marker as usize]).collect(),
            rest: markers.iter().map(|marker| rest[*marker as usize]).collect(),
            terms: terms.collect(),
            markers,
        }
    }

    /// Adds what the joint does to the markers.
    pub fn pose(&self, shape_weights: &[f64], own: &mut LimbPose, positions: &mut [DVec3]) {
        own.followers.clear();
        own.followers.extend_from_slice(&self.rest);
        for (terms, weight) in self.terms.iter().zip(shape_weights) {
            for (marker, term) in terms {
                own.followers[*marker as usize] += *weight * *term;
            }
        }
        own.pose = JawPose::at(&self.skin, shape_weights);
        for ((marker, follower), share) in self.markers.iter().zip(&own.followers).zip(&self.shares) {
            positions[*marker as usize] += own.pose.rotation * *follower + *share * own.pose.translation_m;
        }
    }

    /// Adds the joint's part of Jᵀ f to the gradient by the shape weights.
    pub fn pull_back(&self, own: &LimbPose, forces: &[DVec3], shape_gradient: &mut [f64]) {
        for (terms, gradient) in self.terms.iter().zip(shape_gradient.iter_mut()) {
            let along = |(marker, term): &(u32, DVec3)| {
                forces[self.markers[*marker as usize] as usize].dot(own.pose.rotation * *term)
            };
            *gradient += terms.iter().map(along).sum::<f64>();
        }
        let (mut turning, mut pushing) = (DVec3::ZERO, DVec3::ZERO);
        let pivot = self.skin.pivot_m.as_dvec3();
        for ((marker, follower), share) in self.markers.iter().zip(&own.followers).zip(&self.shares) {
            let force = forces[*marker as usize];
            for axis in 0..3 {
                turning[axis] += force.dot(own.pose.turns[axis] * (*follower - *share * pivot));
            }
            pushing += *share * force;
        }
        for motion in &self.skin.motions {
            shape_gradient[motion.shape as usize] +=
                turning.dot(motion.euler_rad.as_dvec3()) + pushing.dot(motion.translation_m.as_dvec3());
        }
    }

    /// Calls `each(shape, marker, ∂x/∂w)` for all that moves with a shape's weight through this joint.
    pub fn slopes(&self, own: &LimbPose, mut each: impl FnMut(usize, usize, DVec3)) {
        for (shape, terms) in self.terms.iter().enumerate() {
            for (marker, term) in terms {
                each(shape, self.markers[*marker as usize] as usize, own.pose.rotation * *term);
            }
        }
        let pivot = self.skin.pivot_m.as_dvec3();
        for motion in &self.skin.motions {
            let angles = motion.euler_rad.as_dvec3();
            let turn = own.pose.turns[0] * angles.x + own.pose.turns[1] * angles.y + own.pose.turns[2] * angles.z;
            let translation = motion.translation_m.as_dvec3();
            for ((marker, follower), share) in self.markers.iter().zip(&own.followers).zip(&self.shares) {
                let slope = turn * (*follower - *share * pivot) + *share * translation;
                each(motion.shape as usize, *marker as usize, slope);
            }
        }
    }
}
