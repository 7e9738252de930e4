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
    /// Height of the brows above their average place.
    pub brow_height: f32,
    /// Thickness of the brows.
    pub brow_thickness: f32,
    /// Colours.
    pub colours: Colours,
}

/// Linear RGB of skin, lips, brows and irises.
#[derive(Debug, Clone, Copy)]
pub struct Colours {
    /// Skin.
    pub skin: [f32; 3],
    /// The lips' red.
    pub lips: [f32; 3],
    /// Eyebrows.
    pub brows: [f32; 3],
    /// Irises.
    pub iris: [f32; 3],
}

impl Colours {
    /// The colours of the average head.
    const AVERAGE: Self = Self {
        skin: [0.60, 0.365, 0.27],
        lips: [0.47, 0.19, 0.155],
        brows: [0.06, 0.035, 0.025],
        iris: [0.09, 0.16, 0.20],
    };

    /// Colours of another head: skin from fair to dark, irises blue, green or brown.
    fn drawn(random: &mut Random) -> Self {
        let dark = random.between(0.0, 1.0).powf(1.3);
        let mix = |light: [f32; 3], deep: [f32; 3]| std::array::from_fn(|c| light[c] * (deep[c] / light[c]).powf(dark));
        let irises = [[0.09, 0.16, 0.20], [0.11, 0.14, 0.06], [0.10, 0.045, 0.018], [0.05, 0.022, 0.01]];
        let first = if dark > 0.45 { 2 } else { 0 };
        Self {
            skin: mix([0.68, 0.44, 0.345], [0.16, 0.075, 0.045]),
            lips: mix([0.52, 0.21, 0.18], [0.17, 0.055, 0.045]),
            brows: if dark > 0.4 { [0.02, 0.013, 0.01] } else { [0.09, 0.05, 0.03] },
            iris: irises[first + random.below(irises.len() - first)],
        }
    }
}

impl Identity {
    /// The average head for seed 0; for other seeds a variation, `strength` 1 being an everyday difference.
    pub fn new(seed: u64, strength: f32) -> Self {
        let mut random = Random::new(seed);
        let amount = if seed == 0 { 0.0 } else { strength.clamp(0.0, 3.0) };
        let mut vary = |mean: f32, deviation: f32| mean + deviation * amount * random.normal().clamp(-1.8, 1.8);
        let mut identity = Self {
            scale: vary(1.0, 0.025).max(0.8),
            face_width: vary(1.0, 0.032).clamp(0.9, 1.12),
            jaw_width: vary(1.0, 0.045).clamp(0.88, 1.14),
            nose_projection: vary(1.0, 0.13).clamp(0.65, 1.45),
            nose_width: vary(1.0, 0.11).clamp(0.75, 1.4),
            nose_hump: vary(0.6, 1.0).clamp(-1.5, 3.5),
            mouth_half_width: vary(25.0, 1.6).clamp(22.0, 28.5),
            lip_fullness: vary(1.0, 0.2).clamp(0.55, 1.6),
            chin: vary(1.0, 0.9).clamp(-1.5, 3.5),
            brow_ridge: vary(1.0, 0.4).clamp(0.1, 2.2),
            cheekbone: vary(1.0, 0.45).clamp(0.1, 2.4),
            eye_opening: vary(1.0, 0.06).clamp(0.85, 1.15),
            eye_tilt: vary(1.6, 0.8).clamp(-0.5, 3.5),
            eye_x: vary(31.5, 0.5).clamp(30.0, 33.0),
            brow_height: vary(0.0, 1.1).clamp(-2.0, 2.5),
            brow_thickness: vary(1.0, 0.25).clamp(0.5, 1.6),
            colours: Colours::AVERAGE,
        };
        if amount > 0.0 {
            identity.colours = Colours::drawn(&mut random);
        }
        identity
    }
}
