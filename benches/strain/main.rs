//! Times the solvers of strain rigs on a scanned actor, and writes the same problems for `compare.py`, which solves them with
//! `NumPy` and `SciPy`.
//!
//! Files in the folder given as the argument, little-endian 64-bit floats, and `ours.json` with sizes, times and answers.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot read its files has nothing to say")]

use face_io::{curves, gltf, muscles, no_sibling};
use face_math::data::{Attachment, Curves, Driver, Meshes, Muscles, Rig, SurfacePoint};
use face_math::rig::{Puppet, SkinJawOptions, keep_parts, skin_jaw};
use face_math::strain::{
    JawSolveOptions, JointOptions, Keep, Poses, StrainReach, StrainShapeOptions, StrainSolveOptions, add_joints,
    fit_pose_shapes, fit_skinning, measure_poses, measure_strains, solve_jaw_pose, solve_strains, trace_muscles,
    train_strain_rig, unpose_meshes,
};
use glam::Vec3;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use wire::FrameAxis;

fn timed<T>(what: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let out = what();
    (out, start.elapsed().as_secs_f64())
}

fn cut(curves: &Curves, count: usize) -> Curves {
    let axis = FrameAxis::new(count, 60.0);
    Curves::new(axis, curves.channels().to_vec(), curves.values()[..count * curves.channels().len()].to_vec()).unwrap()
}

fn cut_meshes(meshes: &Meshes, count: usize) -> Meshes {
    let positions = meshes.positions()[..count * meshes.vertices()].to_vec();
    Meshes::new(FrameAxis::new(count, 60.0), meshes.parts().to_vec(), meshes.vertices(), positions).unwrap()
}

fn landmarks(rig: &Rig, path: &Path) -> Attachment {
    let file: serde_json::Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let vertices = file["landmarks68"].as_array().unwrap().iter().map(|vertex| vertex.as_u64().unwrap() as u32);
    let point = |(number, vertex): (usize, u32)| {
        let triangle = *rig.parts[0].triangles.iter().find(|triangle| triangle.contains(&vertex)).unwrap();
        let weights = triangle.map(|own| f32::from(u8::from(own == vertex)));
        SurfacePoint { name: format!("landmark_{number:02}"), vertices: triangle, weights, distance_m: 0.0 }
    };
    Attachment { points: vertices.enumerate().map(point).collect() }
}

/// Where problems are written, and what is told of them.
struct Sheet {
    folder: PathBuf,
    told: BTreeMap<String, f64>,
}

impl Sheet {
    fn write(&self, name: &str, numbers: &[f64]) {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        fs::write(self.folder.join(name), bytes).unwrap();
    }

    fn tell(&mut self, name: &str, number: f64) {
        self.told.insert(name.to_owned(), number);
    }
}

/// The actor, its motion as meshes, and what is measured of it.
struct Subject {
    rig: Rig,
    base: Rig,
    meshes: Meshes,
    poses: Curves,
    muscles: Muscles,
    strains: Curves,
}

impl Subject {
    /// The scanned actor on every eighth frame of its range of motion.
    fn load(data: &Path) -> Self {
        let actor = data.join("actors/ict_actor_a");
        let scan = gltf::read(&fs::read(actor.join("ict_actor_a.glb")).unwrap(), "a", &mut no_sibling).unwrap();
        let few = keep_parts(&scan, |part| ["face", "teeth_lower"].contains(&part.name.as_str()));
        let rig = skin_jaw(&few, &SkinJawOptions::default()).unwrap().rig;
        let joint = JointOptions { name: "jaw".into(), parts: vec!["teeth_lower".into()], moves: true, pivot_m: None };
        let base = add_joints(&rig, &[joint]).unwrap();
        let mut rows = Vec::new();
        for name in ["rom_162.csv", "rom_165.csv"] {
            let table = curves::open(&fs::read(actor.join("rom").join(name)).unwrap()).unwrap();
            let own = table.into_curves(Some(60.0)).unwrap().arrange(&rig.channels, Some(0.0)).unwrap();
            rows.extend((0..own.frames()).step_by(8).flat_map(|frame| own.frame(frame).to_vec()));
        }
        let frames = rows.len() / rig.channels.len();
        let motion = Curves::new(FrameAxis::new(frames, 60.0), rig.channels.clone(), rows).unwrap();
        let puppet = Puppet::new(&rig).unwrap();
        let positions = (0..frames).flat_map(|frame| puppet.vertices(motion.frame(frame)).unwrap()).collect();
        let meshes = Meshes::new(motion.frame_axis(), rig.parts.clone(), rig.neutral.len(), positions).unwrap();
        let plan = Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs/strain_train/muscles.ron");
        let plan = muscles::read(&fs::read(plan).unwrap()).unwrap();
        let marks = landmarks(&rig, &actor.join("landmarks.json"));
        let muscles: Muscles = trace_muscles(&rig, &[&rig.parts[0]], &marks, &plan).unwrap();
        let poses = measure_poses(&base, &meshes).unwrap();
        let strains = measure_strains(&muscles, &meshes).unwrap();
        Self { rig, base, meshes, poses, muscles, strains }
    }

