//! Joints of a strain rig and their poses: θ of Animatomy, as channels of a rig and as curves. The first step of training.
//!
//! A joint takes x to R (x − c) + c + t, about its place c (metres). R = Rz·Ry·Rx by three angles in radians, t in metres.
//! Its channels carry those numbers themselves (`jaw_turn_x_rad`, `jaw_move_y_m`), so that poses are curves like all others.

use super::error::{StrainError, same};
use crate::data::{Curves, DataError, Driver, JawMotion, JawSkin, Joint, Meshes, Rig, Shape, nearest_name};
use crate::rig::{JawPose, fit_rigid};
use faer::Mat;
use faer::prelude::Solve;
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Endings of a joint's channels: the three angles, then the three translations.
pub const POSE_CHANNELS: [&str; 6] = ["turn_x_rad", "turn_y_rad", "turn_z_rad", "move_x_m", "move_y_m", "move_z_m"];

/// A joint that a rig is to have.
#[derive(Debug, Clone, PartialEq)]
pub struct JointOptions {
    /// Name of the joint; the first one is called `jaw`.
    pub name: String,
    /// Parts that follow it wholly: the lower teeth, an eyeball.
    pub parts: Vec<String>,
    /// Whether it may move as well as turn.
    pub moves: bool,
    /// Where it stands, in metres: where not given, the jaw's own joint, or the middle of a ball through the parts.
    pub pivot_m: Option<Vec3>,
}

/// The surface of `rig` with joints and nothing else: its channels are the joints' poses, its weights the given start W⁽ⁱ⁾
/// of section A.1 (the rig's own skin for the jaw, 1 for the parts that follow a joint wholly).
///
/// # Errors
/// Where a part is not there, or the place of a joint is neither given nor to be found.
pub fn add_joints(rig: &Rig, joints: &[JointOptions]) -> Result<Rig, StrainError> {
    let mut bare = Rig {
        name: rig.name.clone(),
        parts: rig.parts.clone(),
        neutral: rig.neutral.clone(),
        channels: Vec::new(),
        shapes: Vec::new(),
        skin: Vec::new(),
        jaw_pivot_m: None,
        jaw: None,
        joints: Vec::new(),
    };
    let mut taken = vec![false; rig.neutral.len()];
    let mut own = Vec::with_capacity(joints.len());
    for joint in joints {
        let mut vertices = Vec::new();
        for name in &joint.parts {
            let part = rig.part(name).ok_or_else(|| DataError::Missing {
                what: "part",
                name: name.clone(),
                near: nearest_name(name, rig.parts.iter().map(|part| part.name.as_str())),
            })?;
            vertices.extend(part.vertices.clone());
        }
        for vertex in &vertices {
            taken[*vertex as usize] = true;
        }
        own.push(vertices);
    }
    for (place, (joint, vertices)) in joints.iter().zip(&own).enumerate() {
        let mut weights = match (&rig.jaw, rig.skin.is_empty()) {
            (Some(jaw), _) if place == 0 => jaw.weights.clone(),
            (None, false) if place == 0 => rig.skin.clone(),
            _ => vec![0.0; rig.neutral.len()],
        };
        weights.iter_mut().zip(&taken).filter(|(_, taken)| **taken).for_each(|(weight, _)| *weight = 0.0);
        for vertex in vertices {
            weights[*vertex as usize] = 1.0;
        }
        let stands = joint.pivot_m.or(if place == 0 { rig.jaw_pivot_m } else { None });
        let pivot_m = match stands {
            Some(pivot) => pivot,
            None if vertices.len() < 4 => return Err(StrainError::NothingRigid { joint: joint.name.clone() }),
            None => ball(vertices.iter().map(|vertex| rig.neutral[*vertex as usize].as_dvec3()))?.as_vec3(),
        };
        let mut motions = Vec::new();
        for (index, ending) in POSE_CHANNELS.iter().enumerate().take(if joint.moves { 6 } else { 3 }) {
            let name = format!("{}_{ending}", joint.name);
            let mut axis = Vec3::ZERO;
            axis[index % 3] = 1.0;
            let (euler_rad, translation_m) = if index < 3 { (axis, Vec3::ZERO) } else { (Vec3::ZERO, axis) };
            motions.push(JawMotion { shape: bare.shapes.len() as u32, euler_rad, translation_m });
            let driver = Driver::Channel(bare.channels.len() as u32);
            bare.channels.push(name.clone());
            bare.shapes.push(Shape { name, driver, vertices: Vec::new(), deltas: Vec::new() });
        }
        let skin = JawSkin { pivot_m, weights, motions };
        if place == 0 {
            bare.jaw_pivot_m = Some(pivot_m);
            bare.jaw = Some(skin);
        } else {
            bare.joints.push(Joint { name: joint.name.clone(), skin });
        }
    }
    Ok(bare.checked()?)
}

