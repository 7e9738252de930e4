//! `load_rig`: a head from a file: what markers are attached to and curves drive.

use crate::unit::Unit;
use face_io::{fbx, gltf, obj};
use face_math::data::Rig;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port, SourceFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

const RIG: Port<Rig> = Port::new("rig", "a head of several parts, its channels and shapes, in metres");

/// Loads a rig from GLB, glTF or FBX, or one shape of a rig from OBJ.
///
/// Shapes (morph targets, blend shapes) of the same name over all parts are one shape. One called `a+b` corrects the
/// combination of the channels `a` and `b`, one called `a@0.5` is an in-between of the channel `a`; every other one is a
/// channel. In-between targets of FBX get such names. The joint called `jaw` tells how much each vertex follows the jaw.
/// Split the jaw off with `skin_jaw` where the shapes hold its motion too.
///
/// A folder of OBJ files is a rig with one shape a file: load it with a pattern (`sculpts/*.obj`) and `neutral`, which
/// gives one item a file, and put the items together with `join_shapes`. The surface (polygons, texture coordinates,
/// groups as parts) is that of the neutral file; vertices are matched by their numbers.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadRig {
    /// The file: `.glb`, `.gltf`, `.fbx` or `.obj`; buffers in files of their own are found beside it. A pattern such as
    /// `actors/*.glb` gives one item for each file that it fits.
    path: String,
    /// Name of the rig in messages and in files written from it.
    name: String,
    /// For OBJ: the file of the neutral face, beside the others, such as `neutral.obj`. Every other file is the shape of
    /// its own name.
    neutral: Option<String>,
    /// For OBJ, which states none: the unit of the positions.
    unit: Option<Unit>,
}

impl Default for LoadRig {
    fn default() -> Self {
        Self { path: String::new(), name: "head".to_owned(), neutral: None, unit: None }
    }
}

graph_core::register!(LoadRig);

#[typetag::serde(name = "load_rig")]
impl Node for LoadRig {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&RIG)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let rig = match Format::of(&source) {
            Some(Format::Obj) => self.sculpt(context, &source)?,
            Some(_) if self.neutral.is_some() || self.unit.is_some() => {
                let parameter = if self.neutral.is_some() { "neutral" } else { "unit" };
                let problem = format!("{} states that itself; leave the parameter to OBJ files", source.name);
                return Err(NodeError::parameter(parameter, problem));
            }
            Some(Format::Fbx) => {
                fbx::read(&source.bytes, &self.name).map_err(|error| NodeError::file(&source.name, error))?
            }
            Some(Format::Gltf) => {
                let rig = gltf::read(&source.bytes, &self.name, &mut super::beside(context));
                rig.map_err(|error| NodeError::file(&source.name, error))?
            }
            None => {
                let problem = "rigs are read from GLB (.glb), glTF (.gltf), FBX (.fbx) and OBJ (.obj); export the head \
                               with its shapes as one of them";
                return Err(NodeError::file(&source.name, problem));
            }
        };
        Ok(Outputs::default().with(&RIG, rig))
    }
}

/// What a file is, by its ending or else by its content.
#[derive(Clone, Copy)]
enum Format {
    Gltf,
    Fbx,
    Obj,
}

impl Format {
    fn of(source: &SourceFile) -> Option<Self> {
        match super::extension(&source.name).as_str() {
            "glb" | "gltf" => Some(Self::Gltf),
            "fbx" => Some(Self::Fbx),
            "obj" => Some(Self::Obj),
            _ if gltf::detect(&source.bytes) => Some(Self::Gltf),
            _ if fbx::detect(&source.bytes) => Some(Self::Fbx),
            _ => None,
        }
    }
}

