//! What faces do: expressions and visemes as channel weights. A name without side stands for both sides.

/// A pose: channels (a stem for `_L` and `_R` together) and weights.
pub type Pose = &'static [(&'static str, f32)];

/// Channels, or pairs of channels, shown one after the other in a range of motion, with what must go along.
pub const ISOLATIONS: [Pose; 46] = [
    &[("browInnerUp", 0.9)],
    &[("browOuterUp", 0.9)],
    &[("browOuterUp_L", 0.9)],
    &[("browOuterUp_R", 0.9)],
    &[("browInnerUp", 0.9), ("browOuterUp", 0.95)],
    &[("browDown", 0.95)],
    &[("browDown_L", 0.8)],
    &[("browDown_R", 0.8)],
    &[("eyeBlink", 1.0)],
    &[("eyeBlink_L", 1.0), ("cheekSquint_L", 0.3)],
    &[("eyeBlink_R", 1.0), ("cheekSquint_R", 0.3)],
    &[("eyeWide", 0.9)],
    &[("eyeSquint", 0.9)],
    &[("eyeLookUp", 0.9), ("eyeWide", 0.2)],
    &[("eyeLookDown", 0.9)],
    &[("eyeLookOut_L", 0.9), ("eyeLookIn_R", 0.9)],
    &[("eyeLookIn_L", 0.9), ("eyeLookOut_R", 0.9)],
    &[("cheekSquint", 0.95)],
    &[("cheekSquint_L", 0.9)],
    &[("cheekSquint_R", 0.9)],
    &[("noseSneer", 0.95)],
    &[("noseSneer_L", 0.8)],
    &[("noseSneer_R", 0.8)],
    &[("cheekPuff", 0.95), ("mouthPress", 0.3)],
    &[("cheekPuff_L", 0.9)],
    &[("cheekPuff_R", 0.9)],
    &[("jawOpen", 0.95)],
    &[("jawForward", 0.9)],
    &[("jawLeft", 0.9)],
    &[("jawRight", 0.9)],
    &[("jawOpen", 0.75), ("mouthClose", 0.75)],
    &[("mouthSmile", 0.95)],
    &[("mouthSmile_L", 0.9), ("mouthDimple_L", 0.2)],
    &[("mouthSmile_R", 0.9), ("mouthDimple_R", 0.2)],
    &[("mouthDimple", 0.9)],
    &[("mouthFrown", 0.95)],
    &[("mouthStretch", 0.95)],
    &[("mouthPress", 0.95)],
    &[("mouthUpperUp", 0.9)],
    &[("mouthLowerDown", 0.9)],
    &[("mouthPucker", 0.95)],
    &[("mouthFunnel", 0.95)],
    &[("mouthRollLower", 0.9), ("mouthRollUpper", 0.9)],
    &[("mouthShrugLower", 0.9), ("mouthShrugUpper", 0.8)],
    &[("mouthLeft", 0.9)],
    &[("mouthRight", 0.9)],
];

