//! Blend channels of a mesh as shapes: a channel with several targets becomes a shape and its in-betweens.
//!
//! FBX blends from target to target: at a weight w between the targets p and q, the offset is that of both, mixed in a
//! straight line. A rig adds instead: its main shape moves in a straight line from 0 to 1, and an in-between adds what
//! is missing at its peak. So, with T(p) the target at p and D the rig's offsets (all in the unit of the mesh),
//!
//! ```text
//! D(a) = T(1),   D(a@p) = T(p) − p T(1)
//! ```

use super::vector;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Displaced vertices of a mesh.
pub(super) type Offsets = BTreeMap<u32, DVec3>;

/// The shapes of a mesh by name.
pub(super) fn shapes(mesh: &ufbx::Mesh, vertices: usize) -> Result<Vec<(String, Offsets)>, String> {
    let channels: Vec<&ufbx::BlendChannel> =
        mesh.blend_deformers.iter().flat_map(|deformer| deformer.channels.iter()).map(|channel| &**channel).collect();
    let short = |channel: &ufbx::BlendChannel| {
        let whole: &str = &channel.element.name;
        whole.rsplit_once('.').map_or(whole, |(_, own)| own).to_owned()
    };
    let mut seen = BTreeSet::new();
    // Two deformers may have a channel of one name each; then the deformer's name tells them apart.
    let apart = channels.iter().all(|channel| seen.insert(short(channel)));
    let mut shapes = Vec::new();
    for (index, channel) in channels.iter().enumerate() {
        let name = if apart { short(channel) } else { channel.element.name.to_string() };
        let name = if name.is_empty() { format!("shape_{index}") } else { name };
        shapes.extend(targets(&name, channel, vertices)?);
    }
    let mut seen = BTreeSet::new();
    match shapes.iter().find(|(name, _)| !seen.insert(name.as_str())) {
        Some((twice, _)) => Err(format!("two of its blend channels are called `{twice}`; rename one of them")),
        None => Ok(shapes),
    }
}

/// The shape of a channel, and its in-betweens.
fn targets(name: &str, channel: &ufbx::BlendChannel, vertices: usize) -> Result<Vec<(String, Offsets)>, String> {
    let mut targets: Vec<(f64, Offsets)> = Vec::new();
    for key in &channel.keyframes {
        targets.push((key.target_weight, offsets(name, &key.shape, vertices)?));
    }
    targets.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((full, mut main)) = targets.pop() else { return Ok(Vec::new()) };
    let outside = |weight: f64| {
        let percent = weight * 100.0;
        format!("blend channel `{name}` has a target at {percent} %, but targets must lie above 0 and up to 100 %")
    };
    if targets.is_empty() {
        // A lone target is met at its own weight, and the channel goes on in that line.
        if full.abs() < 1e-6 || !full.is_finite() {
            return Err(outside(full));
        }
        for offset in main.values_mut() {
            *offset /= full;
        }
        return Ok(vec![(name.to_owned(), main)]);
    }
    if (full - 1.0).abs() > 1e-6 {
        return Err(outside(full));
    }
    let mut shapes = Vec::with_capacity(targets.len() + 1);
    for (peak, target) in targets {
        if !(peak > 0.0 && peak < 1.0) {
            return Err(outside(peak));
        }
        let mut left = target;
        for (vertex, offset) in &main {
            *left.entry(*vertex).or_default() -= peak * *offset;
        }
        // What rounding leaves where a target lies on the straight path is no corrective.
        left.retain(|vertex, offset| {
            let size = main.get(vertex).map_or(0.0, |main| main.abs().max_element());
            offset.abs().max_element() > 1e-6 * size.max(1e-6)
        });
        shapes.push((format!("{name}@{}", peak as f32), left));
    }
    shapes.insert(0, (name.to_owned(), main));
    Ok(shapes)
}

fn offsets(channel: &str, shape: &ufbx::BlendShape, vertices: usize) -> Result<Offsets, String> {
    let mut offsets = Offsets::new();
    for (at, (vertex, offset)) in shape.offset_vertices.iter().zip(&shape.position_offsets).enumerate() {
        let wrong = |what: String| format!("blend channel `{channel}`, shape `{}`: {what}", shape.element.name);
        if *vertex as usize >= vertices {
            return Err(wrong(format!("it moves vertex {vertex}, but there are {vertices}")));
        }
        let offset = vector(*offset) * shape.offset_weights.get(at).copied().unwrap_or(1.0);
        if !offset.is_finite() {
            return Err(wrong(format!("it moves vertex {vertex} by {offset}, not a finite distance")));
        }
        if offset != DVec3::ZERO {
            *offsets.entry(*vertex).or_default() += offset;
        }
    }
    Ok(offsets)
}
