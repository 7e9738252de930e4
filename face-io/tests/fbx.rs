//! FBX rigs of Maya and Blender, in several versions, binary and ASCII, small ones written here, and damaged ones.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::{bytes, data, files};
use face_io::{LengthUnit, fbx, inspect, no_sibling, obj};
use face_math::data::{Driver, Rig};
use face_math::rig::Puppet;
use glam::Vec3;
use proptest::prelude::*;

/// A triangle in centimetres, Z up, with one channel of two targets, and a skin of a skull and a jaw.
fn triangle() -> String {
    let geometry =
        |id: u32, what: &str, body: &str| format!("Geometry: {id}, \"Geometry::{what}\", \"{what}\" {{\n{body}}}\n");
    let doubles = |name: &str, numbers: &[f64]| {
        let text: Vec<_> = numbers.iter().map(ToString::to_string).collect();
        format!("{name}: *{} {{\na: {}\n}}\n", numbers.len(), text.join(","))
    };
    let shape = |id: u32, name: &str, offset: [f64; 3]| {
        let body = format!("Version: 100\nIndexes: *1 {{\na: 2\n}}\n{}", doubles("Vertices", &offset));
        geometry(id, name, &body).replace(&format!("\"{name}\" {{"), "\"Shape\" {")
    };
    let matrix = |x: f64| doubles("Transform", &[1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, 0., 0., 1.]);
    let cluster = |id: u32, vertices: &str, weights: &[f64], pivot: f64| {
        let count = weights.len();
        format!(
            "Deformer: {id}, \"SubDeformer::\", \"Cluster\" {{\nVersion: 100\nIndexes: *{count} {{\na: {vertices}\n}}\n{}{}{}}}\n",
            doubles("Weights", weights),
            matrix(-pivot),
            matrix(pivot).replace("Transform", "TransformLink"),
        )
    };
    let model = |id: u32, name: &str, kind: &str, x: f64| {
        format!(
            "Model: {id}, \"Model::{name}\", \"{kind}\" {{\nVersion: 232\nProperties70: {{\nP: \"Lcl Translation\", \
             \"Lcl Translation\", \"\", \"A\",{x},0,0\n}}\n}}\n"
        )
    };
    let objects = [
        geometry(
            1,
            "Mesh",
            &format!(
                "{}PolygonVertexIndex: *3 {{\na: 0,1,-3\n}}\nGeometryVersion: 124\n",
                doubles("Vertices", &[0., 0., 0., 10., 0., 0., 0., 0., 10.])
            ),
        ),
        model(2, "face", "Mesh", 0.0),
        "Deformer: 3, \"Deformer::faceShapes\", \"BlendShape\" {\nVersion: 100\n}\n".to_owned(),
        format!(
            "Deformer: 4, \"SubDeformer::faceShapes.lift\", \"BlendShapeChannel\" {{\nVersion: 100\nDeformPercent: 30\n{}}}\n",
            doubles("FullWeights", &[50.0, 100.0])
        ),
        shape(5, "half", [0.0, -1.0, 3.0]),
        shape(6, "whole", [0.0, 0.0, 4.0]),
        "Deformer: 7, \"Deformer::skin\", \"Skin\" {\nVersion: 101\n}\n".to_owned(),
        cluster(8, "0,1", &[1.0, 0.75], 0.0),
        cluster(9, "1,2", &[0.25, 1.0], 5.0),
        model(10, "skull", "LimbNode", 0.0),
        model(11, "rig:Jaw", "LimbNode", 5.0),
    ];
    let links =
        [(2, 0), (1, 2), (3, 1), (4, 3), (5, 4), (6, 4), (7, 1), (8, 7), (9, 7), (10, 8), (11, 9), (10, 0), (11, 10)];
    let links = links.map(|(from, to)| format!("C: \"OO\",{from},{to}\n")).concat();
    format!(
        "; FBX 7.4.0 project file\nFBXHeaderExtension: {{\nFBXHeaderVersion: 1003\nFBXVersion: 7400\n}}\n\
         GlobalSettings: {{\nVersion: 1000\nProperties70: {{\nP: \"UpAxis\", \"int\", \"Integer\", \"\",2\n\
         P: \"UpAxisSign\", \"int\", \"Integer\", \"\",1\nP: \"FrontAxis\", \"int\", \"Integer\", \"\",1\n\
         P: \"FrontAxisSign\", \"int\", \"Integer\", \"\",-1\nP: \"CoordAxis\", \"int\", \"Integer\", \"\",0\n\
         P: \"CoordAxisSign\", \"int\", \"Integer\", \"\",1\nP: \"UnitScaleFactor\", \"double\", \"Number\", \"\",1\n}}\n}}\n\
         Objects: {{\n{}}}\nConnections: {{\n{links}}}\n",
        objects.concat()
    )
}

