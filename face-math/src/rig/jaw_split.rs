//! The steps of splitting the jaw off a rig; [`super::skin_jaw()`] says what they mean and puts them in order.

use super::skin_jaw::{JawFit, SkinJawOptions, SkinnedJaw};
use super::{JawPose, RigError, Rigid, RigidFit, ShapeDrivers, fit_rigid};
use crate::data::{DataError, Driver, JawMotion, JawSkin, Rig, Shape, nearest_name};
use glam::{DMat3, DVec3, EulerRot, Vec3};
use std::collections::BTreeMap;
use std::ops::Range;

/// Offsets smaller than this are rounding, in metres.
const NOTHING_M: f64 = 1e-9;
/// What keeps M at 0 where the jaw's motion is none, in metres.
const STILL_M: f64 = 1e-5;
/// The smallest determinant of M R + (1 − M) I that still is a skin.
const FLAT: f64 = 0.01;

/// A rig whose jaw is being split off.
pub(super) struct Split<'r> {
    rig: &'r Rig,
    options: &'r SkinJawOptions,
    teeth: Range<usize>,
    drivers: ShapeDrivers,
    /// By shape.
    jaw: BTreeMap<usize, JawShape>,
}

struct JawShape {
    motion: JawMotion,
    fit: JawFit,
    /// S − N of every vertex.
    whole: Vec<DVec3>,
    /// D of every vertex.
    offsets: Vec<DVec3>,
}

impl<'r> Split<'r> {
    /// Begins with no jaw shape found; `teeth` are the vertices that only the jaw moves.
    pub(super) fn new(rig: &'r Rig, options: &'r SkinJawOptions, teeth: Range<usize>) -> Result<Self, RigError> {
        Ok(Self { rig, options, teeth, drivers: ShapeDrivers::new(rig)?, jaw: BTreeMap::new() })
    }

    /// Finds the jaw shapes among those of channels.
    pub(super) fn find_channels(&mut self) -> Result<(), RigError> {
        for name in &self.options.channels {
            if self.rig.channel(name).is_none() {
                let near = nearest_name(name, self.rig.channels.iter().map(String::as_str));
                return Err(DataError::Missing { what: "channel", name: name.clone(), near }.into());
            }
        }
        let mut found = Vec::new();
        for (index, shape) in self.rig.shapes.iter().enumerate() {
            let Driver::Channel(channel) = shape.driver else { continue };
            let channel = &self.rig.channels[channel as usize];
            let listed = self.options.channels.contains(channel);
            if !listed && !self.options.channels.is_empty() {
                continue;
            }
            let whole = self.dense(shape);
            let motion_m = self.motion_of_teeth(&whole);
            if motion_m < self.options.min_motion_m {
                if listed {
                    return Err(RigError::StillJaw {
                        channel: channel.clone(),
                        part: self.options.part.clone(),
                        motion_mm: motion_m * 1000.0,
                        least_mm: self.options.min_motion_m * 1000.0,
                    });
                }
                continue;
            }
            let fit = self.fit(&shape.name, &whole)?;
            if !listed && fit.residual_rms_m > self.options.max_residual_share * motion_m {
                found.push(format!(
                    "`{channel}` leaves {:.2} mm of {:.2} mm",
                    fit.residual_rms_m * 1e3,
                    motion_m * 1e3
                ));
                continue;
            }
            let motion = JawMotion {
                shape: index as u32,
                euler_rad: euler_of(fit.motion.rotation).as_vec3(),
                translation_m: fit.motion.translation_m.as_vec3(),
            };
            let fit = JawFit {
                shape: shape.name.clone(),
                motion_rms_m: motion_m,
                residual_rms_m: fit.residual_rms_m,
                angle_rad: fit.motion.angle_rad(),
            };
            self.jaw.insert(index, JawShape { motion, fit, whole, offsets: Vec::new() });
        }
        if self.jaw.is_empty() {
            let found = if found.is_empty() { "none moves it at all".to_owned() } else { found.join(", ") };
            return Err(RigError::NoJawShape { rig: self.rig.name.clone(), part: self.options.part.clone(), found });
        }
        Ok(())
    }

