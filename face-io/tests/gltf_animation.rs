//! Animated glTF files as curves: our own, those of other tools, uneven keys, and damaged ones.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::{bytes, data, siblings};
use face_io::{gltf, inspect, no_sibling};
use face_math::data::{Curves, Driver, Part, Rig, Shape};
use glam::Vec3;
use proptest::prelude::*;
use serde_json::{Value, json};
use wire::FrameAxis;

/// A triangle with two channels, an in-between and a combination.
fn triangle() -> Rig {
    let shape = |name: &str, driver| Shape { name: name.into(), driver, vertices: vec![2], deltas: vec![Vec3::Z] };
    Rig {
        name: "tri".into(),
        parts: vec![Part {
            name: "tri".into(),
            vertices: 0..3,
            triangles: vec![[0, 1, 2]],
            uvs: Vec::new(),
            colour: [1.0; 3],
        }],
        neutral: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        channels: vec!["a".into(), "b".into()],
        shapes: vec![
            shape("a", Driver::Channel(0)),
            shape("a@0.5", Driver::InBetween { channel: 0, peak: 0.5 }),
            shape("b", Driver::Channel(1)),
            shape("a+b", Driver::Combination(vec![0, 1])),
        ],
        skin: Vec::new(),
        jaw_pivot_m: None,
        jaw: None,
        joints: Vec::new(),
    }
}

fn curves(first: i64, rate_hz: f64, values: Vec<f32>) -> Curves {
    let axis = FrameAxis { first, count: values.len() / 2, rate_hz };
    Curves::new(axis, vec!["a".into(), "b".into()], values).unwrap()
}

fn written(curves: &Curves) -> Vec<u8> {
    let axis = curves.frame_axis();
    let notes = json!({ "first_frame": axis.first, "frames": axis.count, "rate_hz": axis.rate_hz });
    gltf::write_animation(&triangle(), curves, &notes).unwrap()
}

/// A file whose only track has these keys, as another tool writes it.
fn keyed(interpolation: &str, times: &[f32], values: &[f32]) -> Vec<u8> {
    let floats: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .chain(times)
        .chain(values)
        .flat_map(|f| f.to_le_bytes())
        .collect();
    let base64 = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &floats);
    let (keys, outputs) = (times.len(), values.len());
    let scalar = |offset: usize, count: usize| json!({"bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": count, "type": "SCALAR"});
    let target = json!({"POSITION": 0});
    serde_json::to_vec(&json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "face"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "targets": [target, target]}], "extras": {"targetNames": ["a", "b"]}}],
        "animations": [{
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            "samplers": [{"input": 1, "output": 2, "interpolation": interpolation}],
        }],
        "buffers": [{"uri": format!("data:application/octet-stream;base64,{base64}"), "byteLength": floats.len()}],
        "bufferViews": [{"buffer": 0, "byteLength": floats.len()}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}, scalar(36, keys), scalar(36 + 4 * keys, outputs)],
    }))
    .unwrap()
}

fn read(bytes: &[u8], rate_hz: Option<f64>) -> Result<gltf::Animation, String> {
    gltf::read_animation(bytes, None, rate_hz, &mut no_sibling).map_err(|error| error.to_string())
}

