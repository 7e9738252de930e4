//! `load_rig`: a head from a file: what markers are attached to and curves drive.

use face_io::gltf;
use face_math::data::Rig;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

const RIG: Port<Rig> = Port::new("rig", "a head of several parts, its channels and shapes, in metres");

/// Loads a rig from GLB or glTF: parts, morph targets, and the jaw's skin weights.
///
/// Morph targets of the same name over all parts are one shape. A target called `a+b` corrects the combination of the
/// channels `a` and `b`, one called `a@0.5` is an in-between of the channel `a`; every other one is a channel. The
/// joint called `jaw` tells how much each vertex follows the jaw. Split the jaw off with `skin_jaw` where the morph
/// targets hold its motion too.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadRig {
    /// The file, `.glb` or `.gltf`; buffers in files of their own are found beside it. A pattern such as
    /// `actors/*.glb` gives one item for each file that it fits.
    path: String,
    /// Name of the rig in messages and in files written from it.
    name: String,
}

impl Default for LoadRig {
    fn default() -> Self {
        Self { path: String::new(), name: "head".to_owned() }
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
        if !["glb", "gltf"].contains(&super::extension(&source.name).as_str()) && !gltf::detect(&source.bytes) {
            let problem =
                "rigs are read from GLB (.glb) and glTF (.gltf); export the head with its morph targets as one";
            return Err(NodeError::file(&source.name, problem));
        }
        let mut sibling = |path: &str| {
            if Path::new(path).has_root() {
                return Err(std::io::Error::other("only files beside the rig are read, by relative paths"));
            }
            context.sibling(path).map(|bytes| bytes.to_vec()).map_err(std::io::Error::other)
        };
        let rig = gltf::read(&source.bytes, &self.name, &mut sibling);
        Ok(Outputs::default().with(&RIG, rig.map_err(|error| NodeError::file(&source.name, error))?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, made, test_data};
    use serde_json::json;

    fn load(bench: &Bench) -> Result<Rig, String> {
        let node: LoadRig = made(json!({"name": "anna"}));
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
        let error = load(&Bench::default().with_source("head.fbx", b"Kaydara".as_slice())).unwrap_err();
        assert!(error.starts_with("head.fbx: ") && error.contains(".glb"), "{error}");
    }

    #[test]
    fn a_scanned_head_is_read() {
        let Some(path) = test_data("actors/ict_actor_a/ict_actor_a.glb") else { return };
        let rig = load(&Bench::default().with_source("ict_actor_a.glb", std::fs::read(path).unwrap())).unwrap();
        assert_eq!((rig.parts.len(), rig.channels.len(), rig.shapes.len()), (9, 53, 66));
        assert!(rig.jaw_pivot_m.is_some() && rig.skin.len() == rig.neutral.len());
    }
}
