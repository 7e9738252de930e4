//! A small head with joints for tests: a face, teeth and one eyeball, and motion for it.

use super::joints::{JointOptions, add_joints, pose_channels};
use super::{Keep, fit_pose_shapes, unpose_meshes};
use crate::data::{Curves, Driver, Meshes, Part, Rig, Shape};
use crate::rig::Puppet;
use crate::rig::toy::Dice;
use glam::Vec3;
use wire::FrameAxis;

/// The middle of the eyeball.
pub(crate) const EYE: Vec3 = Vec3::new(0.03, 0.04, 0.05);

/// Where the jaw turns.
pub(crate) const JAW: Vec3 = Vec3::new(0.0, -0.01, -0.06);

/// Face (8 × 8), teeth (12), eyeball (20), without joints. The face's skin grows from brow to chin.
pub(crate) fn bare_head() -> Rig {
    let mut dice = Dice(29);
    let side = 8;
    let (mut neutral, mut triangles, mut skin) = (Vec::new(), Vec::new(), Vec::new());
    for y in 0..side {
        for x in 0..side {
            let (u, v) = (x as f32 / 7.0 - 0.5, y as f32 / 7.0 - 0.5);
            neutral.push(Vec3::new(u * 0.12, v * 0.16, 0.05 - 0.1 * u * u) + dice.point() * 5e-4);
            skin.push((0.6 - 2.0 * (v + 0.3)).clamp(0.0, 1.0));
            if x + 1 < side && y + 1 < side {
                let corner = (y * side + x) as u32;
                triangles.push([corner, corner + 1, corner + 9]);
                triangles.push([corner, corner + 9, corner + 8]);
            }
        }
    }
    let part = |name: &str, vertices: std::ops::Range<u32>, triangles| Part {
        name: name.to_owned(),
        vertices,
        triangles,
        uvs: Vec::new(),
        colour: [0.5; 3],
    };
    let face = part("face", 0..64, triangles);
    neutral.extend((0..12).map(|_| Vec3::new(0.0, -0.04, 0.03) + dice.point() * 0.02));
    neutral.extend((0..20).map(|_| EYE + dice.point().normalize() * 0.012));
    skin.resize(neutral.len(), 0.0);
    let parts = vec![face, part("teeth", 64..76, vec![[64, 65, 66]]), part("eyeball", 76..96, vec![[76, 77, 78]])];
    let (channels, shapes, joints) = (Vec::new(), Vec::new(), Vec::new());
    Rig { name: "toy".into(), parts, neutral, channels, shapes, skin, jaw_pivot_m: Some(JAW), jaw: None, joints }
}

/// The same with a jaw and an eye, and small shares of the eye around it.
pub(crate) fn jointed_head() -> Rig {
    let joint = |name: &str, part: &str, moves| JointOptions {
        name: name.into(),
        parts: vec![part.into()],
        moves,
        pivot_m: None,
    };
    let mut rig = add_joints(&bare_head(), &[joint("jaw", "teeth", true), joint("eye", "eyeball", false)]).unwrap();
    for vertex in 0..64 {
        if rig.jaw.as_ref().unwrap().weights[vertex] == 0.0 && rig.neutral[vertex].distance(EYE) < 0.025 {
            rig.joints[0].skin.weights[vertex] = 0.2;
        }
    }
    rig
}

/// Repeatable poses of all joints, the first frame at rest.
pub(crate) fn pose_curves(rig: &Rig, frames: usize) -> Curves {
    let mut dice = Dice(31);
    let names = pose_channels(rig).unwrap();
    let scale = |name: &str| if name.ends_with("_m") { 4e-3 } else { 0.25 };
    let values = (0..frames)
        .flat_map(|frame| names.iter().map(move |name| (frame, name)))
        .map(|(frame, name)| if frame == 0 { 0.0 } else { dice.roll() * scale(name) })
        .collect();
    Curves::new(FrameAxis { first: 100, count: frames, rate_hz: 60.0 }, names, values).unwrap()
}

/// The same curves at 0.
pub(crate) fn still(curves: &Curves) -> Curves {
    Curves::new(curves.frame_axis(), curves.channels().to_vec(), vec![0.0; curves.values().len()]).unwrap()
}

/// The meshes of a rig at curves; channels that the curves lack are 0.
pub(crate) fn evaluated(rig: &Rig, curves: &Curves) -> Meshes {
    let puppet = Puppet::new(rig).unwrap();
    let arranged = curves.arrange(&rig.channels, Some(0.0)).unwrap();
    let positions =
        (0..curves.frames()).flat_map(|frame| puppet.vertices(arranged.frame(frame)).unwrap()).collect::<Vec<_>>();
    Meshes::new(curves.frame_axis(), rig.parts.clone(), rig.neutral.len(), positions).unwrap()
}

/// Adds channels with shapes over the face to a rig: `s0`, `s1` …, each at most `reach_m` long.
pub(crate) fn with_shapes(rig: &Rig, count: usize, reach_m: f32) -> Rig {
    let mut dice = Dice(37);
    let mut rig = rig.clone();
    for index in 0..count {
        let (vertices, deltas) = (0..64).map(|vertex| (vertex, dice.point() * reach_m)).unzip();
        let driver = Driver::Channel(rig.channels.len() as u32);
        rig.channels.push(format!("s{index}"));
        rig.shapes.push(Shape { name: format!("s{index}"), driver, vertices, deltas });
    }
    rig
}

/// Repeatable values of the channels `names`, up to `reach`, the first frame 0.
pub(crate) fn values(names: &[String], frames: usize, reach: f32, seed: u64) -> Curves {
    let mut dice = Dice(seed);
    let value = |at: usize| if at < names.len() { 0.0 } else { dice.roll() * reach };
    let values = (0..frames * names.len()).map(value).collect();
    Curves::new(FrameAxis { first: 100, count: frames, rate_hz: 60.0 }, names.to_vec(), values).unwrap()
}

/// Two sets of curves with the same frames as one.
pub(crate) fn beside(a: &Curves, b: &Curves) -> Curves {
    let names = [a.channels(), b.channels()].concat();
    let values = (0..a.frames()).flat_map(|frame| [a.frame(frame), b.frame(frame)].concat()).collect();
    Curves::new(a.frame_axis(), names, values).unwrap()
}

/// A head whose skin bends with jaw and eyes by pose shapes, poses, and the meshes they make: 14 frames.
pub(crate) fn bent_head() -> (Rig, Curves, Meshes) {
    let base = jointed_head();
    let poses = pose_curves(&base, 14);
    let mut dice = Dice(91);
    let bent = evaluated(&base, &poses);
    let bent = bent.positions().iter().map(|point| *point + dice.point() * 1e-3).collect();
    let bent = Meshes::new(poses.frame_axis(), base.parts.clone(), 96, bent).unwrap();
    let unposed = unpose_meshes(&base, &bent, &poses, Keep::PoseShapes).unwrap();
    let rig = fit_pose_shapes(&base, &unposed, &poses, 0.0).unwrap();
    let meshes = evaluated(&rig, &poses);
    (rig, poses, meshes)
}