    /// M of every vertex.
    pub(super) fn shares(&self) -> Vec<f32> {
        if self.options.own_skin && !self.rig.skin.is_empty() {
            return self.rig.skin.clone();
        }
        let poses: Vec<_> = self.jaw.values().map(|shape| (pose_of(&shape.motion), shape)).collect();
        let share = |(vertex, neutral): (usize, &Vec3)| {
            let neutral = neutral.as_dvec3();
            let (mut along, mut full) = (0.0, STILL_M * STILL_M);
            for (pose, shape) in &poses {
                let rigid = pose.rotation * neutral + pose.translation_m - neutral;
                along += shape.whole[vertex].dot(rigid);
                full += rigid.length_squared();
            }
            (along / full).clamp(0.0, 1.0) as f32
        };
        self.rig.neutral.iter().enumerate().map(share).collect()
    }

    /// D of the channels' jaw shapes.
    pub(super) fn deskin_channels(&mut self, shares: &[f32]) -> Result<(), RigError> {
        let nothing = vec![DVec3::ZERO; self.rig.neutral.len()];
        for index in self.jaw.keys().copied().collect::<Vec<_>>() {
            let shape = &self.jaw[&index];
            let offsets = self.deskin(&shape.fit.shape, &pose_of(&shape.motion), &shape.whole, &nothing, shares)?;
            if let Some(shape) = self.jaw.get_mut(&index) {
                shape.offsets = offsets;
            }
        }
        Ok(())
    }

    /// The correctives that take part in the jaw's motion, in an order in which each stands after all that are at work
    /// at its corner: in-betweens (which are alone there), then combinations by their number of channels.
    pub(super) fn correctives(&self) -> Vec<usize> {
        let moves_jaw = |channel: &u32| {
            self.jaw
                .keys()
                .any(|shape| matches!(&self.rig.shapes[*shape].driver, Driver::Channel(own) if own == channel))
        };
        let mut found = Vec::new();
        for (index, shape) in self.rig.shapes.iter().enumerate() {
            let (rank, all_jaw) = match &shape.driver {
                Driver::Channel(_) | Driver::Turn { .. } => continue,
                Driver::InBetween { channel, .. } => (0, moves_jaw(channel)),
                Driver::Combination(channels) => (channels.len(), channels.iter().all(moves_jaw)),
            };
            if all_jaw || self.motion_of_teeth(&self.dense(shape)) >= self.options.min_motion_m {
                found.push((rank, index));
            }
        }
        found.sort_unstable();
        found.into_iter().map(|(_, index)| index).collect()
    }

    /// Makes the split rig equal the old one at the corner of a corrective.
    pub(super) fn deskin_corrective(&mut self, index: usize, shares: &[f32]) -> Result<(), RigError> {
        let shape = &self.rig.shapes[index];
        let mut channels = vec![0.0; self.rig.channels.len()];
        match &shape.driver {
            Driver::Channel(_) | Driver::Turn { .. } => {}
            Driver::InBetween { channel, peak } => channels[*channel as usize] = f64::from(*peak),
            Driver::Combination(all) => all.iter().for_each(|channel| channels[*channel as usize] = 1.0),
        }
        let mut corner = Vec::new();
        self.drivers.weights_into(&channels, &mut corner);

        let own = self.dense(shape);
        let mut whole = own.clone();
        let mut offsets = vec![DVec3::ZERO; whole.len()];
        let (mut euler, mut translation) = (DVec3::ZERO, DVec3::ZERO);
        for (other, jaw) in &self.jaw {
            let weight = corner[*other];
            if weight != 0.0 {
                euler += weight * jaw.motion.euler_rad.as_dvec3();
                translation += weight * jaw.motion.translation_m.as_dvec3();
                for vertex in 0..whole.len() {
                    whole[vertex] += weight * jaw.whole[vertex];
                    offsets[vertex] += weight * jaw.offsets[vertex];
                }
            }
        }
        let fit = self.fit(&shape.name, &whole)?;
        let motion = JawMotion {
            shape: index as u32,
            euler_rad: (euler_of(fit.motion.rotation) - euler).as_vec3(),
            translation_m: (fit.motion.translation_m - translation).as_vec3(),
        };
        let pose = JawPose::of(euler + motion.euler_rad.as_dvec3(), translation + motion.translation_m.as_dvec3());
        let offsets = self.deskin(&shape.name, &pose, &whole, &offsets, shares)?;
        let fit = JawFit {
            shape: shape.name.clone(),
            motion_rms_m: self.motion_of_teeth(&whole),
            residual_rms_m: fit.residual_rms_m,
            angle_rad: fit.motion.angle_rad(),
        };
        self.jaw.insert(index, JawShape { motion, fit, whole: own, offsets });
        Ok(())
    }

