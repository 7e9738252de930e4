//! A rig restricted to the few points that carry markers: g(w) of FDLS, with exact derivatives, in microseconds.
//!
//! A marker sits at x = Σₖ bₖ Sₖ(w) over the three vertices k of its triangle. With skinning (see [`super::Puppet`]) the
//! sum splits into what follows the jaw and what follows the skull:
//!
//! ```text
//! x(w) = R(w) Y(w) + Z(w) + m T(w)
//! Y = Σₖ bₖ Mₖ (Nₖ + Σᵢ wᵢ Dᵢₖ)      Z = Σₖ bₖ (1 − Mₖ) (Nₖ + Σᵢ wᵢ Dᵢₖ)      m = Σₖ bₖ Mₖ
//! ∂x/∂wᵢ = R ∂Y/∂wᵢ + ∂Z/∂wᵢ + m Tᵢ + Σ_axis (∂R/∂θ_axis) Y θᵢ,axis
//! ```
//!
//! Y and Z are linear in the shape weights wᵢ, so per shape and marker two vectors are kept. Metres throughout.

use super::corners::Corners;
use super::limbs::{Limb, LimbPose};
use super::{JawPose, RigError, ShapeDrivers};
use crate::data::{Attachment, Curves, DataError, JawSkin, Markers, Rig};
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// The marker-carrying points of a rig.
#[derive(Debug, Clone)]
pub struct MarkerRig {
    names: Vec<String>,
    channels: Vec<String>,
    drivers: ShapeDrivers,
    rest: Vec<Split>,
    shares: Vec<f64>,
    terms: Vec<Vec<(u32, Split)>>,
    jaw: Option<JawSkin>,
    limbs: Vec<Limb>,
}

/// A vector of a marker, split into what follows the jaw and what follows the skull.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Split {
    jaw: DVec3,
    skull: DVec3,
}

/// The markers at some channel weights; made once and used again, so that evaluation allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct MarkerPose {
    weights: Vec<f64>,
    shape_weights: Vec<f64>,
    shape_gradient: Vec<f64>,
    jaw: JawPose,
    limbs: Vec<LimbPose>,
    followers: Vec<DVec3>,
    positions: Vec<DVec3>,
}

impl MarkerPose {
    /// Positions of the markers, in metres.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }
}

impl MarkerRig {
    /// The markers of an attachment.
    ///
    /// # Errors
    /// Where the attachment belongs to another rig (its vertices are not there), or the rig cannot be posed.
    pub fn attached(rig: &Rig, attachment: &Attachment) -> Result<Self, RigError> {
        let points = attachment.points.iter().map(|point| {
            let corners = point.vertices.iter().zip(point.weights);
            (point.name.clone(), corners.map(|(vertex, weight)| (*vertex, f64::from(weight))).collect())
        });
        Self::new(rig, points.collect())
    }

    /// Some vertices of the rig, each a marker named by its index.
    ///
    /// # Errors
    /// Where a vertex is not there, or the rig cannot be posed.
    pub fn of_vertices(rig: &Rig, vertices: &[u32]) -> Result<Self, RigError> {
        Self::new(rig, vertices.iter().map(|vertex| (vertex.to_string(), vec![(*vertex, 1.0)])).collect())
    }

