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

fn main() {
    let data = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let Some(folder) = std::env::args().skip(1).find(|argument| !argument.starts_with("--")) else { return };
    let folder = PathBuf::from(folder);
    fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, numbers: Vec<f64>| {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        fs::write(folder.join(name), bytes).unwrap();
    };
    let actor = data.join("actors/ict_actor_a");
    let scan = gltf::read(&fs::read(actor.join("ict_actor_a.glb")).unwrap(), "a", &mut no_sibling).unwrap();
    let few = keep_parts(&scan, |part| ["face", "teeth_lower"].contains(&part.name.as_str()));
    let rig = skin_jaw(&few, &SkinJawOptions::default()).unwrap().rig;
    let joint = JointOptions { name: "jaw".into(), parts: vec!["teeth_lower".into()], moves: true, pivot_m: None };
    let base = add_joints(&rig, &[joint]).unwrap();

    // Every eighth frame of the range of motion.
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
    let plan = muscles::read(
        &fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs/strain_train/muscles.ron")).unwrap(),
    );
    let marks = landmarks(&rig, &actor.join("landmarks.json"));
    let muscles: Muscles = trace_muscles(&rig, &[&rig.parts[0]], &marks, &plan.unwrap()).unwrap();
    let poses = measure_poses(&base, &meshes).unwrap();
    let strains = measure_strains(&muscles, &meshes).unwrap();
    let mut told: BTreeMap<String, f64> = BTreeMap::new();
    let mut tell = |name: &str, number: f64| drop(told.insert(name.to_owned(), number));

    // A.1: all vertices here, some of them there.
    let prior = 9e-8;
    let (skinned, seconds) = timed(|| fit_skinning(&base, &meshes, &poses, prior).unwrap().rig);
    let half = frames / 2;
    let (_, half_seconds) =
        timed(|| fit_skinning(&base, &cut_meshes(&meshes, half), &cut(&poses, half), prior).unwrap());
    tell("skinning_seconds", seconds);
    tell("skinning_seconds_half_frames", half_seconds);
    let some: Vec<usize> = (0..rig.parts[0].vertices.end as usize).step_by(97).collect();
    let at = Poses::new(&base, &poses).unwrap();
    let jaw = &base.jaw.as_ref().unwrap().weights;
    write(
        "skin_motion.bin",
        some.iter()
            .flat_map(|vertex| {
                (0..frames).flat_map({
                    let (rig, at) = (&rig, &at);
                    move |frame| {
                        let x = rig.neutral[*vertex].as_dvec3();
                        let pose = at.frame(frame)[0];
                        (pose.rotation * x + pose.translation_m - x).to_array()
                    }
                })
            })
            .collect(),
    );
    write(
        "skin_target.bin",
        some.iter()
            .flat_map(|vertex| {
                (0..frames).flat_map({
                    let (rig, meshes) = (&rig, &meshes);
                    move |frame| (meshes.frame(frame)[*vertex] - rig.neutral[*vertex]).as_dvec3().to_array()
                })
            })
            .collect(),
    );
    write("skin_start.bin", some.iter().map(|vertex| f64::from(jaw[*vertex])).collect());
    write(
        "skin_found.bin",
        some.iter().map(|vertex| f64::from(skinned.jaw.as_ref().unwrap().weights[*vertex])).collect(),
    );

    // A.3, one E and one Γ.
    let halfway = unpose_meshes(&skinned, &meshes, &poses, Keep::PoseShapes).unwrap();
    let corrected = fit_pose_shapes(&skinned, &halfway, &poses, 1e-8).unwrap();
    let unposed = unpose_meshes(&corrected, &meshes, &poses, Keep::Strains).unwrap();
    let reach = StrainReach { falloff_m: 0.02, reach_m: f64::INFINITY };
    let train = |meshes: &Meshes, strains: &Curves, rounds: usize| {
        let options = StrainShapeOptions { rounds, prior_m2: 1e-6, distance_penalty: 1e-9 };
        let go_on = |_, _| Ok::<(), face_math::strain::StrainError>(());
        train_strain_rig(&corrected, meshes, strains, &muscles, (reach, &options), go_on).unwrap()
    };
    let (trained, seconds) = timed(|| train(&unposed, &strains, 1));
    let (_, half_seconds) = timed(|| train(&cut_meshes(&unposed, half), &cut(&strains, half), 1));
    tell("shapes_seconds", seconds);
    tell("shapes_seconds_half_frames", half_seconds);
    write(
        "unposed.bin",
        (0..frames)
            .flat_map(|frame| unposed.frame(frame).iter().zip(&rig.neutral))
            .flat_map(|(a, b)| (*a - *b).as_dvec3().to_array())
            .collect(),
    );
    write("strains.bin", strains.values().iter().map(|value| f64::from(*value)).collect());
    let distances = face_math::strain::distance_penalties(&muscles, &rig.neutral, 0.02, f64::INFINITY);
    write("penalties.bin", distances.iter().map(|distance| f64::from(*distance)).collect());

    // B.3 with acceleration.
    let options = StrainSolveOptions { acceleration_m2: 4e-4, manifold_m2: 0.0, ridge_m2: 1e-8, steps: 1 };
    let solve = |meshes: &Meshes, poses: &Curves| {
        solve_strains(&trained.rig, meshes, poses, &options, None, || true).unwrap().unwrap()
    };
    let (solved, seconds) = timed(|| solve(&meshes, &poses));
    let (_, half_seconds) = timed(|| solve(&cut_meshes(&meshes, half), &cut(&poses, half)));
    tell("solve_seconds", seconds);
    tell("solve_seconds_half_frames", half_seconds);
    write("solved.bin", solved.strains.values().iter().map(|value| f64::from(*value)).collect());
    let own = |name: &String| {
        let channel = trained.rig.channel(name).unwrap() as u32;
        trained.rig.shapes.iter().find(|shape| shape.driver == Driver::Channel(channel)).unwrap()
    };
    let mut shapes = Vec::new();
    for name in strains.channels() {
        let mut dense = vec![0.0; 3 * rig.neutral.len()];
        let shape = own(name);
        for (vertex, delta) in shape.vertices.iter().zip(&shape.deltas) {
            for axis in 0..3 {
                dense[3 * *vertex as usize + axis] = f64::from(delta[axis]);
            }
        }
        shapes.extend(dense);
    }
    write("shapes.bin", shapes);

    // B.2 on skinning alone, on some of the vertices and frames, for both sides alike.
    let (jaw_frames, keep) = (60.min(frames), 13);
    let mut small = skinned.clone();
    let chosen: Vec<usize> = (0..rig.parts[0].vertices.end as usize)
        .filter(|vertex| skinned.jaw.as_ref().unwrap().weights[*vertex] > 0.02)
        .step_by(keep)
        .collect();
    small.parts = Vec::new();
    small.neutral = chosen.iter().map(|vertex| skinned.neutral[*vertex]).collect();
    small.jaw.as_mut().unwrap().weights =
        chosen.iter().map(|vertex| skinned.jaw.as_ref().unwrap().weights[*vertex]).collect();
    let positions = (0..jaw_frames)
        .flat_map(|frame| chosen.iter().map(move |vertex| (frame, *vertex)))
        .map(|(frame, vertex)| meshes.frame(frame)[vertex])
        .collect();
    let few = Meshes::new(FrameAxis::new(jaw_frames, 60.0), Vec::new(), chosen.len(), positions).unwrap();
    let options = JawSolveOptions { acceleration_m2: 0.01, ..JawSolveOptions::default() };
    let ones = vec![1.0; chosen.len()];
    let (jaw, seconds) = timed(|| solve_jaw_pose(&small, &few, None, &ones, &options, || true).unwrap().unwrap());
    tell("jaw_seconds", seconds);
    let every = vec![1.0; rig.neutral.len()];
    for (name, count) in [("jaw_seconds_all", frames), ("jaw_seconds_all_half_frames", half)] {
        let part = cut_meshes(&meshes, count);
        tell(name, timed(|| solve_jaw_pose(&corrected, &part, None, &every, &options, || true).unwrap()).1);
    }
    let vectors =
        |points: &[glam::Vec3]| points.iter().flat_map(|point| point.as_dvec3().to_array()).collect::<Vec<_>>();
    write("jaw_rest.bin", vectors(&small.neutral));
    write("jaw_target.bin", vectors(few.positions()));
    write("jaw_weights.bin", small.jaw.as_ref().unwrap().weights.iter().map(|weight| f64::from(*weight)).collect());
    write("jaw_pivot.bin", small.jaw.as_ref().unwrap().pivot_m.as_dvec3().to_array().to_vec());
    write("jaw_found.bin", jaw.poses.values().iter().map(|value| f64::from(*value)).collect());

    for (name, count) in [
        ("frames", frames),
        ("vertices", rig.neutral.len()),
        ("strains", strains.channels().len()),
        ("jaw_frames", jaw_frames),
        ("skin_vertices", some.len()),
    ] {
        tell(name, count as f64);
    }
    fs::write(folder.join("ours.json"), serde_json::to_string_pretty(&told).unwrap()).unwrap();
}
