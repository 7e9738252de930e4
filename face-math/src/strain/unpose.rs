//! Skinning undone: what the face does in its rest pose (section A.2 of Animatomy: V̂, and Ṽ once pose shapes are taken off).
//!
//! Skinning takes a vertex x to y = x + `Σ_k` `w_k` (`R_k` x + `T_k` − x) = B x + b with B = I + `Σ_k` `w_k` (`R_k` − I) and
//! b = `Σ_k` `w_k` `T_k` (metres). So x = B⁻¹ (y − b), wherever B can be inverted. It cannot where a vertex hangs halfway
//! between the skull and a joint that turns by half a circle; such meshes are refused.

use super::error::{StrainError, same};
use super::joints::{Poses, joints};
use super::skinning::check_meshes;
use crate::data::{Curves, Driver, Meshes, Rig};
use crate::rig::{JawPose, ShapeDrivers};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// A blended matrix whose determinant is smaller than this cannot be inverted well.
const LEAST_VOLUME: f64 = 0.02;

/// What is taken off meshes besides the joints' motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// Nothing else: V̂, which still holds what pose shapes explain.
    PoseShapes,
    /// The pose shapes too: Ṽ, what strains explain.
    Strains,
}

/// B and b of one vertex.
pub(super) fn blend(weights: &[&[f32]], vertex: usize, poses: &[JawPose]) -> (DMat3, DVec3) {
    let (mut matrix, mut shift) = (DMat3::IDENTITY, DVec3::ZERO);
    for (weights, pose) in weights.iter().zip(poses) {
        let weight = f64::from(weights[vertex]);
        if weight != 0.0 {
            matrix += weight * (pose.rotation - DMat3::IDENTITY);
            shift += weight * pose.translation_m;
        }
    }
    (matrix, shift)
}

/// The meshes in the rest pose: joints turned back, and, where they are not kept, pose shapes taken off.
///
/// # Errors
/// Where meshes, poses and rig do not fit, or skinning cannot be undone somewhere.
pub fn unpose_meshes(rig: &Rig, meshes: &Meshes, poses: &Curves, keep: Keep) -> Result<Meshes, StrainError> {
    same("vertices of the meshes", rig.neutral.len(), meshes.vertices())?;
    same("frames of the poses", meshes.frames(), poses.frames())?;
    check_meshes(meshes)?;
    let shapes = PoseShapes::new(rig, poses)?;
    let poses = Poses::new(rig, poses)?;
    let weights: Vec<&[f32]> = joints(rig).iter().map(|joint| joint.skin.weights.as_slice()).collect();
    let frames: Vec<Vec<Vec3>> = (0..meshes.frames())
        .into_par_iter()
        .map(|frame| {
            let number = meshes.frame_axis().slice(&(frame..frame + 1)).first;
            let mut offsets = vec![Vec3::ZERO; if keep == Keep::Strains { rig.neutral.len() } else { 0 }];
            if keep == Keep::Strains {
                shapes.add(rig, frame, &mut offsets);
            }
            let unposed = |(vertex, posed): (usize, &Vec3)| {
                let (matrix, shift) = blend(&weights, vertex, poses.frame(frame));
                let still = matrix == DMat3::IDENTITY && shift == DVec3::ZERO;
                let volume = if still { 1.0 } else { matrix.determinant() };
                if volume < LEAST_VOLUME {
                    return Err(StrainError::Flat { vertex, frame: number, volume });
                }
                let rest = if still { *posed } else { (matrix.inverse() * (posed.as_dvec3() - shift)).as_vec3() };
                Ok(offsets.get(vertex).map_or(rest, |offset| rest - *offset))
            };
            meshes.frame(frame).iter().enumerate().map(unposed).collect()
        })
        .collect::<Result<_, StrainError>>()?;
    let parts = meshes.parts().to_vec();
    Ok(Meshes::new(meshes.frame_axis(), parts, meshes.vertices(), frames.concat())?)
}

