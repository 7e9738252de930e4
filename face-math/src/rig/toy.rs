//! A small made-up head for tests: a grid of skin over a jaw, with every kind of driver.

use crate::data::{Driver, JawMotion, JawSkin, Joint, Part, Rig, Shape};
use glam::Vec3;

/// Repeatable numbers in −1..1 (a 64-bit linear congruential generator; Knuth's MMIX constants).
pub(crate) struct Dice(pub u64);

impl Dice {
    pub(crate) fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 8_388_608.0 - 1.0
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.roll(), self.roll(), self.roll())
    }
}

/// A rig of `side × side` vertices in 10 cm and of `channels` channels `c0`, `c1` …, each with a shape of its own,
/// one combination of the first two, and in-betweens of the first and the last.
pub(crate) fn rig(side: usize, channels: usize) -> Rig {
    let mut dice = Dice(7);
    let mut neutral = Vec::new();
    let mut triangles = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let (u, v) = (x as f32 / (side - 1) as f32, y as f32 / (side - 1) as f32);
            neutral.push(Vec3::new(u - 0.5, v - 0.5, -(u - 0.5).powi(2)) * 0.1 + dice.point() * 1e-3);
            if x + 1 < side && y + 1 < side {
                let corner = (y * side + x) as u32;
                let below = corner + side as u32;
                triangles.push([corner, corner + 1, below + 1]);
                triangles.push([corner, below + 1, below]);
            }
        }
    }
    let last = channels as u32 - 1;
    let mut drivers: Vec<_> = (0..=last).map(|c| (format!("c{c}"), Driver::Channel(c))).collect();
    drivers.push(("c0+c1".into(), Driver::Combination(vec![0, 1])));
    drivers.push(("c0@0.5".into(), Driver::InBetween { channel: 0, peak: 0.5 }));
    drivers.push((format!("c{last}@0.3"), Driver::InBetween { channel: last, peak: 0.3 }));
    drivers.push((format!("c{last}@0.7"), Driver::InBetween { channel: last, peak: 0.7 }));
    let shapes = drivers
        .into_iter()
        .map(|(name, driver)| {
            let vertices: Vec<u32> = (0..neutral.len() as u32).filter(|_| dice.roll() > -0.3).collect();
            let deltas = vertices.iter().map(|_| dice.point() * 5e-3).collect();
            Shape { name, driver, vertices, deltas }
        })
        .collect();
    Rig {
        name: "toy".into(),
        parts: vec![Part {
            name: "face".into(),
            vertices: 0..neutral.len() as u32,
            triangles,
            uvs: Vec::new(),
            colour: [0.5; 3],
        }],
        neutral,
        channels: (0..channels).map(|c| format!("c{c}")).collect(),
        shapes,
        skin: Vec::new(),
        jaw_pivot_m: None,
        jaw: None,
        joints: Vec::new(),
    }
}

/// The same with a jaw joint that channels 0 and 1, their combination and the first in-between move.
pub(crate) fn jawed(side: usize, channels: usize) -> Rig {
    let mut rig = rig(side, channels);
    let mut dice = Dice(11);
    let shapes = [0, 1, channels as u32, channels as u32 + 1];
    let motions = shapes
        .iter()
        .map(|shape| JawMotion { shape: *shape, euler_rad: dice.point() * 0.3, translation_m: dice.point() * 0.01 })
        .collect();
    let weights = rig.neutral.iter().map(|_| (0.5 + 0.7 * dice.roll()).clamp(0.0, 1.0)).collect();
    rig.jaw = Some(JawSkin { weights, motions, ..JawSkin::default() });
    rig
}

/// The same with a jaw that turns about a point of its own, an eye that channels 2 and 3 turn, and pose correctives of
/// both.
pub(crate) fn jointed(side: usize, channels: usize) -> Rig {
    let mut rig = jawed(side, channels);
    let mut dice = Dice(13);
    if let Some(jaw) = &mut rig.jaw {
        jaw.pivot_m = Vec3::new(0.01, -0.03, 0.02);
        jaw.motions.retain(|motion| motion.shape < 2);
        jaw.weights.iter_mut().for_each(|weight| *weight *= 0.6);
    }
    let motion = |shape, dice: &mut Dice| JawMotion { shape, euler_rad: dice.point() * 0.4, translation_m: Vec3::ZERO };
    let motions = vec![motion(2, &mut dice), motion(3, &mut dice)];
    let weights = rig.neutral.iter().map(|_| (0.4 * dice.roll()).max(0.0)).collect();
    let skin = JawSkin { pivot_m: Vec3::new(-0.02, 0.03, 0.01), weights, motions };
    rig.joints.push(Joint { name: "eye".into(), skin });
    for (joint, row, column) in [(0, 1, 1), (0, 2, 1), (1, 0, 2)] {
        let vertices: Vec<u32> = (0..rig.neutral.len() as u32).collect();
        let deltas = vertices.iter().map(|_| dice.point() * 5e-3).collect();
        let name = format!("turn_{joint}_{row}{column}");
        rig.shapes.push(Shape { name, driver: Driver::Turn { joint, row, column }, vertices, deltas });
    }
    rig
}
