//! Writes a rig, at rest or moving, as a GLB file that any viewer plays.
//!
//! Every shape becomes a morph target with a weight track of its own: the weights of combinations and in-betweens are
//! computed here, since glTF does not know them. A jaw that is a joint of the rig becomes a joint of the file; glTF
//! morphs first and skins then, which is the order of section 6 of the deepfake capture paper.

mod bin;
mod surface;

use crate::WriteError;
use crate::motion::{Motion, jaw_shares};
use bin::Bin;
use face_math::data::{Curves, Rig};
use glam::Vec3;
use serde_json::{Value, json};

const FORMAT: &str = "GLB";

/// Nodes of a written file.
const HEAD_NODE: usize = 0;
const SKULL_NODE: usize = 1;
const JAW_NODE: usize = 2;

/// Writes a rig at rest as GLB. `provenance` is kept in `asset.extras`.
///
/// The rig's own skin (or, where the jaw has been split off, that one) is written with the joints `skull` and `jaw`.
///
/// # Errors
/// Where the rig is too large for the format, or a skin weight is not between 0 and 1.
pub fn write(rig: &Rig, provenance: &Value) -> Result<Vec<u8>, WriteError> {
    write_file(rig, None, provenance)
}

/// Writes a rig moved by curves as GLB. `provenance` is kept in `asset.extras`.
///
/// Time begins at 0 s with the first frame; one key a frame, straight lines between them. Curves of other channels
/// than the rig's are left out.
///
/// # Errors
/// Where a channel of the rig has no curve, a value is not finite, or the rig does not fit the format.
pub fn write_animation(rig: &Rig, curves: &Curves, provenance: &Value) -> Result<Vec<u8>, WriteError> {
    let motion = Motion::of(rig, curves, FORMAT)?;
    write_file(rig, Some(&motion), provenance)
}

fn write_file(rig: &Rig, motion: Option<&Motion>, provenance: &Value) -> Result<Vec<u8>, WriteError> {
    let mut bin = Bin::default();
    let share = jaw_shares(rig, FORMAT)?;
    let (materials, material_of) = materials(rig);
    let mut primitives = Vec::with_capacity(rig.parts.len());
    for (part, material) in rig.parts.iter().zip(material_of) {
        let mut primitive = surface::primitive(&mut bin, rig, part, share)?;
        primitive["material"] = json!(material);
        primitives.push(primitive);
    }
    let names: Vec<&str> = rig.shapes.iter().map(|shape| shape.name.as_str()).collect();
    let mut head = json!({ "name": rig.name, "mesh": 0 });
    let mut nodes = Vec::new();
    let mut file = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("grimace ", env!("CARGO_PKG_VERSION")),
            "extras": provenance,
        },
        "scene": 0,
        "meshes": [{ "name": rig.name, "primitives": primitives, "extras": { "targetNames": names } }],
        "materials": materials,
    });
    if !names.is_empty() {
        file["meshes"][0]["weights"] = json!(vec![0.0; names.len()]);
    }
    let mut tops = vec![HEAD_NODE];
    let pivot = rig.jaw_pivot_m.unwrap_or(Vec3::ZERO);
    if share.is_some() {
        head["skin"] = json!(0);
        tops.push(SKULL_NODE);
        let inverse_bind = bin.matrices(&[Vec3::ZERO, -pivot])?;
        file["skins"] = json!([{
            "name": "head",
            "joints": [SKULL_NODE, JAW_NODE],
            "skeleton": SKULL_NODE,
            "inverseBindMatrices": inverse_bind,
        }]);
    }
    nodes.push(head);
    if share.is_some() {
        nodes.push(json!({ "name": "skull", "children": [JAW_NODE] }));
        nodes.push(json!({ "name": "jaw", "translation": pivot.to_array() }));
    }
    file["nodes"] = json!(nodes);
    file["scenes"] = json!([{ "name": rig.name, "nodes": tops }]);
    if let Some(motion) = motion.filter(|motion| !motion.times_s.is_empty()) {
        file["animations"] = animation(&mut bin, rig, motion, pivot)?;
    }
    bin.finish(file)
}

/// One material for each colour, and the material of each part. Colours are held between 0 and 1.
fn materials(rig: &Rig) -> (Vec<Value>, Vec<usize>) {
    let mut colours: Vec<[f32; 3]> = Vec::new();
    let of_part = rig
        .parts
        .iter()
        .map(|part| {
            let colour = part.colour.map(|channel| if channel.is_nan() { 0.0 } else { channel.clamp(0.0, 1.0) });
            colours.iter().position(|other| other.map(f32::to_bits) == colour.map(f32::to_bits)).unwrap_or_else(|| {
                colours.push(colour);
                colours.len() - 1
            })
        })
        .collect();
    let material = |[red, green, blue]: &[f32; 3]| {
        json!({ "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6 } })
    };
    (colours.iter().map(material).collect(), of_part)
}

fn animation(bin: &mut Bin, rig: &Rig, motion: &Motion, pivot: Vec3) -> Result<Value, WriteError> {
    let input = bin.times(&motion.times_s)?;
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    let mut track = |node: usize, path: &str, output: usize| {
        channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
        samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
    };
    if !rig.shapes.is_empty() {
        track(HEAD_NODE, "weights", bin.scalars(&motion.shape_weights)?);
    }
    if !motion.jaw.is_empty() {
        let rotations: Vec<[f32; 4]> = motion.jaw.iter().map(|key| key.rotation.to_array()).collect();
        let translations: Vec<Vec3> = motion.jaw.iter().map(|key| key.joint_translation_m(pivot)).collect();
        track(JAW_NODE, "rotation", bin.quaternions(&rotations)?);
        track(JAW_NODE, "translation", bin.points(&translations)?);
    }
    Ok(json!([{ "name": "performance", "samplers": samplers, "channels": channels }]))
}
