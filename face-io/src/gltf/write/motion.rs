//! What moves in each frame: weights of shapes, and the jaw where it is a joint.

use crate::WriteError;
use face_math::data::{Curves, Rig};
use face_math::rig::{JawPose, ShapeDrivers};
use glam::{DQuat, Quat, Vec3};

/// The tracks of an animation.
pub(super) struct Motion {
    /// Seconds from the first frame on.
    pub times_s: Vec<f32>,
    /// `frames × shapes`.
    pub shape_weights: Vec<f32>,
    /// One key a frame; none where the jaw is no joint.
    pub jaw: Vec<JawKey>,
}

/// The jaw in one frame: x ↦ R x + T.
pub(super) struct JawKey {
    pub rotation: Quat,
    pub translation_m: Vec3,
}

impl Motion {
    /// The motion of curves that are arranged as the rig's channels.
    pub fn of(rig: &Rig, curves: &Curves, drivers: &ShapeDrivers) -> Result<Self, WriteError> {
        let axis = curves.frame_axis();
        let mut motion = Self {
            times_s: (0..axis.count).map(|frame| (frame as f64 / axis.rate_hz) as f32).collect(),
            shape_weights: Vec::with_capacity(axis.count * rig.shapes.len()),
            jaw: Vec::new(),
        };
        if motion.times_s.windows(2).any(|pair| pair[1] <= pair[0]) || motion.times_s.iter().any(|t| !t.is_finite()) {
            let what = "frame rate (its times must be apart in 32 bits)".to_owned();
            return Err(WriteError::Range { format: super::FORMAT, what, value: axis.rate_hz, low: 1e-3, high: 1e4 });
        }
        let mut shapes = Vec::new();
        let mut before = DQuat::IDENTITY;
        for frame in 0..axis.count {
            let channels: Vec<f64> = curves.frame(frame).iter().map(|weight| f64::from(*weight)).collect();
            if let Some(at) = channels.iter().position(|weight| !weight.is_finite()) {
                let what = format!("channel `{}`", rig.channels[at]);
                let (frame, value) = (axis.first + frame.cast_signed() as i64, channels[at] as f32);
                return Err(WriteError::NotFinite { format: super::FORMAT, what, frame, value });
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