    fn half(&self) -> usize {
        self.meshes.frames() / 2
    }

    /// Vertices of the face.
    fn face(&self) -> std::ops::Range<usize> {
        0..self.rig.parts[0].vertices.end as usize
    }
}

fn vectors(points: &[Vec3]) -> Vec<f64> {
    points.iter().flat_map(|point| point.as_dvec3().to_array()).collect()
}

fn weights(rig: &Rig, vertices: &[usize]) -> Vec<f64> {
    let jaw = rig.jaw.as_ref().unwrap();
    vertices.iter().map(|vertex| f64::from(jaw.weights[*vertex])).collect()
}

fn main() {
    let data = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let Some(folder) = std::env::args().skip(1).find(|argument| !argument.starts_with("--")) else { return };
    let mut sheet = Sheet { folder: PathBuf::from(folder), told: BTreeMap::new() };
    fs::create_dir_all(&sheet.folder).unwrap();
    let subject = Subject::load(&data);
    sheet.tell("frames", subject.meshes.frames() as f64);
    sheet.tell("vertices", subject.rig.neutral.len() as f64);
    sheet.tell("strains", subject.strains.channels().len() as f64);
    let skinned = skinning(&mut sheet, &subject);
    let (corrected, trained) = shapes(&mut sheet, &subject, &skinned);
    strains(&mut sheet, &subject, &trained);
    jaw(&mut sheet, &subject, &skinned, &corrected);
    fs::write(sheet.folder.join("ours.json"), serde_json::to_string_pretty(&sheet.told).unwrap()).unwrap();
}

/// A.1: all vertices here, some of them there.
fn skinning(sheet: &mut Sheet, subject: &Subject) -> Rig {
    let Subject { rig, base, meshes, poses, .. } = subject;
    let (frames, half, prior) = (meshes.frames(), subject.half(), 9e-8);
    let (skinned, seconds) = timed(|| fit_skinning(base, meshes, poses, prior).unwrap().rig);
    let (_, half_seconds) = timed(|| fit_skinning(base, &cut_meshes(meshes, half), &cut(poses, half), prior).unwrap());
    sheet.tell("skinning_seconds", seconds);
    sheet.tell("skinning_seconds_half_frames", half_seconds);
    let some: Vec<usize> = subject.face().step_by(97).collect();
    sheet.tell("skin_vertices", some.len() as f64);
    let at = Poses::new(base, poses).unwrap();
    let (mut motion, mut target) = (Vec::new(), Vec::new());
    for vertex in &some {
        let x = rig.neutral[*vertex];
        for frame in 0..frames {
            let pose = at.frame(frame)[0];
            motion.extend((pose.rotation * x.as_dvec3() + pose.translation_m - x.as_dvec3()).to_array());
            target.extend((meshes.frame(frame)[*vertex] - x).as_dvec3().to_array());
        }
    }
    sheet.write("skin_motion.bin", &motion);
    sheet.write("skin_target.bin", &target);
    sheet.write("skin_start.bin", &weights(base, &some));
    sheet.write("skin_found.bin", &weights(&skinned, &some));
    skinned
}

/// A.3, one E and one Γ; gives the rig with pose shapes, and with strain shapes.
fn shapes(sheet: &mut Sheet, subject: &Subject, skinned: &Rig) -> (Rig, Rig) {
    let Subject { rig, meshes, poses, muscles, strains, .. } = subject;
    let half = subject.half();
    let halfway = unpose_meshes(skinned, meshes, poses, Keep::PoseShapes).unwrap();
    let corrected = fit_pose_shapes(skinned, &halfway, poses, 0.25).unwrap();
    let unposed = unpose_meshes(&corrected, meshes, poses, Keep::Strains).unwrap();
    let reach = StrainReach { falloff_m: 0.02, reach_m: f64::INFINITY };
    let train = |meshes: &Meshes, strains: &Curves| {
        let options = StrainShapeOptions { rounds: 1, prior_m2: 1e-6, distance_penalty: 1e-9 };
        let go_on = |_, _| Ok::<(), face_math::strain::StrainError>(());
        train_strain_rig(&corrected, meshes, strains, muscles, (reach, &options), go_on).unwrap()
    };
    let (trained, seconds) = timed(|| train(&unposed, strains));
    let (_, half_seconds) = timed(|| train(&cut_meshes(&unposed, half), &cut(strains, half)));
    sheet.tell("shapes_seconds", seconds);
    sheet.tell("shapes_seconds_half_frames", half_seconds);
    let offsets = unposed.positions().chunks_exact(rig.neutral.len()).flat_map(|frame| frame.iter().zip(&rig.neutral));
    sheet.write("unposed.bin", &offsets.flat_map(|(a, b)| (*a - *b).as_dvec3().to_array()).collect::<Vec<_>>());
    sheet.write("strains.bin", &strains.values().iter().map(|value| f64::from(*value)).collect::<Vec<_>>());
    let distances = face_math::strain::distance_penalties(muscles, &rig.neutral, 0.02, f64::INFINITY);
    sheet.write("penalties.bin", &distances.iter().map(|distance| f64::from(*distance)).collect::<Vec<_>>());
    let mut shapes = Vec::new();
    for name in strains.channels() {
        let driver = Driver::Channel(trained.rig.channel(name).unwrap() as u32);
        let shape = trained.rig.shapes.iter().find(|shape| shape.driver == driver).unwrap();
        let mut dense = vec![0.0; 3 * rig.neutral.len()];
        for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
            for axis in 0..3 {
                dense[3 * *vertex as usize + axis] = f64::from(delta[axis]);
            }
        }
        shapes.extend(dense);
    }
    sheet.write("shapes.bin", &shapes);
    (corrected, trained.rig)
}

