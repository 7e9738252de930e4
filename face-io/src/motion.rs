//! What moves in each frame: weights of shapes, and the jaw where it is a joint. Every writer of animated heads asks here.
//!
//! Shapes that no other program knows how to drive (combinations, in-betweens) get weights here like all others.

use crate::WriteError;
use face_math::data::{Curves, JawSkin, Rig};
use face_math::rig::{JawPose, ShapeDrivers};
use glam::{DQuat, Quat, Vec3};

/// The share of the jaw in each vertex: that of the split jaw, or else of the rig's own skin.
pub(crate) fn jaw_shares<'r>(rig: &'r Rig, format: &'static str) -> Result<Option<&'r [f32]>, WriteError> {
    if let Some(joint) = rig.joints.first() {
        let problem =
            "is that of a joint besides the jaw, which is not written; save its meshes (`save_meshes`) instead";
        return Err(WriteError::Name { format, name: joint.name.clone(), problem });
    }
    let shares = match &rig.jaw {
        Some(JawSkin { weights, .. }) => weights,
        None if rig.skin.is_empty() => return Ok(None),
        None => &rig.skin,
    };
    match shares.iter().position(|share| !(0.0..=1.0).contains(share)) {
        None => Ok(Some(shares)),
        Some(at) => Err(WriteError::Range {
            format,
            what: format!("share of the jaw in vertex {at}"),
            value: shares[at].into(),
            low: 0.0,
            high: 1.0,
        }),
    }
}

/// The tracks of an animation.
pub(crate) struct Motion {
    /// Seconds from the first frame on.
    pub times_s: Vec<f32>,
    /// `frames × shapes`.
    pub shape_weights: Vec<f32>,
    /// One key a frame; none where the jaw is no joint.
    pub jaw: Vec<JawKey>,
}

/// The jaw in one frame: x ↦ R x + T.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JawKey {
    pub rotation: Quat,
    pub translation_m: Vec3,
}

impl JawKey {
    /// Where a joint that stands at `pivot` at rest, with its vertices bound there, must move to: x ↦ R x + T is its
    /// rotation R about the pivot p followed by the translation R p + T.
    pub fn joint_translation_m(&self, pivot: Vec3) -> Vec3 {
        self.rotation * pivot + self.translation_m
    }
}

impl Motion {
    /// The motion of a rig by curves; those of other channels than the rig's are left out.
    pub fn of(rig: &Rig, curves: &Curves, format: &'static str) -> Result<Self, WriteError> {
        let curves = curves.arrange(&rig.channels, None)?;
        let drivers = ShapeDrivers::new(rig)?;
        let axis = curves.frame_axis();
        let mut motion = Self {
            times_s: (0..axis.count).map(|frame| (frame as f64 / axis.rate_hz) as f32).collect(),
            shape_weights: Vec::with_capacity(axis.count * rig.shapes.len()),
            jaw: Vec::new(),
        };
        if motion.times_s.windows(2).any(|pair| pair[1] <= pair[0]) || motion.times_s.iter().any(|t| !t.is_finite()) {
            let what = "frame rate (its times must be apart in 32 bits)".to_owned();
            return Err(WriteError::Range { format, what, value: axis.rate_hz, low: 1e-3, high: 1e4 });
        }
        let mut shapes = Vec::new();
        let mut before = DQuat::IDENTITY;
        for frame in 0..axis.count {
            let channels: Vec<f64> = curves.frame(frame).iter().map(|weight| f64::from(*weight)).collect();
            if let Some(at) = channels.iter().position(|weight| !weight.is_finite()) {
                let what = format!("channel `{}`", rig.channels[at]);
                let (frame, value) = (axis.first + frame.cast_signed() as i64, channels[at] as f32);
                return Err(WriteError::NotFinite { format, what, frame, value });
            }
            drivers.weights_into(&channels, &mut shapes);
            motion.shape_weights.extend(shapes.iter().map(|weight| *weight as f32));
            if let Some(jaw) = &rig.jaw {
                let pose = JawPose::at(jaw, &shapes);
                let rotation = DQuat::from_mat3(&pose.rotation).normalize();
                // q and -q are one rotation; the one nearer to the key before makes players turn the short way.
                let rotation = if rotation.dot(before) < 0.0 { -rotation } else { rotation };
                before = rotation;
                let translation_m = pose.translation_m.as_vec3();
                motion.jaw.push(JawKey { rotation: rotation.as_quat(), translation_m });
            }
        }
        Ok(motion)
    }
}
