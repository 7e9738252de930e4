//! Written GLB files: they read back as the same rig, and pose the vertices that the rig itself poses.
//!
//! With `GRIMACE_KEEP=folder` the files are kept there, to be looked at or given to the Khronos validator.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use ::gltf::animation::util::ReadOutputs;
use common::{bytes, data, siblings};
use face_io::{curves, gltf, no_sibling};
use face_math::data::{Curves, Driver, JawMotion, JawSkin, Part, Rig, Shape};
use face_math::rig::Puppet;
use glam::{Mat4, Quat, Vec3};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use wire::FrameAxis;

fn keep(name: &str, bytes: &[u8]) {
    if let Some(folder) = std::env::var_os("GRIMACE_KEEP") {
        std::fs::write(std::path::Path::new(&folder).join(name), bytes).unwrap();
    }
}

/// A sheet of 3 × 3 vertices in two parts, with a channel, an in-between and a combination.
fn sheet() -> Rig {
    let grid = |z: f32| (0..9).map(move |i| Vec3::new((i % 3) as f32 * 0.01, (i / 3) as f32 * 0.01, z));
    let triangles = |first: u32| {
        [0, 1, 3, 4].into_iter().flat_map(move |c| {
            let c = c + first;
            [[c, c + 1, c + 4], [c, c + 4, c + 3]]
        })
    };
    let part = |name: &str, first: u32| Part {
        name: name.into(),
        vertices: first..first + 9,
        triangles: triangles(first).collect(),
        uvs: if first == 0 { vec![[0.25, 0.75]; 9] } else { Vec::new() },
        colour: [0.8, 0.5, first as f32 / 9.0],
    };
    let shape = |name: &str, driver, vertices: Vec<u32>| Shape {
        name: name.into(),
        driver,
        deltas: vertices.iter().map(|v| Vec3::new(1e-3, -2e-3, *v as f32 * 1e-4)).collect(),
        vertices,
    };
    Rig {
        name: "sheet".into(),
        parts: vec![part("skin", 0), part("teeth", 9)],
        neutral: grid(0.0).chain(grid(-0.02)).collect(),
        channels: vec!["open".into(), "smile".into()],
        shapes: vec![
            shape("open", Driver::Channel(0), (0..18).collect()),
            shape("smile", Driver::Channel(1), vec![2]),
            shape("open@0.5", Driver::InBetween { channel: 0, peak: 0.5 }, vec![1, 12]),
            shape("open+smile", Driver::Combination(vec![0, 1]), vec![8, 9]),
        ],
        skin: Vec::new(),
        jaw_pivot_m: None,
        jaw: None,
        joints: Vec::new(),
    }
}

/// Gives a rig a jaw that its first channel opens and its second pushes.
fn with_jaw(mut rig: Rig, weights: Vec<f32>, pivot: Vec3, shapes: [u32; 2]) -> Rig {
    let motion = |shape, euler_rad, translation_m| JawMotion { shape, euler_rad, translation_m };
    rig.skin.clone_from(&weights);
    rig.jaw_pivot_m = Some(pivot);
    rig.jaw = Some(JawSkin {
        weights,
        motions: vec![
            motion(shapes[0], Vec3::new(0.4, 0.02, -0.01), Vec3::new(0.0, -2e-3, -1e-3)),
            motion(shapes[1], Vec3::new(-0.05, 0.1, 0.03), Vec3::new(1e-3, 0.0, 4e-3)),
        ],
        ..JawSkin::default()
    });
    rig
}

fn ramp(rig: &Rig, frames: usize) -> Curves {
    let count = rig.channels.len();
    let values = (0..frames * count).map(|i| ((i % (count + 3)) as f32 / (count + 3) as f32).powi(2)).collect();
    Curves::new(FrameAxis { first: 5, count: frames, rate_hz: 60.0 }, rig.channels.clone(), values).unwrap()
}

/// A written head as another reader of glTF sees it.
struct Played {
    file: ::gltf::Gltf,
    times_s: Vec<f32>,
    weights: Vec<f32>,
    /// By node: one a frame.
    rotations: BTreeMap<usize, Vec<[f32; 4]>>,
    translations: BTreeMap<usize, Vec<[f32; 3]>>,
}