/// The middle of the ball that points lie on, by algebraic least squares: 2 c·x + k = x·x over all points x (metres).
fn ball(points: impl Iterator<Item = DVec3>) -> Result<DVec3, StrainError> {
    let points: Vec<DVec3> = points.collect();
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let (mut normal, mut right) = (Mat::<f64>::zeros(4, 4), Mat::<f64>::zeros(4, 1));
    for point in &points {
        let x = *point - mean;
        let row = [2.0 * x.x, 2.0 * x.y, 2.0 * x.z, 1.0];
        for i in 0..4 {
            right[(i, 0)] += row[i] * x.length_squared();
            for j in 0..4 {
                normal[(i, j)] += row[i] * row[j];
            }
        }
    }
    let solved = normal.partial_piv_lu().solve(&right);
    let centre = DVec3::new(solved[(0, 0)], solved[(1, 0)], solved[(2, 0)]);
    if centre.is_finite() { Ok(mean + centre) } else { Err(StrainError::Decomposition { what: "the ball of a joint" }) }
}

/// One joint of a rig, by name.
#[derive(Debug, Clone, Copy)]
pub struct NamedJoint<'r> {
    /// Its name.
    pub name: &'r str,
    /// Who follows it, and what moves it.
    pub skin: &'r JawSkin,
}

/// The joints of a rig, the jaw first.
pub fn joints(rig: &Rig) -> Vec<NamedJoint<'_>> {
    let jaw = rig.jaw.iter().map(|skin| NamedJoint { name: "jaw", skin });
    jaw.chain(rig.joints.iter().map(|joint| NamedJoint { name: &joint.name, skin: &joint.skin })).collect()
}

/// Where all joints stand in every frame of some curves.
#[derive(Debug, Clone)]
pub struct Poses {
    joints: usize,
    poses: Vec<JawPose>,
}

impl Poses {
    /// The poses of `rig`'s joints at `curves`, which must hold the channels that move them.
    ///
    /// # Errors
    /// Where a channel is not there or holds NaN, or the rig has no joints that channels alone move.
    pub fn new(rig: &Rig, curves: &Curves) -> Result<Self, StrainError> {
        let joints = joints(rig);
        if joints.is_empty() {
            return Err(StrainError::NoJoints { rig: rig.name.clone() });
        }
        let names = pose_channels(rig)?;
        let arranged = curves.arrange(&names, None)?;
        if let Some(at) = arranged.values().iter().position(|value| !value.is_finite()) {
            let frame = frame_number(curves, at / names.len());
            return Err(StrainError::NotFinite { what: "pose channel", index: at % names.len(), frame });
        }
        let mut poses = Vec::with_capacity(curves.frames() * joints.len());
        for frame in 0..curves.frames() {
            let mut values = arranged.frame(frame).iter();
            for joint in &joints {
                let (mut euler, mut translation) = (DVec3::ZERO, DVec3::ZERO);
                for (motion, value) in joint.skin.motions.iter().zip(&mut values) {
                    euler += f64::from(*value) * motion.euler_rad.as_dvec3();
                    translation += f64::from(*value) * motion.translation_m.as_dvec3();
                }
                poses.push(JawPose::about(joint.skin.pivot_m.as_dvec3(), euler, translation));
            }
        }
        Ok(Self { joints: joints.len(), poses })
    }

    /// The joints of one frame, the jaw first.
    pub fn frame(&self, frame: usize) -> &[JawPose] {
        &self.poses[frame * self.joints..(frame + 1) * self.joints]
    }
}

/// The channels that move the joints, joint by joint.
///
/// # Errors
/// Where something else than a channel moves one.
pub fn pose_channels(rig: &Rig) -> Result<Vec<String>, StrainError> {
    let motions = joints(rig).into_iter().flat_map(|joint| &joint.skin.motions);
    let name = |motion: &JawMotion| match rig.shapes[motion.shape as usize].driver {
        Driver::Channel(channel) => Ok(rig.channels[channel as usize].clone()),
        _ => Err(StrainError::NoJoints { rig: rig.name.clone() }),
    };
    motions.map(name).collect()
}

fn frame_number(curves: &Curves, frame: usize) -> i64 {
    curves.frame_axis().slice(&(frame..frame + 1)).first
}

/// The vertices by which a joint's pose is measured: those of the parts that follow it wholly.
fn rigid_parts(rig: &Rig, joint: &JawSkin) -> Vec<Range<usize>> {
    let whole =
        |range: &Range<usize>| !range.is_empty() && joint.weights[range.clone()].iter().all(|weight| *weight >= 1.0);
    let ranges = rig.parts.iter().map(|part| part.vertices.start as usize..part.vertices.end as usize);
    ranges.filter(whole).collect()
}