impl LoadRig {
    /// The neutral face with the shape that an OBJ file is; the neutral face alone where the file is that one.
    fn sculpt(&self, context: &Context<'_>, source: &SourceFile) -> Result<Rig, NodeError> {
        let wrong = |error: face_io::ReadError| NodeError::file(&source.name, error);
        let Some(neutral) = &self.neutral else {
            let problem = format!("{} is one face; say which file beside it is the neutral one", source.name);
            return Err(NodeError::parameter("neutral", problem));
        };
        let Some(unit) = self.unit else {
            let problem = format!("{} states no unit, as no OBJ file does; say which (m, cm, mm …)", source.name);
            return Err(NodeError::parameter("unit", problem));
        };
        let face = obj::open(&source.bytes).map_err(wrong)?;
        if *neutral == source.name {
            return face.head(&self.name, unit.into()).map_err(wrong);
        }
        if super::extension(neutral) != "obj" || Path::new(neutral).has_root() {
            let problem =
                format!("`{neutral}` is no OBJ file beside {}; give its name, such as `neutral.obj`", source.name);
            return Err(NodeError::parameter("neutral", problem));
        }
        let bytes = context.sibling(neutral).map_err(|error| NodeError::parameter("neutral", error))?;
        let base = obj::open(&bytes).map_err(|error| NodeError::file(neutral, error))?;
        let shape = source.name.rsplit_once('.').map_or(source.name.as_str(), |(stem, _)| stem);
        base.sculpted(&self.name, unit.into(), neutral, (shape, &face)).map_err(wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, made, test_data};
    use serde_json::json;

    fn load(bench: &Bench) -> Result<Rig, String> {
        load_with(json!({"name": "anna"}), bench)
    }

    fn load_with(parameters: serde_json::Value, bench: &Bench) -> Result<Rig, String> {
        let node: LoadRig = made(parameters);
        let outputs = bench.compute(&node, &Inputs::default());
        outputs.map(|outputs| outputs.get(&RIG).unwrap().clone()).map_err(|error| error.to_string())
    }

    /// One triangle and one morph target, in a buffer of its own called `buffer`.
    fn triangle(buffer: &str) -> (Vec<u8>, Vec<u8>) {
        let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.5, 0.0, 0.0, 0.5];
        let bytes: Vec<u8> = floats.iter().flat_map(|number| number.to_le_bytes()).collect();
        let accessor = |view: usize, max: [f32; 3]| json!({"bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": max});
        let file = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{
                "name": "face", "extras": {"targetNames": ["jawOpen"]},
                "primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}]}],
            }],
            "accessors": [accessor(0, [1.0, 1.0, 0.0]), accessor(1, [0.0, 0.0, 0.5])],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 36},
                {"buffer": 0, "byteOffset": 36, "byteLength": 36},
            ],
            "buffers": [{"uri": buffer, "byteLength": 72}],
        });
        (serde_json::to_vec(&file).unwrap(), bytes)
    }

    #[test]
    fn buffers_beside_the_file_are_read() {
        let (file, buffer) = triangle("face%20data.bin");
        let rig = load(&Bench::default().with_source("a.gltf", file).with_sibling("face data.bin", buffer)).unwrap();
        assert_eq!(
            (rig.name.as_str(), rig.neutral.len(), rig.channels.as_slice()),
            ("anna", 3, &["jawOpen".into()][..])
        );
        assert_eq!(rig.shapes[0].deltas[0], glam::Vec3::Z * 0.5);
    }

    #[test]
    fn missing_and_foreign_buffers_are_errors_that_name_them() {
        let (file, _) = triangle("lost.bin");
        let error = load(&Bench::default().with_source("a.gltf", file)).unwrap_err();
        assert!(error.starts_with("a.gltf: ") && error.contains("lost.bin"), "{error}");
        let (file, _) = triangle("/etc/hostname");
        let error = load(&Bench::default().with_source("a.gltf", file)).unwrap_err();
        assert!(error.contains("relative paths"), "{error}");
    }

    #[test]
    fn other_files_are_refused() {
        let error = load(&Bench::default().with_source("head.ma", b"//Maya".as_slice())).unwrap_err();
        assert!(error.starts_with("head.ma: ") && error.contains(".glb"), "{error}");
        let error = load(&Bench::default().with_source("head.fbx", b"Kaydara".as_slice())).unwrap_err();
        assert!(error.starts_with("head.fbx: FBX: "), "{error}");
    }

    #[test]
    fn sculpts_take_their_surface_from_the_neutral_face() {
        let neutral = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let bench =
            |name: &str, bytes: &str| Bench::default().with_source(name, bytes).with_sibling("rest.obj", neutral);
        let with = |parameters: serde_json::Value, bytes: &str| load_with(parameters, &bench("smile.obj", bytes));
        let whole = json!({"neutral": "rest.obj", "unit": "cm"});
        let smile = with(whole.clone(), "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 3 2\n").unwrap();
        assert_eq!(
            (smile.channels.as_slice(), smile.parts[0].triangles.as_slice()),
            (&["smile".into()][..], &[[0, 1, 2]][..])
        );
        assert_eq!((smile.shapes[0].vertices.as_slice(), smile.shapes[0].deltas[0]), (&[1][..], glam::Vec3::X * 0.01));
        let rest = load_with(whole.clone(), &bench("rest.obj", neutral)).unwrap();
        assert!(rest.shapes.is_empty() && rest.neutral == smile.neutral);
        let error = with(whole, "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 1\nf 1 3 2\n").unwrap_err();
        assert!(
            error.starts_with("smile.obj: ") && error.contains("4 vertices") && error.contains("rest.obj has 3"),
            "{error}"
        );
        assert!(with(json!({"unit": "cm"}), neutral).unwrap_err().contains("`neutral`"));
        assert!(with(json!({"neutral": "rest.obj"}), neutral).unwrap_err().contains("`unit`"));
        assert!(with(json!({"neutral": "lost.obj", "unit": "m"}), neutral).unwrap_err().contains("lost.obj"));
        let error =
            load_with(json!({"unit": "m"}), &Bench::default().with_source("a.glb", b"glTF".as_slice())).unwrap_err();
        assert!(error.contains("`unit`"), "{error}");
    }

    #[test]
    fn an_fbx_head_is_read() {
        let Some(path) = test_data("rigs/ufbx/maya_blend_shape_cube_7100_binary.fbx") else { return };
        let rig = load(&Bench::default().with_source("cube.fbx", std::fs::read(path).unwrap())).unwrap();
        assert_eq!((rig.name.as_str(), rig.channels.as_slice()), ("anna", &["TopH".to_owned(), "TopV".to_owned()][..]));
    }

    #[test]
    fn a_scanned_head_is_read() {
        let Some(path) = test_data("actors/ict_actor_a/ict_actor_a.glb") else { return };
        let rig = load(&Bench::default().with_source("ict_actor_a.glb", std::fs::read(path).unwrap())).unwrap();
        assert_eq!((rig.parts.len(), rig.channels.len(), rig.shapes.len()), (9, 53, 66));
        assert!(rig.jaw_pivot_m.is_some() && rig.skin.len() == rig.neutral.len());
    }
}
