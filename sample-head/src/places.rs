//! Where the 68 landmarks (Multi-PIE order) and the painted markers sit on the head.

use crate::features::{Features, LIP_CHART, Side, V_MOUTH};
use crate::skin::{Place, Skin};
use glam::Vec2;
use std::ops::RangeInclusive;

/// A place on the face, on the performer's left half where it has a side.
#[derive(Debug, Clone, Copy)]
enum Spot {
    /// Chart coordinates u, v.
    Chart(f32, f32),
    /// On the upper (`true`) or lower edge of the eye, from its inner (0) to its outer corner (1).
    Lid(bool, f32),
    /// On the border of the upper or lower red, from the middle (0) to the corner (1).
    Red(bool, f32),
    /// On the edge of the upper or lower lip, from the middle to the corner.
    LipEdge(bool, f32),
}

use Spot::{Chart, Lid, LipEdge, Red};

/// Landmarks on the left half, by number; those on the midline too.
#[rustfmt::skip]
const LANDMARKS: [(usize, Spot); 39] = [
    (16, Chart(100.0, 28.0)), (15, Chart(96.0, 8.0)), (14, Chart(91.0, -12.0)), (13, Chart(84.0, -30.0)),
    (12, Chart(67.0, -50.0)), (11, Chart(49.0, -69.0)), (10, Chart(33.0, -77.0)), (9, Chart(17.0, -79.0)),
    (8, Chart(0.0, -80.0)),
    (22, Chart(11.5, 52.5)), (23, Chart(21.0, 55.0)), (24, Chart(31.0, 57.5)), (25, Chart(41.0, 57.0)), (26, Chart(51.0, 52.5)),
    (27, Chart(0.0, 36.0)), (28, Chart(0.0, 25.0)), (29, Chart(0.0, 14.0)), (30, Chart(0.0, 1.5)),
    (33, Chart(0.0, -11.5)), (34, Chart(6.0, -11.5)), (35, Chart(12.5, -11.0)),
    (42, Lid(true, 0.0)), (43, Lid(true, 0.33)), (44, Lid(true, 0.67)), (45, Lid(true, 1.0)),
    (46, Lid(false, 0.67)), (47, Lid(false, 0.33)),
    (51, Red(true, 0.0)), (52, Red(true, 0.26)), (53, Red(true, 0.62)), (54, LipEdge(true, 1.0)),
    (55, Red(false, 0.68)), (56, Red(false, 0.36)), (57, Red(false, 0.0)),
    (62, LipEdge(true, 0.0)), (63, LipEdge(true, 0.40)), (64, LipEdge(true, 0.86)),
    (65, LipEdge(false, 0.40)), (66, LipEdge(false, 0.0)),
];

/// The landmark that is a landmark's mirror image.
fn opposite(landmark: usize) -> usize {
    match landmark {
        0..=16 => 16 - landmark,
        17..=26 => 43 - landmark,
        27..=30 => landmark,
        31..=35 => 66 - landmark,
        36..=39 | 42..=45 => 81 - landmark,
        40 | 41 | 46 | 47 => 87 - landmark,
        48..=54 => 102 - landmark,
        55..=59 => 114 - landmark,
        60..=64 => 124 - landmark,
        _ => 132 - landmark,
    }
}

/// The markers that are no landmarks: left ones, or such on the midline, with the names of both sides (right, left).
#[rustfmt::skip]
const SKIN_MARKERS: [(&str, &str, Spot); 19] = [
    ("skin_00", "", Chart(0.0, -89.0)),
    ("skin_01", "skin_02", Chart(55.0, -9.0)),
    ("skin_03", "", Chart(0.0, 92.0)),
    ("skin_04", "skin_05", Chart(76.0, 14.0)),
    ("skin_06", "skin_07", Chart(64.0, 86.0)),
    ("skin_08", "skin_09", Chart(34.0, 95.0)),
    ("skin_10", "skin_11", Chart(48.0, -38.0)),
    ("skin_12", "skin_13", Chart(30.0, 6.0)),
    ("skin_14", "skin_15", Chart(26.0, -87.0)),
    ("skin_16", "skin_17", Chart(53.0, 16.0)),
    ("skin_18", "skin_19", Chart(20.0, 81.0)),
    ("skin_20", "skin_21", Chart(14.5, 14.0)),
    ("skin_22", "skin_23", Chart(48.0, 79.0)),
    ("skin_24", "skin_25", Chart(68.0, 37.0)),
    ("skin_26", "skin_27", Chart(73.0, -6.0)),
    ("skin_28", "skin_29", Chart(36.0, -18.0)),
    ("skin_30", "", Chart(-9.0, -85.0)),
    ("skin_31", "skin_32", Chart(68.0, -29.0)),
    ("skin_33", "", Chart(-66.0, 67.0)),
];