/// Measures the pose of every joint in every frame by the parts that follow it wholly: the rigid motion nearest to them
/// (least squares), about the joint's place where it only turns.
///
/// # Errors
/// Where the meshes are not those of the rig, no part follows a joint wholly, or a part gives no rotation.
pub fn measure_poses(rig: &Rig, meshes: &Meshes) -> Result<Curves, StrainError> {
    same("vertices of the meshes", rig.neutral.len(), meshes.vertices())?;
    let joints = joints(rig);
    if joints.is_empty() {
        return Err(StrainError::NoJoints { rig: rig.name.clone() });
    }
    let mut rigid = Vec::new();
    for joint in &joints {
        let parts = rigid_parts(rig, joint.skin);
        if parts.is_empty() {
            return Err(StrainError::NothingRigid { joint: joint.name.to_owned() });
        }
        let pivot = joint.skin.pivot_m.as_dvec3();
        let moves = joint.skin.motions.len() > 3;
        let rest: Vec<DVec3> =
            parts.iter().flat_map(|part| &rig.neutral[part.clone()]).map(|point| point.as_dvec3()).collect();
        rigid.push((joint.name, parts, pivot, moves, mirrored(rest, pivot, moves)));
    }
    let frames: Vec<Vec<f32>> = (0..meshes.frames())
        .into_par_iter()
        .map(|frame| {
            let posed = meshes.frame(frame);
            let mut values = Vec::new();
            for (name, parts, pivot, moves, rest) in &rigid {
                let own: Vec<DVec3> =
                    parts.iter().flat_map(|part| &posed[part.clone()]).map(|point| point.as_dvec3()).collect();
                let number = meshes.frame_axis().slice(&(frame..frame + 1)).first;
                let fit = fit_rigid(rest, &mirrored(own, *pivot, *moves), None)
                    .map_err(|source| StrainError::Pose { joint: (*name).to_owned(), frame: number, source })?;
                let euler = euler_rad(&fit.motion.rotation);
                let shift = fit.motion.translation_m + fit.motion.rotation * *pivot - *pivot;
                values.extend(euler.to_array().map(|angle| angle as f32));
                if *moves {
                    values.extend(shift.to_array().map(|metres| metres as f32));
                }
            }
            Ok(values)
        })
        .collect::<Result<_, StrainError>>()?;
    Ok(Curves::new(meshes.frame_axis(), pose_channels(rig)?, frames.concat())?)
}

/// Points with their images beyond the pivot, which hold the middle of both sets there: their best motion only turns.
fn mirrored(mut points: Vec<DVec3>, pivot: DVec3, moves: bool) -> Vec<DVec3> {
    if !moves {
        let images: Vec<DVec3> = points.iter().map(|point| 2.0 * pivot - *point).collect();
        points.extend(images);
    }
    points
}

/// The angles x, y, z (radians) of R = Rz·Ry·Rx.
pub fn euler_rad(rotation: &DMat3) -> DVec3 {
    let entry = |row: usize, column: usize| rotation.col(column)[row];
    let y = (-entry(2, 0)).clamp(-1.0, 1.0).asin();
    DVec3::new(entry(2, 1).atan2(entry(2, 2)), y, entry(1, 0).atan2(entry(0, 0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::Puppet;
    use crate::strain::toy;

    #[test]
    fn poses_that_drove_a_rig_are_measured_again() {
        let rig = toy::jointed_head();
        let curves = toy::pose_curves(&rig, 9);
        let meshes = toy::evaluated(&rig, &curves);
        let found = measure_poses(&rig, &meshes).unwrap();
        assert_eq!(found.channels(), curves.channels());
        for (a, b) in found.values().iter().zip(curves.values()) {
            assert!((a - b).abs() < 3e-6, "{a} {b}");
        }
        let still = toy::still(&curves);
        let rest = measure_poses(&rig, &toy::evaluated(&rig, &still)).unwrap();
        assert!(rest.values().iter().all(|value| value.abs() < 1e-7));
    }

    #[test]
    fn joints_stand_where_they_should_and_rest_is_rest() {
        let rig = toy::jointed_head();
        assert_eq!(Puppet::new(&rig).unwrap().vertices(&vec![0.0; rig.channels.len()]).unwrap(), rig.neutral);
        assert_eq!(rig.channels.len(), 9);
        assert!(rig.joints[0].skin.pivot_m.abs_diff_eq(toy::EYE, 1e-5), "{}", rig.joints[0].skin.pivot_m);
        let wrong = JointOptions { name: "jaw".into(), parts: vec!["teth".into()], moves: true, pivot_m: None };
        assert!(add_joints(&toy::bare_head(), &[wrong]).unwrap_err().to_string().contains("did you mean `teeth`?"));
    }

    #[test]
    fn angles_are_found_again() {
        for angles in [DVec3::new(0.3, -0.2, 0.1), DVec3::new(-0.01, 0.5, -0.9)] {
            let pose = JawPose::of(angles, DVec3::ZERO);
            assert!(euler_rad(&pose.rotation).abs_diff_eq(angles, 1e-14));
        }
    }
}
