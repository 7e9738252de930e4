//! OBJ faces: real ones with quads and texture seams, small ones written here, and damaged ones.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod common;

use common::{bytes, data};
use face_io::{LengthUnit, inspect, no_sibling, obj};
use face_math::data::Rig;
use face_math::rig::{Puppet, Sculpts, join_shapes};
use glam::Vec3;
use proptest::prelude::*;

fn head(text: &str) -> Result<Rig, String> {
    let file = obj::open(text.as_bytes()).map_err(|error| error.to_string())?;
    file.head("head", LengthUnit::Centimetre).map_err(|error| error.to_string())
}

const SQUARES: &str = "# two squares\nmtllib none.mtl\no head\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0\nv 0 1 0\nv 2 0 0\n\
                       v 2 1 0\nvt 0 0\nvt 1 1\nusemtl skin\ns 1\nf 1/1 2/2 \\\n3/1 4/1\ng lips\nf -5/-2 -2/-1 -1 3\n";

#[test]
fn polygons_groups_units_and_lines_that_go_on_are_understood() {
    let rig = head(SQUARES).unwrap();
    let names: Vec<_> = rig.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["head", "lips"]);
    assert_eq!((rig.parts[0].vertices.clone(), rig.parts[1].vertices.clone()), (0..4, 4..8));
    assert_eq!(
        rig.neutral[4..],
        [[1, 0], [1, 1], [2, 0], [2, 1]].map(|[x, y]| Vec3::new(x as f32, y as f32, 0.0) * 0.01)
    );
    assert_eq!(rig.parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(rig.parts[0].uvs, [[0.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]]);
    assert_eq!(rig.parts[1].triangles, [[4, 6, 7], [4, 7, 5]]);
    let facts = inspect("x", SQUARES.as_bytes(), &mut no_sibling).unwrap();
    assert_eq!((facts.kind, facts.format.as_str()), ("mesh", "OBJ"));
}

#[test]
fn mistakes_are_named_with_their_line() {
    for (from, to, says) in [
        ("f 1/1", "f 9/1", "line 15: the face names vertex 9, but there are 6"),
        ("f 1/1", "f 1/3", "line 15: the face names texture coordinates 3, but there are 2"),
        ("f 1/1", "f 0/1", "line 15: `0/1` is no corner"),
        ("f -5/-2", "f -7/-2", "line 17: `-7/-2` is no corner"),
        ("f -5/-2 -2/-1 -1 3", "f 1 2", "line 17: a face of 2 corners"),
        ("v 2 1 0", "v 2 1", "line 9: `2 1` where 3 numbers are needed"),
        ("v 2 1 0", "v 2 1 nan", "line 9: `nan` is not a finite number"),
        ("v 2 1 0", "v 2 1 1e60", "line 9: `1e60` is not a finite number"),
        ("s 1", "smooth 1", "line 13: `smooth` begins no statement"),
    ] {
        assert!(SQUARES.contains(from));
        let error = head(&SQUARES.replace(from, to)).unwrap_err();
        assert!(error.contains(says), "{error}");
    }
    assert!(head("v 0 0 0\n").unwrap_err().contains("1 vertices and no polygons"));
}

#[test]
fn a_folder_of_real_sculpts_is_a_rig_that_meets_each_of_them() {
    let Some(data) = data() else { return };
    let folder = data.join("actors/obj");
    let open = |name: &str| obj::open(&bytes(folder.join(format!("{name}.obj")))).unwrap();
    let neutral = open("generic_neutral_mesh");
    assert_eq!((neutral.vertices(), neutral.faces()), (26_719, 26_384));
    let names = ["eyeBlink_L", "jawOpen", "mouthPucker", "mouthSmile_L"];
    let sculpts = names.map(|name| (name, open(name)));
    let heads: Vec<(&str, Rig)> = sculpts
        .iter()
        .map(|(name, sculpt)| {
            (*name, neutral.sculpted("ict", LengthUnit::Centimetre, "neutral.obj", (name, sculpt)).unwrap())
        })
        .collect();
    let heads: Vec<(&str, &Rig)> = heads.iter().map(|(name, head)| (*name, head)).collect();
    let rig = join_shapes(&heads, "ict", Sculpts::Whole).unwrap();
    assert_eq!(rig.channels, names);
    let parts: Vec<_> = rig.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!((parts.len(), parts[0], parts[1]), (12, "M_Face", "M_BackHead"));
    // The face's vertices keep the numbers of the file; the sides of its seams follow.
    let face = rig.parts[0].vertices.clone();
    assert_eq!((face.start, face.end), (0, 9547));
    let width = rig.neutral.iter().map(|p| p.x).fold(0.0, f32::max);
    assert!((width - 0.124_162).abs() < 1e-6, "{width}");
    let quads = 26_384 * 2;
    assert!(rig.parts.iter().map(|part| part.triangles.len()).sum::<usize>() <= quads);
    let puppet = Puppet::new(&rig).unwrap();
    for (channel, (name, sculpt)) in sculpts.iter().enumerate() {
        let mut weights = vec![0.0; 4];
        weights[channel] = 1.0;
        let posed = puppet.vertices(&weights).unwrap();
        let alone = sculpt.head("x", LengthUnit::Centimetre).unwrap();
        assert_eq!(alone.neutral.len(), posed.len());
        let worst = posed.iter().zip(&alone.neutral).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(worst < 2e-7, "{name}: {worst} m");
        assert!(rig.shapes[channel].vertices.len() < rig.neutral.len());
    }
    let cut = bytes(folder.join("jawOpen.obj"));
    let text = String::from_utf8_lossy(&cut).replacen("v ", "# ", 1);
    let short = obj::open(text.as_bytes());
    let error = match short {
        Ok(short) => neutral.sculpted("x", LengthUnit::Metre, "neutral.obj", ("jawOpen", &short)).unwrap_err(),
        Err(error) => error,
    };
    assert!(error.to_string().contains("26719"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn no_damage_panics(at in 0_usize..400, value in prop::sample::select(b"0123456789-./ \\\nfvgeo#\xff".to_vec()), end in 0_usize..400) {
        let mut file = SQUARES.as_bytes().to_vec();
        let length = file.len();
        file[at % length] = value;
        for part in [&file[..], &file[..end % length]] {
            if let Ok(file) = obj::open(part) {
                let _ = file.head("x", LengthUnit::Metre);
            }
        }
    }
}
