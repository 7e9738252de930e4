//! The seven regions of the face: which markers and which channels belong together.

use crate::channels::CHANNELS;
use face_math::data::{Region, Regions};

/// Groups of markers by the beginnings of their names, or whole names.
const LIPS: Stems = &["lip_outer_", "lip_inner_"];
const NOSE: Stems = &["nose_bridge_1", "nose_bridge_2", "nose_bridge_3", "nose_base_"];
const LOWER_SKIN: Stems = &[
    "skin_00", "skin_01", "skin_02", "skin_10", "skin_11", "skin_14", "skin_15", "skin_28", "skin_29", "skin_30",
    "skin_31", "skin_32",
];
const FOREHEAD: Stems = &[
    "skin_03", "skin_06", "skin_07", "skin_08", "skin_09", "skin_18", "skin_19", "skin_22", "skin_23", "skin_24",
    "skin_25", "skin_33",
];
const CHEEKS: Stems = &[
    "skin_01", "skin_02", "skin_04", "skin_05", "skin_12", "skin_13", "skin_16", "skin_17", "skin_20", "skin_21",
    "skin_26", "skin_27", "skin_28", "skin_29",
];
const BROWS: Stems = &["brow_R_", "brow_L_"];
const JAWLINE: Stems = &["jawline_"];
const LIDS: Stems = &["eyelid_R_", "eyelid_L_"];
const PUPILS: Stems = &["pupil_"];

/// Beginnings of names, or whole names.
type Stems = &'static [&'static str];

/// Name, groups of markers, beginnings of the names of its channels. Every region sees the root of the nose, which
/// hardly moves.
const REGIONS: [(&str, &[Stems], Stems); 7] = [
    ("upper-face", &[BROWS, FOREHEAD, NOSE, CHEEKS], &["brow"]),
    ("lower-face", &[LIPS, LOWER_SKIN, JAWLINE, NOSE], MOUTH),
    ("jaw", &[JAWLINE, LIPS, LOWER_SKIN], &["jaw"]),
    ("lips", &[LIPS, LOWER_SKIN, NOSE], LIP_CHANNELS),
    ("cheek", &[CHEEKS, BROWS, NOSE, LIPS], &["cheek", "nose"]),
    ("eyelids", &[NOSE, LIDS], &["eyeBlink", "eyeSquint", "eyeWide"]),
    ("eyeballs", &[LIDS, PUPILS], &["eyeLook"]),
];
#[rustfmt::skip]
const MOUTH: Stems = &[
    "mouthDimple", "mouthFrown", "mouthLeft", "mouthLowerDown", "mouthRight", "mouthSmile", "mouthStretch",
    "mouthUpperUp",
];
const LIP_CHANNELS: Stems = &["mouthFunnel", "mouthPucker", "mouthRoll", "mouthPress", "mouthClose", "mouthShrug"];

/// The regions over the markers `names`.
pub fn regions(names: &[String]) -> Regions {
    let begins = |name: &str, stems: &[&str]| stems.iter().any(|stem| name.starts_with(stem));
    let regions = REGIONS
        .iter()
        .map(|(region, groups, stems)| {
            let mut markers = vec!["nose_bridge_0".to_owned()];
            for group in *groups {
                markers.extend(names.iter().filter(|name| begins(name, group)).cloned());
            }
            let channels = CHANNELS.iter().filter(|channel| begins(channel, stems));
            Region {
                name: (*region).to_owned(),
                markers: unique(markers),
                channels: channels.map(|channel| (*channel).to_owned()).collect(),
            }
        })
        .collect();
    Regions { regions }
}

fn unique(names: Vec<String>) -> Vec<String> {
    let mut seen = std::collections::BTreeSet::new();
    names.into_iter().filter(|name| seen.insert(name.clone())).collect()
}