    fn new(rig: &Rig, points: Vec<(String, Vec<(u32, f64)>)>) -> Result<Self, RigError> {
        let share_of = |vertex: u32| rig.jaw.as_ref().map_or(0.0, |jaw| f64::from(jaw.weights[vertex as usize]));
        // What neither the jaw nor another joint moves follows the skull.
        let skull_of =
            |vertex: u32| 1.0 - rig.all_joints().map(|joint| f64::from(joint.weights[vertex as usize])).sum::<f64>();
        let mut markers_of: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
        let mut names = Vec::with_capacity(points.len());
        let (mut rest, mut shares) = (Vec::new(), Vec::new());
        for (marker, (name, corners)) in points.into_iter().enumerate() {
            let (mut own_rest, mut own_share) = (Split::default(), 0.0);
            for (vertex, weight) in corners {
                let Some(position) = rig.neutral.get(vertex as usize) else {
                    let what = format!("vertex of marker `{name}` on rig `{}`", rig.name);
                    return Err(DataError::Index { what, index: vertex as usize, count: rig.neutral.len() }.into());
                };
                own_rest.add(weight, [share_of(vertex), skull_of(vertex)], *position);
                own_share += weight * share_of(vertex);
                markers_of.entry(vertex).or_default().push((marker as u32, weight));
            }
            names.push(name);
            rest.push(own_rest);
            shares.push(own_share);
        }
        let corners = Corners::new(markers_of, rig.neutral.len());
        let terms = rig.shapes.iter().map(|shape| {
            let mut of_marker: BTreeMap<u32, Split> = BTreeMap::new();
            for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
                for (marker, weight) in corners.of(*vertex) {
                    of_marker.entry(*marker).or_default().add(*weight, [share_of(*vertex), skull_of(*vertex)], *delta);
                }
            }
            of_marker.into_iter().filter(|(_, term)| *term != Split::default()).collect()
        });
        let terms: Vec<Vec<(u32, Split)>> = terms.collect();
        let limbs = rig.joints.iter().map(|joint| limb(rig, &joint.skin, &corners, names.len())).collect();
        Ok(Self {
            names,
            channels: rig.channels.clone(),
            drivers: ShapeDrivers::new(rig)?,
            rest,
            shares,
            terms,
            jaw: rig.jaw.as_ref().map(JawSkin::without_weights),
            limbs,
        })
    }

    /// Names of the markers.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Names of the channels.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Poses the markers at the weights of all channels.
    ///
    /// # Panics
    /// Where there are fewer weights than channels.
    pub fn pose(&self, weights: &[f64], pose: &mut MarkerPose) {
        pose.weights.clear();
        pose.weights.extend_from_slice(weights);
        self.drivers.weights_into(weights, &mut pose.shape_weights);
        pose.followers.clear();
        pose.followers.extend(self.rest.iter().map(|rest| rest.jaw));
        pose.positions.clear();
        pose.positions.extend(self.rest.iter().map(|rest| rest.skull));
        for (terms, weight) in self.terms.iter().zip(&pose.shape_weights) {
            if *weight != 0.0 {
                for (marker, term) in terms {
                    pose.followers[*marker as usize] += *weight * term.jaw;
                    pose.positions[*marker as usize] += *weight * term.skull;
                }
            }
        }
        if let Some(jaw) = &self.jaw {
            pose.jaw = JawPose::at(jaw, &pose.shape_weights);
            for ((position, follower), share) in pose.positions.iter_mut().zip(&pose.followers).zip(&self.shares) {
                *position += pose.jaw.rotation * *follower + *share * pose.jaw.translation_m;
            }
        }
        pose.limbs.resize_with(self.limbs.len(), LimbPose::default);
        for (limb, own) in self.limbs.iter().zip(&mut pose.limbs) {
            limb.pose(&pose.shape_weights, own, &mut pose.positions);
        }
    }

    /// The gradient by the channels of a number whose derivatives by the marker positions are `forces`: Jᵀ f, without
    /// making J.
    ///
    /// # Panics
    /// Where `pose` is not one of this rig's, or `gradient` is shorter than the channels.
    pub fn pull_back(&self, pose: &mut MarkerPose, forces: &[DVec3], gradient: &mut [f64]) {
        let rotation = pose.jaw.rotation;
        pose.shape_gradient.clear();
        pose.shape_gradient.extend(self.terms.iter().map(|terms| {
            let (mut jaw, mut skull) = (0.0, 0.0);
            for (marker, term) in terms {
                let force = forces[*marker as usize];
                skull += force.dot(term.skull);
                if term.jaw != DVec3::ZERO {
                    jaw += force.dot(rotation * term.jaw);
                }
            }
            jaw + skull
        }));
        if let Some(jaw) = &self.jaw {
            let (mut turning, mut pushing) = (DVec3::ZERO, DVec3::ZERO);
            let pivot = jaw.pivot_m.as_dvec3();
            for ((force, follower), share) in forces.iter().zip(&pose.followers).zip(&self.shares) {
                if *share != 0.0 {
                    for axis in 0..3 {
                        turning[axis] += force.dot(pose.jaw.turns[axis] * (*follower - *share * pivot));
                    }
                    pushing += *share * *force;
                }
            }
            for motion in &jaw.motions {
                pose.shape_gradient[motion.shape as usize] +=
                    turning.dot(motion.euler_rad.as_dvec3()) + pushing.dot(motion.translation_m.as_dvec3());
            }
        }
        for (limb, own) in self.limbs.iter().zip(&pose.limbs) {
            limb.pull_back(own, forces, &mut pose.shape_gradient);
        }
        gradient.fill(0.0);
        self.drivers.pull_back(&pose.weights, &pose.shape_gradient, gradient);
    }

    /// The Jacobian by the channels: for each channel, how every marker moves, in metres a unit of weight. The result
    /// is `channels × markers`, channel after channel.
    ///
    /// # Panics
    /// Where `pose` is not one of this rig's.
    pub fn jacobian(&self, pose: &MarkerPose, jacobian: &mut Vec<DVec3>) {
        let markers = self.rest.len();
        jacobian.clear();
        jacobian.resize(self.channels.len() * markers, DVec3::ZERO);
        for (shape, terms) in self.terms.iter().enumerate() {
            self.drivers.derivatives(shape, &pose.weights, |channel, slope| {
                let column = &mut jacobian[channel * markers..(channel + 1) * markers];
                for (marker, term) in terms {
                    column[*marker as usize] += slope * (pose.jaw.rotation * term.jaw + term.skull);
                }
            });
        }
        for (limb, own) in self.limbs.iter().zip(&pose.limbs) {
            limb.slopes(own, |shape, marker, moved| {
                self.drivers.derivatives(shape, &pose.weights, |channel, slope| {
                    jacobian[channel * markers + marker] += slope * moved;
                });
            });
        }
        let pivot = self.jaw.as_ref().map_or(DVec3::ZERO, |jaw| jaw.pivot_m.as_dvec3());
        for motion in self.jaw.iter().flat_map(|jaw| &jaw.motions) {
            let angles = motion.euler_rad.as_dvec3();
            let turn = pose.jaw.turns[0] * angles.x + pose.jaw.turns[1] * angles.y + pose.jaw.turns[2] * angles.z;
            let translation = motion.translation_m.as_dvec3();
            self.drivers.derivatives(motion.shape as usize, &pose.weights, |channel, slope| {
                let column = &mut jacobian[channel * markers..(channel + 1) * markers];
                for ((place, follower), share) in column.iter_mut().zip(&pose.followers).zip(&self.shares) {
                    *place += slope * (turn * (*follower - *share * pivot) + *share * translation);
                }
            });
        }
    }

    /// The markers over all frames of `curves`, which must hold every channel of the rig (others are passed over).
    ///
    /// # Errors
    /// Where a channel is not there, or a weight is not a number.
    pub fn drive(&self, curves: &Curves) -> Result<Markers, RigError> {
        let arranged = curves.arrange(&self.channels, None)?;
        let axis = curves.frame_axis();
        let mut positions = Vec::with_capacity(axis.count * self.names.len());
        let mut pose = MarkerPose::default();
        let mut weights = vec![0.0; self.channels.len()];
        for frame in 0..axis.count {
            for (channel, value) in arranged.frame(frame).iter().enumerate() {
                if !value.is_finite() {
                    let channel = self.channels[channel].clone();
                    return Err(RigError::Weight {
                        channel,
                        frame: axis.slice(&(frame..frame + 1)).first,
                        value: *value,
                    });
                }
                weights[channel] = f64::from(*value);
            }
            self.pose(&weights, &mut pose);
            positions.extend(pose.positions.iter().map(|position| position.as_vec3()));
        }
        Ok(Markers::new(axis, self.names.clone(), positions)?)
    }
}