fn read(text: &str) -> Result<Rig, String> {
    fbx::read(text.as_bytes(), "small").map_err(|error| error.to_string())
}

#[test]
fn in_betweens_jaw_unit_and_axes_come_out_as_the_rig_has_them() {
    let rig = read(&triangle()).unwrap();
    let near = |a: Vec3, b: [f32; 3]| assert!(a.abs_diff_eq(Vec3::from(b), 1e-7), "{a} {b:?}");
    // Z up became Y up: (x, y, z) is (x, z, −y), in metres.
    near(rig.neutral[1], [0.1, 0.0, 0.0]);
    near(rig.neutral[2], [0.0, 0.1, 0.0]);
    assert_eq!((rig.parts[0].name.as_str(), rig.channels.as_slice()), ("face", &["lift".to_owned()][..]));
    let names: Vec<_> = rig.shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["lift", "lift@0.5"]);
    assert_eq!(rig.shapes[1].driver, Driver::InBetween { channel: 0, peak: 0.5 });
    // At each target's weight the vertex is where the target has it, and half way between them in the middle.
    let puppet = Puppet::new(&rig).unwrap();
    for (weight, at) in
        [(0.5, [0.0, 0.13, 0.01]), (1.0, [0.0, 0.14, 0.0]), (0.75, [0.0, 0.135, 0.005]), (0.25, [0.0, 0.115, 0.005])]
    {
        near(puppet.vertices(&[weight]).unwrap()[2], at);
    }
    assert_eq!(rig.skin, [0.0, 0.25, 1.0]);
    near(rig.jaw_pivot_m.unwrap(), [0.05, 0.0, 0.0]);
}

#[test]
fn what_a_rig_cannot_hold_is_refused_with_its_place() {
    let whole = triangle();
    let beyond = whole.replace("a: 50,100", "a: 50,200");
    assert!(read(&beyond).unwrap_err().contains("mesh `face`: blend channel `lift` has a target at 200 %"));
    let before = whole.replace("a: 50,100", "a: -50,100");
    assert!(read(&before).unwrap_err().contains("has a target at -50 %"));
    let outside = whole.replace("Indexes: *1 {\na: 2", "Indexes: *1 {\na: 7");
    assert!(read(&outside).is_err());
    let unshaped = whole.replace("C: \"OO\",3,1\n", "");
    assert!(read(&unshaped).unwrap_err().contains("none of the 1 meshes in the scene has blend shapes"));
    assert!(fbx::read(b"", "x").unwrap_err().to_string().contains("empty"));
    assert!(read("Kaydara").unwrap_err().starts_with("FBX: "));
}

