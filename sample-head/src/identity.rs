//! Who the head is: proportions in millimetres, the average adult or a seeded variation of it.

use crate::numbers::Random;

/// Proportions of one head. Lengths are millimetres, the rest are factors around 1.
#[derive(Debug, Clone)]
pub struct Identity {
    /// Size of the whole head.
    pub scale: f32,
    /// Width of the skull and cheeks.
    pub face_width: f32,
    /// Width of the jaw.
    pub jaw_width: f32,
    /// How far the nose stands out.
    pub nose_projection: f32,
    /// Width of the nose.
    pub nose_width: f32,
    /// Height of the bridge's hump above a straight line.
    pub nose_hump: f32,
    /// Half the width of the closed mouth.
    pub mouth_half_width: f32,
    /// Fullness of the lips.
    pub lip_fullness: f32,
    /// How far chin and lower jaw stand forward.
    pub chin: f32,
    /// Strength of the brow ridge.
    pub brow_ridge: f32,
    /// Strength of the cheekbones.
    pub cheekbone: f32,
    /// Opening of the eyes.
    pub eye_opening: f32,
    /// How much higher the outer corner of the eye stands than the inner.
    pub eye_tilt: f32,
    /// Distance of the eye from the midline.
    pub eye_x: f32,
}

impl Identity {
    /// The average head for seed 0; for other seeds a variation, `strength` 1 being an everyday difference.
    pub fn new(seed: u64, strength: f32) -> Self {
        let mut random = Random::new(seed);
        let amount = if seed == 0 { 0.0 } else { strength.clamp(0.0, 3.0) };
        let mut vary = |mean: f32, deviation: f32| mean + deviation * amount * random.normal().clamp(-1.8, 1.8);
        Self {
            scale: vary(1.0, 0.025).max(0.8),
            face_width: vary(1.0, 0.025).clamp(0.9, 1.12),
            jaw_width: vary(1.0, 0.03).clamp(0.9, 1.12),
            nose_projection: vary(1.0, 0.09).clamp(0.7, 1.4),
            nose_width: vary(1.0, 0.08).clamp(0.75, 1.35),
            nose_hump: vary(0.6, 0.8).clamp(-1.5, 3.5),
            mouth_half_width: vary(25.0, 1.2).clamp(22.0, 28.5),
            lip_fullness: vary(1.0, 0.13).clamp(0.6, 1.5),
            chin: vary(1.0, 0.5).clamp(-1.0, 3.0),
            brow_ridge: vary(1.0, 0.3).clamp(0.1, 2.0),
            cheekbone: vary(1.0, 0.3).clamp(0.1, 2.2),
            eye_opening: vary(1.0, 0.06).clamp(0.85, 1.15),
            eye_tilt: vary(1.6, 0.8).clamp(-0.5, 3.5),
            eye_x: vary(31.5, 0.5).clamp(30.0, 33.0),
        }
    }
}