/// Whole expressions.
pub const EXPRESSIONS: [Pose; 18] = [
    // Joy, small and great.
    &[("mouthSmile", 0.6), ("cheekSquint", 0.35), ("eyeSquint", 0.15)],
    &[("mouthSmile", 0.9), ("cheekSquint", 0.7), ("jawOpen", 0.35), ("eyeSquint", 0.4), ("mouthUpperUp", 0.25)],
    // Surprise, fear.
    &[("browInnerUp", 0.8), ("browOuterUp", 0.8), ("eyeWide", 0.8), ("jawOpen", 0.5), ("mouthFunnel", 0.15)],
    &[("browInnerUp", 0.9), ("browDown", 0.2), ("eyeWide", 0.7), ("mouthStretch", 0.7), ("jawOpen", 0.2)],
    // Anger, with closed lips and shouting.
    &[("browDown", 0.95), ("eyeSquint", 0.5), ("mouthPress", 0.7), ("noseSneer", 0.3), ("jawForward", 0.2)],
    &[("browDown", 0.8), ("noseSneer", 0.6), ("jawOpen", 0.6), ("mouthUpperUp", 0.5), ("mouthLowerDown", 0.6)],
    // Disgust, contempt.
    &[("noseSneer", 0.9), ("mouthUpperUp", 0.6), ("browDown", 0.5), ("cheekSquint", 0.4), ("mouthShrugLower", 0.3)],
    &[("mouthDimple_L", 0.7), ("mouthSmile_L", 0.35), ("mouthPress_L", 0.4), ("browOuterUp_R", 0.3)],
    // Sadness.
    &[("browInnerUp", 0.9), ("mouthFrown", 0.8), ("mouthShrugLower", 0.5), ("eyeSquint", 0.2), ("eyeLookDown", 0.3)],
    // Doubt, thought.
    &[("mouthShrugUpper", 0.5), ("mouthShrugLower", 0.7), ("browInnerUp", 0.5), ("mouthFrown", 0.35)],
    &[("mouthLeft", 0.6), ("mouthPucker", 0.3), ("browDown_R", 0.5), ("browOuterUp_L", 0.6)],
    &[("mouthRight", 0.6), ("mouthPress", 0.4), ("eyeSquint", 0.3)],
    // A kiss, a whistle, blowing.
    &[("mouthPucker", 0.9), ("eyeBlink", 0.3)],
    &[("mouthPucker", 0.7), ("mouthFunnel", 0.4), ("jawOpen", 0.1), ("browInnerUp", 0.4)],
    &[("cheekPuff", 0.8), ("mouthPucker", 0.4)],
    // Biting the lips, a yawn, chewing.
    &[("mouthRollLower", 0.8), ("mouthRollUpper", 0.4), ("browInnerUp", 0.4)],
    &[("jawOpen", 0.95), ("eyeSquint", 0.6), ("eyeBlink", 0.6), ("mouthStretch", 0.3), ("noseSneer", 0.2)],
    &[("jawOpen", 0.35), ("mouthClose", 0.34), ("jawLeft", 0.4), ("mouthPress", 0.2)],
];

/// Mouth shapes of speech; vowels first.
pub const VISEMES: [Pose; 15] = [
    &[("jawOpen", 0.48), ("mouthLowerDown", 0.22), ("mouthUpperUp", 0.10)],
    &[("jawOpen", 0.30), ("mouthStretch", 0.22), ("mouthLowerDown", 0.20), ("mouthSmile", 0.10)],
    &[("jawOpen", 0.14), ("mouthSmile", 0.28), ("mouthStretch", 0.25), ("mouthLowerDown", 0.25)],
    &[("jawOpen", 0.34), ("mouthFunnel", 0.50), ("mouthPucker", 0.18)],
    &[("jawOpen", 0.15), ("mouthPucker", 0.60), ("mouthFunnel", 0.28)],
    &[
        ("jawOpen", 0.06),
        ("mouthClose", 0.05),
        ("mouthPress", 0.45),
        ("mouthRollLower", 0.28),
        ("mouthRollUpper", 0.22),
    ],
    &[("jawOpen", 0.08), ("mouthRollLower", 0.50), ("mouthUpperUp", 0.32)],
    &[("jawOpen", 0.18), ("mouthLowerDown", 0.24), ("mouthUpperUp", 0.08)],
    &[("jawOpen", 0.06), ("mouthStretch", 0.26), ("mouthLowerDown", 0.30), ("mouthDimple", 0.16)],
    &[("jawOpen", 0.08), ("mouthFunnel", 0.42), ("mouthPucker", 0.22), ("mouthUpperUp", 0.18)],
    &[("jawOpen", 0.14), ("mouthPucker", 0.34), ("jawForward", 0.14)],
    &[("jawOpen", 0.26), ("mouthLowerDown", 0.14)],
    &[("jawOpen", 0.12), ("mouthPucker", 0.70)],
    &[("jawOpen", 0.20), ("mouthDimple", 0.12), ("mouthShrugUpper", 0.12)],
    &[("jawOpen", 0.05), ("mouthClose", 0.05), ("mouthPress", 0.55), ("mouthShrugLower", 0.15)],
];

/// How many of [`VISEMES`] are vowels.
pub const VOWELS: usize = 5;