/// Head markers, which do not move with the face: chart coordinates.
const HEAD_MARKERS: [(&str, f32, f32); 4] =
    [("head_0", 0.0, 150.0), ("head_1", -160.0, 60.0), ("head_2", 150.0, 62.0), ("head_3", -92.0, 112.0)];

/// The skin's vertex at a spot, on the left half; `mirrored` for its mirror image.
fn vertex(skin: &Skin, features: &Features, spot: Spot) -> u32 {
    let nearest = |wanted: Vec2, side: Option<Side>| {
        let far = |vertex: &u32| {
            let point = &skin.points[*vertex as usize];
            (Vec2::new(point.u, point.v) - wanted).length_squared()
        };
        let fits = |vertex: &u32| {
            let point = &skin.points[*vertex as usize];
            point.place == Place::Outside && side.is_none_or(|side| point.side == side)
        };
        let order = |a: &u32, b: &u32| far(a).total_cmp(&far(b));
        (0..skin.points.len() as u32).filter(fits).min_by(order).unwrap_or_default()
    };
    let on_edge = |edge: &[u32], wanted_u: f32| {
        let far = |vertex: &u32| (skin.points[*vertex as usize].u - wanted_u).abs();
        edge.iter().copied().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or_default()
    };
    let [inner, outer] = features.eye_corners;
    match spot {
        Chart(u, v) => nearest(Vec2::new(u, v), None),
        Lid(upper, along) => {
            let eye = &skin.eyes[0];
            on_edge(if upper { &eye.upper } else { &eye.lower }, inner + (outer - inner) * along)
        }
        Red(upper, along) => {
            let v = V_MOUTH + if upper { LIP_CHART } else { -LIP_CHART };
            nearest(Vec2::new(along * features.mouth(), v), None)
        }
        LipEdge(upper, along) => {
            let mouth = &skin.mouth;
            on_edge(if upper { &mouth.upper } else { &mouth.lower }, along * features.mouth())
        }
    }
}

/// The skin's vertices of the 68 landmarks, in Multi-PIE order.
pub fn landmarks(skin: &Skin, features: &Features) -> [u32; 68] {
    let mut found = [0; 68];
    for (landmark, spot) in LANDMARKS {
        let left = vertex(skin, features, spot);
        found[landmark] = left;
        found[opposite(landmark)] = skin.mirror[left as usize];
    }
    found
}

/// Markers: names and vertices of the skin.
pub type Named = Vec<(String, u32)>;

/// Names of the markers that are landmarks: beginning, first number, digits, landmarks.
const LANDMARK_MARKERS: [(&str, usize, usize, RangeInclusive<usize>); 9] = [
    ("jawline_", 3, 2, 3..=13),
    ("brow_R_", 0, 1, 17..=21),
    ("brow_L_", 0, 1, 22..=26),
    ("nose_bridge_", 0, 1, 27..=30),
    ("nose_base_", 0, 1, 31..=35),
    ("eyelid_R_", 0, 1, 36..=41),
    ("eyelid_L_", 0, 1, 42..=47),
    ("lip_outer_", 0, 2, 48..=59),
    ("lip_inner_", 0, 1, 60..=67),
];

/// The markers on the face without pupils, and those on the head.
pub fn skin_markers(skin: &Skin, features: &Features) -> (Named, Named) {
    let vertices = landmarks(skin, features);
    let mut named: Named = Vec::new();
    for (stem, first, digits, run) in LANDMARK_MARKERS {
        let numbered = vertices[run].iter().zip(first..);
        named.extend(numbered.map(|(vertex, number)| (format!("{stem}{number:0digits$}"), *vertex)));
    }
    let mut extra: Named = Vec::new();
    for (right, left, spot) in SKIN_MARKERS {
        let at = match spot {
            Chart(u, v) if u < 0.0 => skin.mirror[vertex(skin, features, Chart(-u, v)) as usize],
            _ => vertex(skin, features, spot),
        };
        if left.is_empty() {
            extra.push((right.to_owned(), at));
        } else {
            extra.push((left.to_owned(), at));
            extra.push((right.to_owned(), skin.mirror[at as usize]));
        }
    }
    extra.sort();
    named.extend(extra);
    let head = HEAD_MARKERS.iter().map(|(name, u, v)| {
        let at = vertex(skin, features, Chart(u.abs(), *v));
        ((*name).to_owned(), if *u < 0.0 { skin.mirror[at as usize] } else { at })
    });
    (named, head.collect())
}
