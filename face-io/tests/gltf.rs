//! glTF rigs of real tools, small ones built here, and damaged ones.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::{bytes, data, siblings};
use face_io::{gltf, no_sibling};
use face_math::data::{Driver, Rig};
use glam::Vec3;
use proptest::prelude::*;

fn small(json: &str) -> Result<Rig, String> {
    gltf::read(json.as_bytes(), "small", &mut no_sibling).map_err(|error| error.to_string())
}

/// A triangle with one target that lifts its last corner, in buffers inside the JSON. `$NODE`, `$MESH` and `$EXTRAS`
/// are replaced.
fn triangle(node: &str, mesh_extras: &str, primitive_extras: &str) -> String {
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0];
    let bytes: Vec<u8> = floats.iter().flat_map(|float| float.to_le_bytes()).collect();
    let base64 = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, bytes);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"name":"tri"{node}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{{"POSITION":1}}]{primitive_extras}}}]{mesh_extras}}}],
        "buffers":[{{"uri":"data:application/octet-stream;base64,{base64}","byteLength":72}}],
        "bufferViews":[{{"buffer":0,"byteLength":72}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                     {{"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC3"}}]}}"#
    )
}

#[test]
fn scanned_heads_hold_all_their_parts_shapes_and_jaw() {
    let Some(data) = data() else { return };
    for name in ["ict_actor_a", "ict_character_b", "animface_actor"] {
        let rig = gltf::read(&bytes(data.join(format!("actors/{name}/{name}.glb"))), name, &mut no_sibling).unwrap();
        assert_eq!((rig.parts.len(), rig.channels.len(), rig.shapes.len()), (9, 53, 66));
        let count = |of: fn(&Driver) -> bool| rig.shapes.iter().filter(|shape| of(&shape.driver)).count();
        assert_eq!(count(|driver| matches!(driver, Driver::Combination(_))), 11);
        assert_eq!(count(|driver| matches!(driver, Driver::InBetween { .. })), 2);
        assert_eq!(rig.parts[0].name, "face");
        assert_eq!(rig.parts[0].vertices, 0..9547);
        assert!(rig.part("eyeball_R").is_some_and(|part| part.vertices.end as usize == rig.neutral.len()));
        assert_eq!(rig.jaw_pivot_m, Some(Vec3::new(0.0, -0.032, 0.015)));
        assert_eq!(rig.skin.len(), rig.neutral.len());
        let lower = rig.part("teeth_lower").unwrap();
        assert!(lower.vertices.clone().all(|vertex| rig.skin[vertex as usize] > 0.98));
        let upper = rig.part("teeth_upper").unwrap();
        assert!(upper.vertices.clone().all(|vertex| rig.skin[vertex as usize].abs() < 1e-3));
        assert!(rig.parts.iter().all(|part| part.uvs.len() == part.vertices.len()));
        let jaw_open = rig.shapes.iter().find(|shape| shape.name == "jawOpen").unwrap();
        assert!(jaw_open.vertices.is_sorted_by(|a, b| a < b));
        // The chin falls by some centimetres, in every part that hangs on the jaw.
        let lowest = jaw_open.deltas.iter().map(|delta| delta.y).fold(0.0, f32::min);
        assert!(lowest < -0.01 && lowest > -0.06, "{lowest}");
        assert!(lower.vertices.clone().all(|vertex| jaw_open.vertices.binary_search(&vertex).is_ok()));
    }
}

#[test]
fn sample_models_read_with_companions_transforms_and_plain_names() {
    let Some(data) = data() else { return };
    let folder = data.join("rigs/gltf/SimpleMorph/glTF");
    let simple = gltf::read(&bytes(folder.join("SimpleMorph.gltf")), "simple", &mut siblings(&folder)).unwrap();
    assert_eq!(simple.channels, ["target_0", "target_1"]);
    assert_eq!(simple.neutral, [Vec3::ZERO, Vec3::X, Vec3::new(0.5, 0.5, 0.0)]);
    assert_eq!(simple.shapes[0].vertices, [2]);
    assert_eq!(simple.shapes[0].deltas, [Vec3::new(-1.0, 1.0, 0.0)]);
    assert!(simple.skin.is_empty() && simple.jaw_pivot_m.is_none());
    let folder = data.join("rigs/gltf/AnimatedMorphCube/glTF");
    let cube = gltf::read(&bytes(folder.join("AnimatedMorphCube.gltf")), "cube", &mut siblings(&folder)).unwrap();
    assert_eq!((cube.neutral.len(), cube.parts[0].triangles.len(), cube.shapes.len()), (24, 12, 2));
    // Its node scales by 100: the cube of 2 cm in the file is one of 2 m.
    assert!(cube.neutral.iter().all(|corner| (corner.abs() - Vec3::ONE).abs().max_element() < 1e-5));
    assert!((cube.shapes[0].deltas.iter().map(|delta| delta.length()).fold(0.0, f32::max) - 1.893).abs() < 1e-3);
    let missing = gltf::read(&bytes(folder.join("AnimatedMorphCube.gltf")), "cube", &mut no_sibling).unwrap_err();
    assert!(missing.to_string().contains("AnimatedMorphCube.bin"), "{missing}");
    let sparse = gltf::read(&bytes(data.join("rigs/gltf/SimpleSparseAccessor.gltf")), "sparse", &mut no_sibling);
    assert!(sparse.unwrap_err().to_string().contains("no mesh of the 1 in the scene has morph targets"));
}

