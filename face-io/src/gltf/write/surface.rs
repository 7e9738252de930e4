//! A part of a rig as a primitive: its surface, normals, share of the jaw and morph targets.

use super::bin::Bin;
use crate::WriteError;
use crate::surface::normals;
use face_math::data::{Part, Rig};
use serde_json::{Value, json};

/// Writes the arrays of a part and answers with its primitive, all but the material.
pub(super) fn primitive(bin: &mut Bin, rig: &Rig, part: &Part, share: Option<&[f32]>) -> Result<Value, WriteError> {
    let (first, end) = (part.vertices.start, part.vertices.end);
    let range = first as usize..end as usize;
    let positions = &rig.neutral[range.clone()];
    let fits = |found: usize, expected: usize, what: &'static str| {
        if found == expected { Ok(()) } else { Err(WriteError::Fit { format: super::FORMAT, what, expected, found }) }
    };
    if positions.is_empty() || part.triangles.is_empty() {
        let problem = "is that of a part without vertices or triangles, which the format cannot hold";
        return Err(WriteError::Name { format: super::FORMAT, name: part.name.clone(), problem });
    }
    let corners: Vec<u32> =
        part.triangles.iter().flatten().filter(|corner| part.vertices.contains(corner)).map(|c| c - first).collect();
    fits(corners.len(), part.triangles.len() * 3, "corners of a part that are its own vertices")?;

    let mut attributes = json!({
        "POSITION": bin.positions(positions)?,
        "NORMAL": bin.normals(&normals(positions, &corners))?,
    });
    if !part.uvs.is_empty() {
        fits(part.uvs.len(), positions.len(), "texture coordinates of a part")?;
        attributes["TEXCOORD_0"] = json!(bin.uvs(&part.uvs)?);
    }
    if let Some(share) = share {
        // Joints without weight must be joint 0.
        let (joints, weights): (Vec<[u8; 4]>, Vec<[f32; 4]>) = share[range]
            .iter()
            .map(|share| match *share {
                0.0 => ([0; 4], [1.0, 0.0, 0.0, 0.0]),
                1.0 => ([1, 0, 0, 0], [1.0, 0.0, 0.0, 0.0]),
                share => ([0, 1, 0, 0], [1.0 - share, share, 0.0, 0.0]),
            })
            .unzip();
        attributes["JOINTS_0"] = json!(bin.joints(&joints)?);
        attributes["WEIGHTS_0"] = json!(bin.joint_weights(&weights)?);
    }
    let indices = bin.corners(&corners, positions.len())?;
    let mut targets = Vec::with_capacity(rig.shapes.len());
    for shape in &rig.shapes {
        let from = shape.vertices.partition_point(|vertex| *vertex < first);
        let to = shape.vertices.partition_point(|vertex| *vertex < end);
        let moved: Vec<u32> = shape.vertices[from..to].iter().map(|vertex| vertex - first).collect();
        targets.push(json!({ "POSITION": bin.displacements(positions.len(), &moved, &shape.deltas[from..to])? }));
    }
    let mut primitive = json!({ "attributes": attributes, "indices": indices, "extras": { "part": part.name } });
    if !targets.is_empty() {
        primitive["targets"] = json!(targets);
    }
    Ok(primitive)
}