#[test]
fn uneven_keys_are_sampled_at_the_rate_that_fits_them() {
    let file = keyed("LINEAR", &[0.0, 0.1, 0.5], &[0.0, 1.0, 0.3, 0.5, 0.7, 0.5]);
    let animation = read(&file, None).unwrap();
    assert_eq!(animation.curves.frame_axis(), FrameAxis::new(16, 30.0));
    assert_eq!(animation.curves.frame(3), [0.3, 0.5]);
    assert!((animation.curves.frame(1)[0] - 0.1).abs() < 1e-6 && (animation.curves.frame(9)[0] - 0.5).abs() < 1e-6);
    let fine = read(&file, Some(100.0)).unwrap().curves;
    assert_eq!((fine.frames(), fine.frame(10)), (51, &[0.3, 0.5][..]));
    let step = read(&keyed("STEP", &[0.5, 1.0], &[0.25, 0.0, 0.75, 1.0]), None).unwrap().curves;
    assert_eq!(
        (step.frame_axis().first, step.frames(), step.frame_axis().rate_hz.to_bits()),
        (12, 13, 24.0_f64.to_bits())
    );
    assert_eq!((step.frame(11), step.frame(12)), (&[0.25, 0.0][..], &[0.75, 1.0][..]));
    // A spline through 0 and 1 with level tangents is 3t² − 2t³.
    let spline = keyed("CUBICSPLINE", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
    let spline = read(&spline, Some(10.0)).unwrap().curves;
    for frame in 0..=10_u8 {
        let t = f32::from(frame) / 10.0;
        assert!((spline.frame(frame.into())[0] - t * t * (3.0 - 2.0 * t)).abs() < 1e-6);
    }
}

#[test]
fn what_shows_no_curves_is_refused_with_its_place() {
    let wrong = |file: Vec<u8>| read(&file, None).unwrap_err();
    let none = gltf::write(&triangle(), &Value::Null).unwrap();
    assert!(wrong(none).contains("the file holds no animation"));
    assert!(wrong(keyed("LINEAR", &[0.0, 0.013, 0.7771], &[0.0; 6])).contains("3 keys show no frame rate"));
    assert!(wrong(keyed("LINEAR", &[0.0, 1.0], &[0.0; 3])).contains("3 values where 2 keys of 2 targets need 2 each"));
    assert!(wrong(keyed("LINEAR", &[1.0, 1.0], &[0.0; 4])).contains("key 1 at 1 s does not come after 1 s"));
    assert!(wrong(keyed("BEZIER", &[0.0, 1.0], &[0.0; 4])).contains("interpolation"));
    assert!(wrong(keyed("LINEAR", &[0.0, 1e30], &[0.0; 4])).contains("too many"));
    let file = String::from_utf8(keyed("LINEAR", &[0.0, 1.0], &[0.0; 4])).unwrap().replace("\"weights\"", "\"scale\"");
    assert!(wrong(file.into_bytes()).contains("only face"));
}

#[test]
fn real_animations_are_read_and_told_of() {
    let Some(data) = data() else { return };
    for (name, node) in [("SimpleMorph", "SimpleMorph"), ("AnimatedMorphCube", "AnimatedMorphCube")] {
        let folder = data.join(format!("rigs/gltf/{name}/glTF"));
        let file = bytes(folder.join(format!("{node}.gltf")));
        let animation = gltf::read_animation(&file, None, None, &mut siblings(&folder));
        let facts = inspect("x.gltf", &file, &mut siblings(&folder)).unwrap();
        let axis = animation.unwrap().curves.frame_axis();
        assert_eq!((facts.frames, facts.rate_hz), (Some(axis.count), Some(axis.rate_hz)), "{name}");
        assert!(axis.count > 10, "{name}: {axis:?}");
    }
    let take = curves(7, 60.0, (0..80).map(|i| i as f32 / 80.0).collect());
    let facts = inspect("own.glb", &written(&take), &mut no_sibling).unwrap();
    assert_eq!((facts.kind, facts.frames, facts.first_frame, facts.rate_hz), ("rig", Some(40), Some(7), Some(60.0)));
}

#[test]
fn correctives_that_follow_nothing_are_told_of() {
    let take = curves(0, 24.0, vec![0.5; 40]);
    assert!(read(&written(&take), None).unwrap().free_correctives.is_empty());
    let mut free = triangle();
    free.shapes[3].driver = Driver::Channel(0);
    let notes = json!({ "first_frame": 0, "frames": 20, "rate_hz": 24.0 });
    let file = gltf::write_animation(&free, &take, &notes).unwrap();
    assert_eq!(read(&file, None).unwrap().free_correctives, ["a+b"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn own_files_read_back_the_same(
        values in prop::collection::vec(-0.5_f32..1.5, 2..200),
        first in -500_i64..5000,
        rate in prop::sample::select(vec![23.976, 24.0, 29.97, 30_000.0 / 1001.0, 48.0, 59.94, 60.0, 119.88, 7.3]),
    ) {
        let mut values = values;
        values.truncate(values.len() / 2 * 2);
        let take = curves(first, rate, values);
        prop_assert_eq!(read(&written(&take), None).unwrap().curves, take);
    }

    #[test]
    fn no_damage_panics(at in 0_usize..2000, value: u8, end in 0_usize..2000) {
        let mut file = keyed("CUBICSPLINE", &[0.0, 0.5, 1.0], &[0.25; 18]);
        let length = file.len();
        file[at % length] = value;
        for part in [&file[..], &file[..end % length]] {
            let _ = read(part, None);
            let _ = read(part, Some(30.0));
        }
    }
}
