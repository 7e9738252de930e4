//! All vertices of a head at given channel weights.
//!
//! Without a jaw joint, S(w) = N + Σ wᵢ Dᵢ (Eq. 1 of FDLS). With one, linear blend skinning on top:
//!
//! ```text
//! S(w) = (M R(w) + (1 − M) I) (N + Σ wᵢ Dᵢ) + M T(w)
//! ```
//!
//! S, N, Dᵢ, T in metres, a vertex; M a vertex's share in the jaw, 0 to 1; wᵢ the shape weights. Section 6 of the
//! deepfake capture paper. With further joints, each adds its own Mⱼ (Rⱼ x + Tⱼ − x). Sums run in single precision: over a head of 20 cm that is good to some 10 nanometres.

use super::{JawPose, RigError, ShapeDrivers};
use crate::data::{JawSkin, Rig};
use glam::{Mat3, Vec3};

/// A rig made ready to be posed.
#[derive(Debug, Clone)]
pub struct Puppet<'r> {
    rig: &'r Rig,
    drivers: ShapeDrivers,
}

impl<'r> Puppet<'r> {
    /// Prepares `rig`.
    ///
    /// # Errors
    /// Where an in-between does not peak strictly between 0 and 1.
    pub fn new(rig: &'r Rig) -> Result<Self, RigError> {
        Ok(Self { rig, drivers: ShapeDrivers::new(rig)? })
    }

    /// The rig.
    pub fn rig(&self) -> &'r Rig {
        self.rig
    }

    /// Positions of all vertices, in metres, at the weights of the rig's channels.
    ///
    /// # Errors
    /// Where there are not as many weights as channels.
    pub fn vertices(&self, weights: &[f32]) -> Result<Vec<Vec3>, RigError> {
        let mut vertices = Vec::new();
        self.vertices_into(weights, &mut vertices)?;
        Ok(vertices)
    }

    /// Like [`Self::vertices`], into a buffer that is used again from frame to frame.
    ///
    /// # Errors
    /// Where there are not as many weights as channels.
    pub fn vertices_into(&self, weights: &[f32], vertices: &mut Vec<Vec3>) -> Result<(), RigError> {
        let expected = self.drivers.channels();
        if weights.len() != expected {
            return Err(RigError::WeightCount { expected, found: weights.len() });
        }
        let channels: Vec<f64> = weights.iter().map(|weight| f64::from(*weight)).collect();
        let mut shape_weights = Vec::with_capacity(self.drivers.shapes());
        self.drivers.weights_into(&channels, &mut shape_weights);

        vertices.clear();
        vertices.extend_from_slice(&self.rig.neutral);
        for (shape, weight) in self.rig.shapes.iter().zip(&shape_weights) {
            if *weight != 0.0 {
                let weight = *weight as f32;
                for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
                    vertices[*vertex as usize] += weight * *delta;
                }
            }
        }
        if let (Some(jaw), true) = (&self.rig.jaw, self.rig.joints.is_empty()) {
            let (rotation, translation) = turned(jaw, &shape_weights);
            for (vertex, share) in vertices.iter_mut().zip(&jaw.weights) {
                if *share != 0.0 {
                    let moved = rotation * *vertex + translation;
                    *vertex += *share * (moved - *vertex);
                }
            }
        } else if !self.rig.joints.is_empty() {
            // All joints move what the shapes have made, none what another joint has moved.
            let poses: Vec<_> =
                self.rig.all_joints().map(|joint| (turned(joint, &shape_weights), &joint.weights)).collect();
            for (at, vertex) in vertices.iter_mut().enumerate() {
                let rest = *vertex;
                for ((rotation, translation), weights) in &poses {
                    if weights[at] != 0.0 {
                        *vertex += weights[at] * (*rotation * rest + *translation - rest);
                    }
                }
            }
        }
        Ok(())
    }
}

/// R and T of a joint.
fn turned(joint: &JawSkin, shape_weights: &[f64]) -> (Mat3, Vec3) {
    let pose = JawPose::at(joint, shape_weights);
    (pose.rotation.as_mat3(), pose.translation_m.as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;

    #[test]
    fn no_weight_gives_the_neutral_head() {
        let rig = toy::jawed(5, 4);
        assert_eq!(Puppet::new(&rig).unwrap().vertices(&[0.0; 4]).unwrap(), rig.neutral);
    }

    #[test]
    fn one_channel_gives_its_shape() {
        let rig = toy::rig(5, 4);
        let posed = Puppet::new(&rig).unwrap().vertices(&[0.0, 0.0, 1.0, 0.0]).unwrap();
        let shape = &rig.shapes[2];
        let mut expected = rig.neutral.clone();
        for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
            expected[*vertex as usize] += *delta;
        }
        assert_eq!(posed, expected);
    }

    #[test]
    fn a_vertex_of_the_jaw_moves_rigidly_and_one_of_the_skull_stays() {
        let mut rig = toy::jawed(5, 4);
        rig.shapes.iter_mut().for_each(|shape| shape.deltas.fill(Vec3::ZERO));
        let jaw = rig.jaw.as_mut().unwrap();
        jaw.weights.fill(1.0);
        jaw.weights[3] = 0.0;
        let motion = jaw.motions[1];
        let posed = Puppet::new(&rig).unwrap().vertices(&[0.0, 1.0, 0.0, 0.0]).unwrap();
        for (vertex, position) in posed.iter().enumerate() {
            let rest = rig.neutral[vertex];
            let expected = if vertex == 3 { rest } else { motion.rotation() * rest + motion.translation_m };
            assert!(position.abs_diff_eq(expected, 1e-7), "vertex {vertex}");
        }
    }

    #[test]
    fn a_wrong_number_of_weights_is_refused() {
        let rig = toy::rig(4, 3);
        let error = Puppet::new(&rig).unwrap().vertices(&[0.0; 2]).unwrap_err();
        assert_eq!(error, RigError::WeightCount { expected: 3, found: 2 });
    }
}