/// The shapes of a rig that its joints' pose alone drives, with their weights in every frame.
#[derive(Debug)]
pub(super) struct PoseShapes {
    shapes: Vec<usize>,
    weights: Vec<f32>,
}

impl PoseShapes {
    /// The pose shapes of a rig at poses.
    pub fn new(rig: &Rig, poses: &Curves) -> Result<Self, StrainError> {
        let channels = super::pose_channels(rig)?;
        let of_pose = |driver: &Driver| match driver {
            Driver::Turn { .. } => true,
            Driver::Channel(channel) => channels.contains(&rig.channels[*channel as usize]),
            Driver::Combination(_) | Driver::InBetween { .. } => false,
        };
        let moves = |index: &usize| of_pose(&rig.shapes[*index].driver) && !rig.shapes[*index].vertices.is_empty();
        let shapes: Vec<usize> = (0..rig.shapes.len()).filter(moves).collect();
        let arranged = poses.arrange(&channels, None)?.arrange(&rig.channels, Some(0.0))?;
        let drivers = ShapeDrivers::new(rig)?;
        let (mut weights, mut all) = (Vec::with_capacity(poses.frames() * shapes.len()), Vec::new());
        for frame in 0..poses.frames() {
            let values: Vec<f64> = arranged.frame(frame).iter().map(|value| f64::from(*value)).collect();
            drivers.weights_into(&values, &mut all);
            weights.extend(shapes.iter().map(|shape| all[*shape] as f32));
        }
        Ok(Self { shapes, weights })
    }

    /// Indices of the shapes in the rig.
    pub fn shapes(&self) -> &[usize] {
        &self.shapes
    }

    /// Their weights in a frame.
    pub fn weights(&self, frame: usize) -> &[f32] {
        &self.weights[frame * self.shapes.len()..(frame + 1) * self.shapes.len()]
    }

    /// Places of those that some frame uses.
    pub fn moving(&self) -> Vec<usize> {
        let count = self.shapes.len().max(1);
        (0..self.shapes.len())
            .filter(|at| self.weights.iter().skip(*at).step_by(count).any(|own| *own != 0.0))
            .collect()
    }

    /// Adds what they do in a frame to `offsets` (metres, one a vertex).
    pub fn add(&self, rig: &Rig, frame: usize, offsets: &mut [Vec3]) {
        for (shape, weight) in self.shapes.iter().zip(self.weights(frame)) {
            let shape = &rig.shapes[*shape];
            for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
                offsets[*vertex as usize] += *weight * *delta;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;

    #[test]
    fn skinning_undone_gives_back_what_was_skinned() {
        let rig = toy::with_shapes(&toy::jointed_head(), 3, 0.01);
        let poses = toy::pose_curves(&rig, 6);
        let strains = toy::values(&rig.channels[9..], 6, 1.0, 5);
        let both = toy::beside(&poses, &strains);
        let unposed = unpose_meshes(&rig, &toy::evaluated(&rig, &both), &poses, Keep::Strains).unwrap();
        let expected = toy::evaluated(&rig, &strains);
        for (a, b) in unposed.positions().iter().zip(expected.positions()) {
            assert!(a.abs_diff_eq(*b, 1e-7), "{a} {b}");
        }
        assert_eq!(unposed.frame(0), &rig.neutral[..], "rest is rest, bit for bit");
    }

    #[test]
    fn half_a_turn_is_refused_where_a_vertex_hangs_between() {
        let mut rig = toy::jointed_head();
        rig.jaw.as_mut().unwrap().weights[20] = 0.5;
        let mut values = toy::still(&toy::pose_curves(&rig, 2)).values().to_vec();
        values[9] = std::f32::consts::PI;
        let poses =
            Curves::new(wire::FrameAxis { first: 7, count: 2, rate_hz: 1.0 }, rig.channels.clone(), values).unwrap();
        let meshes = toy::evaluated(&rig, &poses);
        let error = unpose_meshes(&rig, &meshes, &poses, Keep::Strains).err();
        assert!(matches!(error, Some(StrainError::Flat { frame: 8, vertex: 20, .. })), "{error:?}");
    }
}