impl Played {
    fn of(bytes: &[u8]) -> Self {
        let file = ::gltf::Gltf::from_slice(bytes).unwrap();
        let blob = file.blob.clone().unwrap();
        let (mut times_s, mut weights) = (Vec::new(), Vec::new());
        let (mut rotations, mut translations) = (BTreeMap::new(), BTreeMap::new());
        for channel in file.animations().next().unwrap().channels() {
            let node = channel.target().node().index();
            let reader = channel.reader(|_| Some(&blob));
            times_s = reader.read_inputs().unwrap().collect();
            match reader.read_outputs().unwrap() {
                ReadOutputs::MorphTargetWeights(track) => weights = track.into_f32().collect(),
                ReadOutputs::Rotations(track) => drop(rotations.insert(node, track.into_f32().collect())),
                ReadOutputs::Translations(track) => drop(translations.insert(node, track.collect())),
                ReadOutputs::Scales(_) => panic!("nothing is scaled"),
            }
        }
        Self { file, times_s, weights, rotations, translations }
    }

    /// Where a node stands in the world in `frame`.
    fn standing(&self, node: usize, frame: usize) -> Mat4 {
        let here = self.file.nodes().nth(node).unwrap();
        let (mut translation, mut rotation, scale) = here.transform().decomposed();
        if let Some(track) = self.rotations.get(&node) {
            rotation = track[frame];
        }
        if let Some(track) = self.translations.get(&node) {
            translation = track[frame];
        }
        let own = Mat4::from_scale_rotation_translation(
            Vec3::from(scale),
            Quat::from_array(rotation),
            Vec3::from(translation),
        );
        let above = self.file.nodes().find(|above| above.children().any(|child| child.index() == node));
        above.map_or(own, |above| self.standing(above.index(), frame) * own)
    }

    /// All vertices in `frame`, in metres: morph targets first, then the skin (sections 3.7.2.2 and 3.7.3.3 of glTF 2.0).
    fn vertices(&self, frame: usize) -> Vec<Vec3> {
        let blob = self.file.blob.as_deref().unwrap();
        let node = self.file.nodes().find(|node| node.mesh().is_some()).unwrap();
        let joints: Vec<Mat4> = node.skin().map_or(Vec::new(), |skin| {
            let rest = skin.reader(|_| Some(blob)).read_inverse_bind_matrices().unwrap();
            let rest = rest.map(|rest| Mat4::from_cols_array_2d(&rest));
            skin.joints().zip(rest).map(|(joint, rest)| self.standing(joint.index(), frame) * rest).collect()
        });
        let mut all = Vec::new();
        for primitive in node.mesh().unwrap().primitives() {
            let reader = primitive.reader(|_| Some(blob));
            let mut points: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
            let count = primitive.morph_targets().count();
            for (target, weight) in reader.read_morph_targets().zip(&self.weights[frame * count..]) {
                for (point, delta) in points.iter_mut().zip(target.0.into_iter().flatten()) {
                    *point += *weight * Vec3::from(delta);
                }
            }
            if let (Some(names), Some(shares)) = (reader.read_joints(0), reader.read_weights(0)) {
                for ((point, names), shares) in points.iter_mut().zip(names.into_u16()).zip(shares.into_f32()) {
                    let moved = names.iter().zip(shares);
                    *point =
                        moved.map(|(joint, share)| share * joints[usize::from(*joint)].transform_point3(*point)).sum();
                }
            }
            all.extend(points);
        }
        all
    }
}

/// Plays a written file by another reader, and compares all vertices with those that the rig poses itself, in metres.
fn plays_as(rig: &Rig, curves: &Curves, bytes: &[u8]) -> f32 {
    let played = Played::of(bytes);
    assert_eq!(played.times_s.len(), curves.frames());
    assert!(played.times_s.iter().enumerate().all(|(i, t)| (f64::from(*t) - i as f64 / 60.0).abs() < 1e-5));
    let puppet = Puppet::new(rig).unwrap();
    let mut worst = 0.0_f32;
    for frame in 0..curves.frames() {
        let expected = puppet.vertices(curves.frame(frame)).unwrap();
        let points = played.vertices(frame);
        assert_eq!(points.len(), expected.len());
        worst = points.iter().zip(&expected).map(|(a, b)| a.distance(*b)).fold(worst, f32::max);
    }
    worst
}