#[test]
fn real_files_of_all_versions_read_alike() {
    let Some(data) = data() else { return };
    let folder = data.join("rigs/ufbx");
    let mut cubes = Vec::new();
    for path in files(&folder, ".fbx") {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let file = bytes(&path);
        let facts = inspect("head", &file, &mut no_sibling).unwrap();
        let flavour = if name.contains("ascii") { "ASCII" } else { "binary" };
        assert!(facts.format.starts_with("FBX ") && facts.format.ends_with(flavour), "{name}: {}", facts.format);
        if name.contains("cache") {
            assert!(fbx::read(&file, "x").unwrap_err().to_string().contains("none of the 2 meshes"));
            continue;
        }
        let rig = fbx::read(&file, "x").unwrap();
        let channels = if name.contains("279") { 1 } else { 2 };
        assert_eq!((rig.channels.len(), rig.shapes.len(), rig.parts.len()), (channels, channels, 1), "{name}");
        let size = rig.neutral.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        if name.starts_with("maya") {
            // Cubes of 1 cm, by Maya.
            assert!((size - 0.005).abs() < 1e-6 && rig.channels == ["TopH", "TopV"], "{name}");
            cubes.push(rig);
        } else {
            // Cubes of 2 m, by Blender, whose old ASCII exporter wrote them as centimetres.
            let expected = if name.contains("6100") { 0.01 } else { 1.0 };
            assert!((size / expected - 1.0).abs() < 1e-5, "{name}: {size}");
        }
    }
    assert_eq!(cubes.len(), 4);
    for cube in &cubes[1..] {
        assert_eq!((&cube.neutral, &cube.parts[0].triangles), (&cubes[0].neutral, &cubes[0].parts[0].triangles));
        for (shape, other) in cube.shapes.iter().zip(&cubes[0].shapes) {
            assert_eq!(shape.vertices, other.vertices);
            assert!(shape.deltas.iter().zip(&other.deltas).all(|(a, b)| a.abs_diff_eq(*b, 1e-8)));
        }
    }
}

/// How far the face in an OBJ file is from the nearest one that two channels of the rig can make, and their weights.
fn fit(rig: &Rig, face: &Rig) -> (f32, Vec<f32>) {
    let pose = |weights: &[f32]| Puppet::new(rig).unwrap().vertices(weights).unwrap();
    // Both channels of these cubes move other axes, so each weight shows by itself.
    let target: Vec<Vec3> = face.neutral[..8].to_vec();
    let weights: Vec<f32> = (0..2)
        .map(|channel| {
            let shape = &rig.shapes[channel];
            let own = shape.vertices.iter().zip(&shape.deltas).filter(|(vertex, _)| **vertex < 8);
            let (dot, square) = own.fold((0.0, 0.0), |(dot, square), (vertex, delta)| {
                let moved = target[*vertex as usize] - rig.neutral[*vertex as usize];
                let along = *delta * Vec3::from(delta.abs().to_array().map(|by| f32::from(u8::from(by > 1e-4))));
                (dot + moved.dot(along), square + along.length_squared())
            });
            dot / square
        })
        .collect();
    let far = pose(&weights).iter().zip(&target).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    (far, weights)
}

#[test]
fn shapes_meet_the_faces_that_blender_wrote_beside_them() {
    let Some(data) = data() else { return };
    let folder = data.join("rigs/ufbx");
    let rig = fbx::read(&bytes(folder.join("blender_331_static_blend_shape_7400_binary.fbx")), "x").unwrap();
    let face = obj::open(&bytes(folder.join("blender_331_static_blend_shape.obj"))).unwrap();
    let (far, weights) = fit(&rig, &face.head("face", LengthUnit::Metre).unwrap());
    assert!(far < 2e-6, "{far} m at {weights:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_damage_panics(damage in prop::collection::vec((0_usize..6000, any::<u8>()), 1..4), end in 0_usize..6000) {
        let mut file = triangle().into_bytes();
        let length = file.len();
        for (at, value) in damage {
            file[at % length] = value;
        }
        let _ = fbx::read(&file, "damaged");
        let _ = fbx::read(&file[..end % length], "damaged");
    }

    #[test]
    fn no_damage_of_real_files_panics(which in 0_usize..8, at in any::<u32>(), value: u8, cut: bool) {
        if let Some(data) = data() {
            let path = files(&data.join("rigs/ufbx"), ".fbx").swap_remove(which % 8);
            let mut file = bytes(path);
            let at = at as usize % file.len();
            file[at] = value;
            let _ = fbx::read(if cut { &file[..at] } else { &file }, "damaged");
        }
    }
}
