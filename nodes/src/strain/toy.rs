//! The sample head as a strain rig, for tests of these nodes: its face, lower teeth and eyeballs.

use crate::testing::HEAD;
use face_math::data::{Attachment, Curves, Meshes, Rig, SurfacePoint};
use face_math::rig::{Puppet, SkinJawOptions, keep_parts, keep_points, skin_jaw};
use face_math::strain::{JointOptions, add_joints};
use std::sync::LazyLock;
use wire::FrameAxis;

const PARTS: [&str; 4] = ["face", "teeth_lower", "eyeball_L", "eyeball_R"];

/// The head with its jaw split off, with few parts.
pub(crate) static ACTOR: LazyLock<Rig> = LazyLock::new(|| {
    let skinned = skin_jaw(&HEAD.rig, &SkinJawOptions::default()).unwrap().rig;
    keep_parts(&skinned, |part| PARTS.contains(&part.name.as_str())).checked().unwrap()
});

/// The same with joints and no shapes.
pub(crate) static BASE: LazyLock<Rig> = LazyLock::new(|| {
    let joint = |name: &str, part: &str, moves| JointOptions {
        name: name.into(),
        parts: vec![part.into()],
        moves,
        pivot_m: None,
    };
    let joints =
        [joint("jaw", "teeth_lower", true), joint("eye_L", "eyeball_L", false), joint("eye_R", "eyeball_R", false)];
    add_joints(&ACTOR, &joints).unwrap()
});

/// Every so many-th frame of the range of motion.
pub(crate) fn motion(step: usize) -> Curves {
    let all = HEAD.range_of_motion.arrange(&ACTOR.channels, None).unwrap();
    let frames: Vec<usize> = (0..all.frames()).step_by(step).collect();
    let values = frames.iter().flat_map(|frame| all.frame(*frame)).copied().collect();
    Curves::new(FrameAxis::new(frames.len(), 60.0), all.channels().to_vec(), values).unwrap()
}

/// The meshes of a rig at curves.
pub(crate) fn evaluated(rig: &Rig, curves: &Curves) -> Meshes {
    let puppet = Puppet::new(rig).unwrap();
    let arranged = curves.arrange(&rig.channels, Some(0.0)).unwrap();
    let frames = (0..curves.frames()).flat_map(|frame| puppet.vertices(arranged.frame(frame)).unwrap());
    Meshes::new(curves.frame_axis(), rig.parts.clone(), rig.neutral.len(), frames.collect()).unwrap()
}

/// The landmarks on the actor.
pub(crate) fn landmarks() -> Attachment {
    let triangles = || HEAD.rig.parts.iter().flat_map(|part| &part.triangles);
    let point = |(number, vertex): (usize, &u32)| {
        let triangle = *triangles().find(|triangle| triangle.contains(vertex)).unwrap();
        let weights = triangle.map(|own| f32::from(u8::from(own == *vertex)));
        SurfacePoint { name: format!("landmark_{number:02}"), vertices: triangle, weights, distance_m: 0.0 }
    };
    let all = Attachment { points: HEAD.landmarks.iter().enumerate().map(point).collect() };
    keep_points(&HEAD.rig, &all, |part| PARTS.contains(&part.name.as_str()))
}