    /// (M R + (1 − M) I)⁻¹ (N + whole − M T) − N − others, for every vertex.
    fn deskin(
        &self,
        shape: &str,
        pose: &JawPose,
        whole: &[DVec3],
        others: &[DVec3],
        shares: &[f32],
    ) -> Result<Vec<DVec3>, RigError> {
        let mut offsets = Vec::with_capacity(whole.len());
        for (vertex, share) in shares.iter().enumerate() {
            let m = f64::from(*share);
            let blend = m * pose.rotation + (1.0 - m) * DMat3::IDENTITY;
            if blend.determinant().abs() < FLAT {
                let rigid = Rigid { rotation: pose.rotation, translation_m: pose.translation_m };
                let angle_deg = rigid.angle_rad().to_degrees();
                return Err(RigError::Flat { shape: shape.to_owned(), vertex, weight: *share, angle_deg });
            }
            let neutral = self.rig.neutral[vertex].as_dvec3();
            let offset = if m == 0.0 {
                whole[vertex]
            } else {
                blend.inverse() * (neutral + whole[vertex] - m * pose.translation_m) - neutral
            };
            offsets.push(offset - others[vertex]);
        }
        Ok(offsets)
    }

    /// The rig with its jaw as a joint.
    pub(super) fn finish(self, shares: Vec<f32>) -> SkinnedJaw {
        let mut rig = self.rig.clone();
        let mut motions = Vec::with_capacity(self.jaw.len());
        let mut fits = Vec::with_capacity(self.jaw.len());
        for (index, jaw) in self.jaw {
            let kept = jaw.offsets.iter().enumerate().filter(|(_, offset)| offset.length() > NOTHING_M);
            let (vertices, deltas) = kept.map(|(vertex, offset)| (vertex as u32, offset.as_vec3())).unzip();
            rig.shapes[index].vertices = vertices;
            rig.shapes[index].deltas = deltas;
            motions.push(jaw.motion);
            fits.push(jaw.fit);
        }
        rig.jaw = Some(JawSkin { weights: shares, motions, ..JawSkin::default() });
        SkinnedJaw { rig, fits }
    }

    fn dense(&self, shape: &Shape) -> Vec<DVec3> {
        let mut dense = vec![DVec3::ZERO; self.rig.neutral.len()];
        for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
            dense[*vertex as usize] = delta.as_dvec3();
        }
        dense
    }

    /// Root mean square displacement of the jaw's part, in metres.
    fn motion_of_teeth(&self, whole: &[DVec3]) -> f64 {
        let squares: f64 = whole[self.teeth.clone()].iter().map(|delta| delta.length_squared()).sum();
        (squares / self.teeth.len().max(1) as f64).sqrt()
    }

    fn fit(&self, shape: &str, whole: &[DVec3]) -> Result<RigidFit, RigError> {
        let from: Vec<_> = self.rig.neutral[self.teeth.clone()].iter().map(|point| point.as_dvec3()).collect();
        let to: Vec<_> = from.iter().zip(&whole[self.teeth.clone()]).map(|(point, delta)| *point + *delta).collect();
        fit_rigid(&from, &to, None).map_err(|source| RigError::JawFit {
            part: self.options.part.clone(),
            shape: shape.to_owned(),
            source,
        })
    }
}

/// The angles about the fixed axes x, y, z of R = Rz·Ry·Rx.
fn euler_of(rotation: DMat3) -> DVec3 {
    let (z, y, x) = rotation.to_euler(EulerRot::ZYX);
    DVec3::new(x, y, z)
}

fn pose_of(motion: &JawMotion) -> JawPose {
    JawPose::of(motion.euler_rad.as_dvec3(), motion.translation_m.as_dvec3())
}