/// B.3 with acceleration.
fn strains(sheet: &mut Sheet, subject: &Subject, trained: &Rig) {
    let Subject { meshes, poses, .. } = subject;
    let half = subject.half();
    let options = StrainSolveOptions { acceleration_m2: 4e-4, manifold_m2: 0.0, ridge_m2: 1e-8, steps: 1 };
    let solve = |meshes: &Meshes, poses: &Curves| {
        solve_strains(trained, meshes, poses, &options, None, || true).unwrap().unwrap()
    };
    let (solved, seconds) = timed(|| solve(meshes, poses));
    let (_, half_seconds) = timed(|| solve(&cut_meshes(meshes, half), &cut(poses, half)));
    sheet.tell("solve_seconds", seconds);
    sheet.tell("solve_seconds_half_frames", half_seconds);
    // The same problem for the other side: what strains are to explain, and how the jaw turns it.
    let still = poses.arrange(&trained.channels, Some(0.0)).unwrap();
    let puppet = Puppet::new(trained).unwrap();
    let rest: Vec<Vec3> = (0..still.frames()).flat_map(|t| puppet.vertices(still.frame(t)).unwrap()).collect();
    let off: Vec<Vec3> = meshes.positions().iter().zip(&rest).map(|(posed, rest)| *posed - *rest).collect();
    sheet.write("left.bin", &vectors(&off));
    let at = Poses::new(trained, poses).unwrap();
    let turns = (0..still.frames()).flat_map(|t| at.frame(t)[0].rotation.transpose().to_cols_array());
    sheet.write("turns.bin", &turns.collect::<Vec<_>>());
    sheet.write("skin.bin", &weights(trained, &(0..trained.neutral.len()).collect::<Vec<_>>()));
    sheet.write("solved.bin", &solved.strains.values().iter().map(|value| f64::from(*value)).collect::<Vec<_>>());
}

/// B.2 on skinning alone, on some of the vertices and frames, for both sides alike; and here alone on all of them.
fn jaw(sheet: &mut Sheet, subject: &Subject, skinned: &Rig, corrected: &Rig) {
    let Subject { rig, meshes, .. } = subject;
    let frames = 60.min(meshes.frames());
    let jaw = &skinned.jaw.as_ref().unwrap().weights;
    let chosen: Vec<usize> = subject.face().filter(|vertex| jaw[*vertex] > 0.02).step_by(13).collect();
    let mut small = skinned.clone();
    small.parts = Vec::new();
    small.neutral = chosen.iter().map(|vertex| skinned.neutral[*vertex]).collect();
    small.jaw.as_mut().unwrap().weights = chosen.iter().map(|vertex| jaw[*vertex]).collect();
    let positions = (0..frames)
        .flat_map(|frame| chosen.iter().map(move |vertex| (frame, *vertex)))
        .map(|(frame, vertex)| meshes.frame(frame)[vertex])
        .collect();
    let few = Meshes::new(FrameAxis::new(frames, 60.0), Vec::new(), chosen.len(), positions).unwrap();
    let options = JawSolveOptions { acceleration_m2: 0.01, ..JawSolveOptions::default() };
    let ones = vec![1.0; chosen.len()];
    let (found, seconds) = timed(|| solve_jaw_pose(&small, &few, None, &ones, &options, || true).unwrap().unwrap());
    sheet.tell("jaw_seconds", seconds);
    sheet.tell("jaw_frames", frames as f64);
    let every = vec![1.0; rig.neutral.len()];
    for (name, count) in [("jaw_seconds_all", meshes.frames()), ("jaw_seconds_all_half_frames", subject.half())] {
        let part = cut_meshes(meshes, count);
        let solve = || solve_jaw_pose(corrected, &part, None, &every, &options, || true).unwrap().unwrap();
        let (solved, seconds) = timed(solve);
        sheet.tell(name, seconds);
        sheet.tell(&name.replace("seconds", "steps"), (solved.losses_m2.len() - 1) as f64);
    }
    sheet.write("jaw_rest.bin", &vectors(&small.neutral));
    sheet.write("jaw_target.bin", &vectors(few.positions()));
    sheet.write("jaw_weights.bin", &weights(skinned, &chosen));
    sheet.write("jaw_pivot.bin", &small.jaw.as_ref().unwrap().pivot_m.as_dvec3().to_array());
    sheet.write("jaw_found.bin", &found.poses.values().iter().map(|value| f64::from(*value)).collect::<Vec<_>>());
}
