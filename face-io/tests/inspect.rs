//! What files of all kinds are said to hold.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::{bytes, data, files, siblings};
use face_io::{Inspection, LengthUnit, Stats, c3d, inspect, no_sibling};
use face_math::data::Markers;
use glam::Vec3;
use proptest::prelude::*;
use serde_json::Value;
use wire::FrameAxis;

fn of(path: &std::path::Path) -> Result<Inspection, String> {
    let name = path.file_name().unwrap().to_string_lossy();
    inspect(&name, &bytes(path), &mut siblings(path.parent().unwrap())).map_err(|error| error.to_string())
}

#[test]
fn markers_are_counted_and_measured_in_metres() {
    let axis = FrameAxis { first: 3, count: 2, rate_hz: 59.94 };
    let points = vec![Vec3::new(-1.0, 0.0, 2.0), Vec3::NAN, Vec3::new(3.0, 0.5, 2.0), Vec3::new(1.0, 1.0, 5.0)];
    let markers = Markers::new(axis, vec!["a".into(), "b".into()], points).unwrap();
    let file = c3d::write(&markers, LengthUnit::Millimetre, c3d::Flavour::PLAIN).unwrap();
    let facts = inspect("take.c3d", &file, &mut no_sibling).unwrap();
    let json: Value = serde_json::to_value(&facts).unwrap();
    assert_eq!(json["kind"], "markers");
    assert_eq!(json["format"], "C3D, Intel, real");
    assert_eq!((json["frames"].as_u64(), json["first_frame"].as_i64()), (Some(2), Some(3)));
    assert_eq!((json["rate_hz"].as_f64(), json["missing"].as_u64()), (Some(59.94), Some(1)));
    assert_eq!(json["names"], serde_json::json!(["a", "b"]));
    assert_eq!(json["unit"], "mm");
    assert_eq!(facts.min, Some(Stats::Three([-1.0, 0.0, 2.0])));
    assert_eq!(facts.max, Some(Stats::Three([3.0, 1.0, 5.0])));
    assert_eq!(facts.mean, Some(Stats::Three([1.0, 0.5, 3.0])));
    let text = facts.to_string();
    assert!(text.contains("2 from 3 at 59.94 Hz") && text.contains("2 names: a, b"), "{text}");
}

#[test]
fn real_files_of_all_kinds_are_known_for_what_they_are() {
    let Some(data) = data() else { return };
    for (path, kind, format, frames) in [
        ("actors/ict_actor_a/takes/day1_161.c3d", "markers", "C3D, Intel, real", Some(1846)),
        ("mocap/c3d_formats/DEC_INT.C3D", "markers", "C3D, DEC, integer", Some(89)),
        ("actors/ict_actor_a/truth/day1_161.csv", "curves", "CSV, curves", Some(1846)),
        ("actors/ict_actor_a/rom/rom_162.csv", "curves", "CSV, Live Link Face", Some(1830)),
        ("actors/ict_actor_a/neutral_markers.csv", "markers", "CSV, neutral markers", Some(1)),
        ("faces/subject_a/landmarks68.csv", "landmarks", "CSV, landmarks", Some(428)),
        ("actors/ict_actor_a/ict_actor_a.glb", "rig", "GLB", None),
        ("rigs/gltf/AnimatedMorphCube/glTF/AnimatedMorphCube.gltf", "rig", "glTF", Some(127)),
        ("rigs/gltf/SimpleSparseAccessor.gltf", "mesh", "glTF", None),
        ("rigs/ufbx/maya_blend_shape_cube_7100_ascii.fbx", "rig", "FBX 7100, ASCII", None),
        ("rigs/ufbx/blender440_shape_weight_anim_7400_binary.fbx", "rig", "FBX 7400, binary", None),
        ("actors/obj/jawOpen.obj", "mesh", "OBJ", None),
        ("actors/regions.json", "regions", "regions", None),
    ] {
        let facts = of(&data.join(path)).unwrap();
        assert_eq!((facts.kind, facts.format.as_str(), facts.frames), (kind, format, frames), "{path}");
        assert!(!facts.names.is_empty(), "{path}");
    }
    let rig = serde_json::to_value(of(&data.join("actors/ict_actor_a/ict_actor_a.glb")).unwrap()).unwrap();
    assert_eq!((rig["channels"].as_u64(), rig["combinations"].as_u64()), (Some(53), Some(11)));
    assert_eq!((rig["in_betweens"].as_u64(), rig["vertices"].as_u64()), (Some(2), Some(26_783)));
    assert!(rig.get("frames").is_none());
}

#[test]
fn unknown_and_damaged_files_say_so() {
    let Some(data) = data() else { return };
    let error = |path: &str| of(&data.join(path)).unwrap_err();
    assert!(error("mocap/c3d_other/Empty.c3d").contains("C3D: the file is empty"));
    assert!(error("exr/stripes.exr").contains("`stripes.exr` is none of the kinds of file that are read here: C3D"));
    for path in files(&data.join("mocap"), ".c3d") {
        let whole = bytes(&path);
        if !whole.is_empty() {
            let error = inspect("x.c3d", &whole[..whole.len() * 2 / 3], &mut no_sibling).unwrap_err().to_string();
            assert!(error.contains("the file ends at byte"), "{error}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..700), which in 0_usize..8) {
        let ending = ["c3d", "glb", "csv", "png", "ron", "bin", "fbx", "obj"][which];
        let _ = inspect(&format!("noise.{ending}"), &bytes, &mut no_sibling);
    }

    #[test]
    fn no_text_panics(text in "[ -~\n\"{}(),:#]{0,200}", which in 0_usize..4) {
        let ending = ["csv", "gltf", "json", "ron"][which];
        let _ = inspect(&format!("noise.{ending}"), text.as_bytes(), &mut no_sibling);
    }
}