#[test]
fn nodes_place_vertices_and_displacements() {
    let rig = small(&triangle(
        r#","translation":[1,2,3],"scale":[2,2,-2]"#,
        r#","extras":{"targetNames":["lift"]},"name":"m""#,
        r#","extras":{"part":"nose"}"#,
    ))
    .unwrap();
    assert_eq!((rig.parts[0].name.as_str(), rig.channels[0].as_str()), ("nose", "lift"));
    assert_eq!(rig.neutral, [Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.0, 2.0, 3.0), Vec3::new(1.0, 4.0, 3.0)]);
    assert_eq!(
        (rig.shapes[0].vertices.as_slice(), rig.shapes[0].deltas[0]),
        ([2].as_slice(), Vec3::new(0.0, 0.0, -4.0))
    );
    // A mirrored node turns triangles round.
    assert_eq!(rig.parts[0].triangles, [[0, 2, 1]]);
}

#[test]
fn meshes_of_several_nodes_share_their_shapes() {
    let twice = triangle("", "", "").replace(r#""nodes":[0]"#, r#""nodes":[0,1]"#).replace(
        r#""nodes":[{"mesh":0,"name":"tri"}]"#,
        r#""nodes":[{"mesh":0,"name":"left"},{"mesh":0,"name":"right","translation":[9,0,0]}]"#,
    );
    let rig = small(&twice).unwrap();
    assert_eq!(rig.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(), ["left", "right"]);
    assert_eq!(rig.shapes.len(), 1);
    assert_eq!(rig.shapes[0].vertices, [2, 5]);
    assert_eq!(rig.parts[1].triangles, [[3, 4, 5]]);
}

#[test]
fn mistakes_are_named_with_their_place() {
    let good = triangle("", r#","name":"head""#, "");
    small(&good).unwrap();
    let wrong = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        small(&good.replace(from, to)).unwrap_err()
    };
    for (from, to, says) in [
        (
            r#""POSITION":0"#,
            r#""POSITION":7"#,
            "mesh `head`, primitive 0, POSITION refers to accessor 7, but there are 2",
        ),
        (r#""count":3,"type":"VEC3"},"#, r#""count":8,"type":"VEC3"},"#, "pass the 72 bytes of view 0"),
        (
            r#""byteOffset":36,"componentType":5126,"count":3"#,
            r#""componentType":5126,"count":2"#,
            "2 elements for 3 vertices",
        ),
        (r#""type":"VEC3"},"#, r#""type":"VEC2"},"#, "2 components, 3 are needed"),
        (r#""buffer":0"#, r#""buffer":3"#, "refers to buffer 3"),
        (
            r#""byteLength":72}],
        "bufferViews""#,
            r#""byteLength":99}],"bufferViews""#,
            "it holds 72 bytes where 99 are announced",
        ),
        (
            r#""buffer":0,"byteLength":72"#,
            r#""buffer":0,"byteLength":99"#,
            "view 0 takes 99 bytes from 0, but buffer 0 ends at 72",
        ),
        (r#""mesh":0"#, r#""mesh":4"#, "node 0 refers to mesh 4"),
        (r#""version":"2.0""#, r#""version":"1.0""#, "glTF 1.0"),
        (r#""name":"tri""#, r#""children":[0]"#, "node 0 is reached twice"),
        (r#""name":"head""#, r#""extras":{"targetNames":["a","b"]}"#, "2 targetNames for 1 morph targets"),
        (
            r#""asset":{"#,
            r#""extensionsRequired":["KHR_draco_mesh_compression"],"asset":{"#,
            "KHR_draco_mesh_compression",
        ),
        (r#""asset""#, r#""asset"#, "line 1, column"),
    ] {
        let error = wrong(from, to);
        assert!(error.contains(says), "{error}");
    }
    assert!(small("").unwrap_err().contains("empty"));
    assert!(small("o cube").unwrap_err().contains("no glTF file"));
}

#[test]
fn a_cut_glb_says_where_it_ends() {
    let Some(data) = data() else { return };
    let whole = bytes(data.join("actors/ict_actor_a/ict_actor_a.glb"));
    for end in [0, 3, 11, 19, 1000, 3_000_000, whole.len() - 1] {
        let error = gltf::read(&whole[..end], "cut", &mut no_sibling).unwrap_err().to_string();
        assert!(end < 4 || error.contains(&format!("ends at byte {end}")), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_damage_panics(at in 0_usize..4000, value: u8, end in 0_usize..4000) {
        let mut file = triangle(r#","scale":[1,2,1]"#, r#","extras":{"targetNames":["lift"]}"#, "").into_bytes();
        let length = file.len();
        file[at % length] = value;
        let _ = gltf::read(&file, "damaged", &mut no_sibling);
        let _ = gltf::read(&file[..end % length], "damaged", &mut no_sibling);
    }

    #[test]
    fn no_number_panics(which in 0_usize..40, number in prop::sample::select(vec![0_u64, 1, 2, 5, 255, 65_536, u64::from(u32::MAX), u64::MAX])) {
        // Replaces the which-th number of the JSON by another one.
        let file = triangle("", "", "");
        let digits: Vec<_> = file.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at)
            .filter(|at| file.as_bytes()[at - 1] == b':').collect();
        let at = digits[which % digits.len()];
        let rest = file[at..].trim_start_matches(|c: char| c.is_ascii_digit());
        let _ = small(&format!("{}{number}{rest}", &file[..at]));
    }
}