impl Split {
    fn add(&mut self, weight: f64, [jaw, skull]: [f64; 2], vector: Vec3) {
        let vector = weight * vector.as_dvec3();
        self.jaw += jaw * vector;
        self.skull += skull * vector;
    }
}

/// What a joint besides the jaw does to markers with the given corners.
fn limb(rig: &Rig, joint: &JawSkin, corners: &Corners, markers: usize) -> Limb {
    let (mut shares, mut rest) = (vec![0.0; markers], vec![DVec3::ZERO; markers]);
    for (vertex, markers) in corners.iter() {
        let share = f64::from(joint.weights[*vertex as usize]);
        for (marker, weight) in markers {
            shares[*marker as usize] += weight * share;
            rest[*marker as usize] += weight * share * rig.neutral[*vertex as usize].as_dvec3();
        }
    }
    let terms = rig.shapes.iter().map(|shape| {
        let mut of_marker: BTreeMap<u32, DVec3> = BTreeMap::new();
        for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
            let share = f64::from(joint.weights[*vertex as usize]);
            for (marker, weight) in corners.of(*vertex).iter().filter(|_| share != 0.0) {
                *of_marker.entry(*marker).or_default() += weight * share * delta.as_dvec3();
            }
        }
        of_marker.into_iter().collect()
    });
    Limb::new(joint.without_weights(), &shares, &rest, &terms.collect::<Vec<_>>())
}

#[cfg(test)]
#[path = "marker_rig_tests.rs"]
mod tests;