#[test]
fn a_rig_at_rest_reads_back_the_same() {
    let rig = sheet();
    let file = gltf::write(&rig, &json!({ "graph": "test" })).unwrap();
    keep("sheet.glb", &file);
    assert_eq!(gltf::read(&file, "sheet", &mut no_sibling).unwrap(), rig);
    let jawed = with_jaw(rig, (0..18_u8).map(|v| f32::from(v) / 17.0).collect(), Vec3::new(0.0, 0.01, -0.01), [0, 1]);
    let again = gltf::read(&gltf::write(&jawed, &Value::Null).unwrap(), "sheet", &mut no_sibling).unwrap();
    assert!(again.skin.iter().zip(&jawed.skin).all(|(a, b)| (a - b).abs() < 1e-6));
    assert_eq!(again.jaw_pivot_m, jawed.jaw_pivot_m);
    assert_eq!(again.shapes, jawed.shapes);
}

#[test]
fn animated_files_play_what_the_rig_poses() {
    let plain = sheet();
    let weights = (0..18_u8).map(|v| f32::from(v) / 17.0).collect();
    let jawed = with_jaw(plain.clone(), weights, Vec3::new(0.0, 0.01, -0.01), [0, 3]);
    for (name, rig) in [("sheet_plays.glb", plain), ("sheet_jaw_plays.glb", jawed)] {
        let curves = ramp(&rig, 40);
        let file = gltf::write_animation(&rig, &curves, &json!({ "inputs": ["a", "b"] })).unwrap();
        keep(name, &file);
        let worst = plays_as(&rig, &curves, &file);
        assert!(worst < 1e-8, "{worst} m");
    }
}

#[test]
fn real_heads_play_what_they_pose() {
    let Some(data) = data() else { return };
    let head = data.join("actors/ict_actor_a/ict_actor_a.glb");
    let rig = gltf::read(&bytes(head), "ict_actor_a", &mut no_sibling).unwrap();
    let truth = curves::read(&bytes(data.join("actors/ict_actor_a/truth/day1_161.csv")), Some(60.0)).unwrap();
    let count = truth.channels().len();
    let part = Curves::new(
        FrameAxis { first: 0, count: 30, rate_hz: 60.0 },
        truth.channels().to_vec(),
        truth.values()[300 * count..330 * count].to_vec(),
    )
    .unwrap();
    let shape = |name: &str| rig.shapes.iter().position(|shape| shape.name == name).unwrap() as u32;
    let shapes = [shape("jawOpen"), shape("jawForward")];
    let (skin, pivot) = (rig.skin.clone(), rig.jaw_pivot_m.unwrap());
    let jawed = with_jaw(rig.clone(), skin, pivot, shapes);
    for (name, rig) in [("ict_plays.glb", rig), ("ict_jaw_plays.glb", jawed)] {
        let file = gltf::write_animation(&rig, &part, &Value::Null).unwrap();
        keep(name, &file);
        let worst = plays_as(&rig, &part, &file);
        assert!(worst < 1e-7, "{worst} m");
        assert!(file.len() < 8_000_000, "{} bytes", file.len());
    }
}

#[test]
fn sample_models_survive_being_written() {
    let Some(data) = data() else { return };
    let folder = data.join("rigs/gltf/AnimatedMorphCube/glTF");
    let cube = gltf::read(&bytes(folder.join("AnimatedMorphCube.gltf")), "cube", &mut siblings(&folder)).unwrap();
    let file = gltf::write(&cube, &Value::Null).unwrap();
    keep("cube.glb", &file);
    assert_eq!(gltf::read(&file, "cube", &mut no_sibling).unwrap(), cube);
}

#[test]
fn what_does_not_fit_is_refused() {
    let rig = sheet();
    let short = Curves::new(FrameAxis::new(1, 60.0), vec!["open".into()], vec![0.5]).unwrap();
    let error = gltf::write_animation(&rig, &short, &Value::Null).unwrap_err().to_string();
    assert!(error.contains("`smile`"), "{error}");
    let hole = Curves::new(FrameAxis::new(1, 60.0), rig.channels.clone(), vec![0.5, f32::NAN]).unwrap();
    let error = gltf::write_animation(&rig, &hole, &Value::Null).unwrap_err().to_string();
    assert!(error.contains("channel `smile` in frame 0 is NaN"), "{error}");
    let outside = with_jaw(rig, vec![1.5; 18], Vec3::ZERO, [0, 1]);
    let error = gltf::write(&outside, &Value::Null).unwrap_err().to_string();
    assert!(error.contains("share of the jaw in vertex 0 is 1.5"), "{error}");
}
