//! A small head for tests of nodes: a grid of skin with every kind of driver, regions, markers and motion for it.

use face_math::data::{Attachment, Curves, Driver, Markers, Part, Region, Regions, Rig, Shape};
use face_math::rig::{AttachOptions, attach_markers};
use glam::Vec3;
use wire::{FrameAxis, Value};

/// Repeatable numbers in −1..1 (a 64-bit linear congruential generator; Knuth's MMIX constants).
pub(crate) struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 8_388_608.0 - 1.0
    }

    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.roll(), self.roll(), self.roll())
    }
}

/// Vertices along each side of the grid.
const SIDE: usize = 5;

/// A rig of 25 vertices in 10 cm, with the channels `jawOpen`, `smile_L`, `smile_R` and `browUp`, a combination of the
/// first two and an in-between of the first.
pub(crate) fn rig() -> Rig {
    let mut dice = Dice(7);
    let mut neutral = Vec::new();
    let mut triangles = Vec::new();
    for y in 0..SIDE {
        for x in 0..SIDE {
            let (u, v) = (x as f32 / 4.0 - 0.5, y as f32 / 4.0 - 0.5);
            neutral.push(Vec3::new(u, v, -u * u) * 0.1 + dice.point() * 1e-3);
            if x + 1 < SIDE && y + 1 < SIDE {
                let (corner, above) = ((y * SIDE + x) as u32, ((y + 1) * SIDE + x) as u32);
                triangles.push([corner, corner + 1, above + 1]);
                triangles.push([corner, above + 1, above]);
            }
        }
    }
    let drivers = [
        ("jawOpen", Driver::Channel(0)),
        ("smile_L", Driver::Channel(1)),
        ("smile_R", Driver::Channel(2)),
        ("browUp", Driver::Channel(3)),
        ("jawOpen+smile_L", Driver::Combination(vec![0, 1])),
        ("jawOpen@0.5", Driver::InBetween { channel: 0, peak: 0.5 }),
    ];
    let count = neutral.len() as u32;
    let shapes = drivers.into_iter().enumerate().map(|(index, (name, driver))| {
        let size = if index < 4 { 5e-3 } else { 1e-3 };
        let deltas = (0..count).map(|_| dice.point() * size).collect();
        Shape { name: name.to_owned(), driver, vertices: (0..count).collect(), deltas }
    });
    Rig {
        name: "toy".to_owned(),
        parts: vec![Part { name: "face".to_owned(), vertices: 0..count, triangles, uvs: Vec::new(), colour: [0.5; 3] }],
        channels: ["jawOpen", "smile_L", "smile_R", "browUp"].map(str::to_owned).to_vec(),
        shapes: shapes.collect(),
        neutral,
        skin: Vec::new(),
        jaw_pivot_m: None,
        jaw: None,
        joints: Vec::new(),
    }
}

/// Twelve markers on the skin at rest, `m0` to `m11`.
pub(crate) fn neutral() -> Markers {
    let rig = rig();
    let places = rig.parts[0].triangles.iter().step_by(2).take(12);
    let middle = |triangle: &[u32; 3]| triangle.iter().map(|v| rig.neutral[*v as usize]).sum::<Vec3>() / 3.0;
    let positions: Vec<_> = places.map(middle).collect();
    let names = (0..positions.len()).map(|index| format!("m{index}")).collect();
    Markers::new(FrameAxis::new(1, 1.0), names, positions).unwrap()
}

/// Those markers on that rig.
pub(crate) fn attachment() -> Attachment {
    attach_markers(&rig(), &neutral(), &AttachOptions::default()).unwrap().attachment
}

/// Three regions over all markers: `jaw`, `lips`, and `brow`, which the papers do not know.
pub(crate) fn regions() -> Regions {
    let markers: Vec<String> = neutral().names().to_vec();
    let region = |name: &str, channels: &[&str]| Region {
        name: name.to_owned(),
        markers: markers.clone(),
        channels: channels.iter().map(|channel| (*channel).to_owned()).collect(),
    };
    let regions =
        vec![region("lips", &["smile_L", "smile_R"]), region("jaw", &["jawOpen"]), region("brow", &["browUp"])];
    Regions { regions }
}

/// Repeatable motion of all channels between 0 and 1, from frame 101.
pub(crate) fn curves(frames: usize, seed: u64) -> Curves {
    let mut dice = Dice(seed);
    let values = (0..frames * 4).map(|_| 0.5 + 0.5 * dice.roll()).collect();
    Curves::new(FrameAxis { first: 101, count: frames, rate_hz: 60.0 }, rig().channels, values).unwrap()
}

/// Frames `range` of a time-varying value.
pub(crate) fn cut<T: wire::Data + Clone>(value: &T, range: std::ops::Range<usize>) -> T {
    value.slice(range).unwrap().downcast_ref::<T>().unwrap().clone()
}

/// Whether the block of frames `range` of `whole` has the bits of `block`.
pub(crate) fn same_bits<T: wire::Data>(whole: &T, range: std::ops::Range<usize>, block: &T) -> bool {
    whole.slice(range).unwrap().encoded() == (block as &dyn Value).encoded()
}
