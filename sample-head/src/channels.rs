//! The 53 channels, the combination correctives and the in-betweens of the head, by name.

/// Channels in the order of the curves: those of `ARKit`, with `_L` and `_R`, brows and cheeks split by side.
#[rustfmt::skip]
pub const CHANNELS: [&str; 53] = [
    "browDown_L", "browDown_R", "browInnerUp_L", "browInnerUp_R", "browOuterUp_L", "browOuterUp_R",
    "cheekPuff_L", "cheekPuff_R", "cheekSquint_L", "cheekSquint_R",
    "eyeBlink_L", "eyeBlink_R", "eyeLookDown_L", "eyeLookDown_R", "eyeLookIn_L", "eyeLookIn_R",
    "eyeLookOut_L", "eyeLookOut_R", "eyeLookUp_L", "eyeLookUp_R", "eyeSquint_L", "eyeSquint_R",
    "eyeWide_L", "eyeWide_R",
    "jawForward", "jawLeft", "jawOpen", "jawRight",
    "mouthClose", "mouthDimple_L", "mouthDimple_R", "mouthFrown_L", "mouthFrown_R", "mouthFunnel", "mouthLeft",
    "mouthLowerDown_L", "mouthLowerDown_R", "mouthPress_L", "mouthPress_R", "mouthPucker", "mouthRight",
    "mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper", "mouthSmile_L", "mouthSmile_R",
    "mouthStretch_L", "mouthStretch_R", "mouthUpperUp_L", "mouthUpperUp_R", "noseSneer_L", "noseSneer_R",
];

/// Combination correctives, in alphabetical order of their channels.
pub const COMBINATIONS: [&str; 13] = [
    "cheekSquint_L+mouthSmile_L",
    "cheekSquint_R+mouthSmile_R",
    "eyeBlink_L+eyeLookDown_L",
    "eyeBlink_R+eyeLookDown_R",
    "eyeBlink_L+eyeSquint_L",
    "eyeBlink_R+eyeSquint_R",
    "jawOpen+mouthFunnel",
    "jawOpen+mouthPucker",
    "jawOpen+mouthSmile_L",
    "jawOpen+mouthSmile_R",
    "jawOpen+mouthStretch_L",
    "jawOpen+mouthStretch_R",
    "mouthFunnel+mouthPucker",
];

/// In-betweens.
pub const IN_BETWEENS: [&str; 2] = ["eyeBlink_L@0.5", "eyeBlink_R@0.5"];

/// The same name for the other side: `_L` and `_R`, `Left` and `Right` exchanged; others stay.
pub fn mirrored(name: &str) -> String {
    let swap = |channel: &str| {
        if let Some(stem) = channel.strip_suffix("_L") {
            format!("{stem}_R")
        } else if let Some(stem) = channel.strip_suffix("_R") {
            format!("{stem}_L")
        } else if let Some(stem) = channel.strip_suffix("Left") {
            format!("{stem}Right")
        } else if let Some(stem) = channel.strip_suffix("Right") {
            format!("{stem}Left")
        } else {
            channel.to_owned()
        }
    };
    if let Some((channel, peak)) = name.split_once('@') {
        return format!("{}@{peak}", swap(channel));
    }
    name.split('+').map(swap).collect::<Vec<_>>().join("+")
}
