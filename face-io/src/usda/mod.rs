//! USD as text (`.usda`): a head moved by curves, as `UsdSkel` has it.
//!
//! Every shape of the rig becomes a `BlendShape` of each mesh that it moves, with a weight of its own in each frame:
//! what `UsdSkel` has no word for (combinations) and what programs read differently (in-betweens) is computed here, so that
//! the file plays the same everywhere. A jaw that is a joint of the rig becomes a joint of the file. `UsdSkel` moves
//! blend shapes first and skins then, which is the order of section 6 of the deepfake capture paper.

mod text;

use crate::WriteError;
use crate::motion::{Motion, jaw_shares};
use crate::surface::normals;
use face_math::data::{Curves, Part, Rig};
use glam::Vec3;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write;
use text::{dictionary, float, identifier, list, point, points, quoted};

const FORMAT: &str = "USD";

/// Joints of a file.
const JOINTS: [&str; 2] = ["skull", "skull/jaw"];

/// Writes a rig moved by curves as USD text, in metres, with Y up. `provenance` is kept in the layer's
/// `customLayerData`, under `grimace`.
///
/// Time codes are the numbers of the frames. Curves of other channels than the rig's are left out.
///
/// # Errors
/// Where a channel of the rig has no curve, a value is not finite, there is no frame, or a skin weight is not between 0
/// and 1.
pub fn write_animation(rig: &Rig, curves: &Curves, provenance: &Value) -> Result<Vec<u8>, WriteError> {
    let motion = Motion::of(rig, curves, FORMAT)?;
    let axis = curves.frame_axis();
    if axis.count == 0 {
        return Err(WriteError::Fit { format: FORMAT, what: "frames", expected: 1, found: 0 });
    }
    let shares = jaw_shares(rig, FORMAT)?;
    let last = axis.first + (axis.count - 1) as i64;
    let mut names = BTreeSet::new();
    let root = identifier(&rig.name, &mut names);
    let mut out = String::with_capacity(rig.neutral.len() * 120 + motion.shape_weights.len() * 8);
    let _ = write!(
        out,
        "#usda 1.0\n(\n    customLayerData = {{\n        dictionary grimace = {{\n            \
         string generator = \"grimace {}\"\n{}        }}\n    }}\n    defaultPrim = \"{root}\"\n    \
         endTimeCode = {last}\n    framesPerSecond = {rate}\n    metersPerUnit = 1\n    startTimeCode = {}\n    \
         timeCodesPerSecond = {rate}\n    upAxis = \"Y\"\n)\n\ndef SkelRoot \"{root}\" (\n    kind = \"component\"\n)\n{{\n",
        env!("CARGO_PKG_VERSION"),
        dictionary(provenance, 3),
        axis.first,
        rate = axis.rate_hz,
    );
    let mut inside = BTreeSet::from(["skeleton".to_owned()]);
    let skeleton = format!("/{root}/skeleton");
    for part in &rig.parts {
        let name = identifier(&part.name, &mut inside);
        mesh(&mut out, rig, part, &format!("/{root}/{name}"), &name, &skeleton, shares)?;
    }
    joints(&mut out, rig, &motion, axis.first, &skeleton, shares.is_some());
    out.push_str("}\n");
    Ok(out.into_bytes())
}

/// A part as a mesh, with the shapes that move it.
fn mesh(
    out: &mut String,
    rig: &Rig,
    part: &Part,
    path: &str,
    name: &str,
    skeleton: &str,
    shares: Option<&[f32]>,
) -> Result<(), WriteError> {
    let (first, end) = (part.vertices.start, part.vertices.end);
    let range = first as usize..end as usize;
    let positions = &rig.neutral[range.clone()];
    let own = |corner: &&u32| part.vertices.contains(corner);
    let corners: Vec<u32> = part.triangles.iter().flatten().filter(own).map(|corner| corner - first).collect();
    if corners.len() != part.triangles.len() * 3 {
        let what = "corners of a part that are its own vertices";
        return Err(WriteError::Fit { format: FORMAT, what, expected: part.triangles.len() * 3, found: corners.len() });
    }
    let (low, high) = positions.iter().fold((Vec3::MAX, Vec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
    let (low, high) = if positions.is_empty() { (Vec3::ZERO, Vec3::ZERO) } else { (low, high) };
    let colour = part.colour.map(|channel| if channel.is_nan() { 0.0 } else { channel.clamp(0.0, 1.0) });
    let _ = write!(
        out,
        "    def Mesh \"{name}\" (\n        prepend apiSchemas = [\"SkelBindingAPI\"]\n    )\n    {{\n        \
         uniform bool doubleSided = 1\n        float3[] extent = [{}, {}]\n        int[] faceVertexCounts = [{}]\n        \
         int[] faceVertexIndices = [{}]\n        normal3f[] normals = [{}] (\n            interpolation = \"vertex\"\n        )\n        \
         point3f[] points = [{}]\n        color3f[] primvars:displayColor = [{}]\n",
        point(low),
        point(high),
        list(part.triangles.iter(), |_| "3"),
        list(corners.iter(), u32::to_string),
        points(&normals(positions, &corners)),
        points(positions),
        point(Vec3::from_array(colour)),
    );
    if !part.uvs.is_empty() {
        // Here the origin of texture coordinates is at the top left, in USD at the bottom left.
        let uvs = list(part.uvs.iter(), |[u, v]| format!("({}, {})", float(*u), float(1.0 - *v)));
        let _ = write!(
            out,
            "        texCoord2f[] primvars:st = [{uvs}] (\n            interpolation = \"vertex\"\n        )\n"
        );
    }
    influences(out, shares.map(|shares| &shares[range]), positions.len());
    let _ =
        write!(out, "        rel skel:skeleton = <{skeleton}>\n        uniform token subdivisionScheme = \"none\"\n");
    shapes(out, rig, part, path);
    out.push_str("    }\n\n");
    Ok(())
}

/// Which joints each vertex follows: the skull alone, or the skull and the jaw.
fn influences(out: &mut String, shares: Option<&[f32]>, count: usize) {
    let (indices, weights, each) = match shares {
        None => {
            let ones = |text: &'static str| list(0..count, move |_| text);
            (ones("0"), ones("1"), 1)
        }
        Some(shares) => (
            list(0..count, |_| "0, 1"),
            list(shares.iter(), |share| format!("{}, {}", float(1.0 - share), float(*share))),
            2,
        ),
    };
    let about = format!("(\n            elementSize = {each}\n            interpolation = \"vertex\"\n        )");
    let _ = write!(
        out,
        "        matrix4d primvars:skel:geomBindTransform = {}\n        \
         int[] primvars:skel:jointIndices = [{indices}] {about}\n        \
         float[] primvars:skel:jointWeights = [{weights}] {about}\n",
        text::standing_at(Vec3::ZERO),
    );
}

/// The shapes that move a part.
fn shapes(out: &mut String, rig: &Rig, part: &Part, path: &str) {
    let mut names = BTreeSet::new();
    let (mut tokens, mut targets, mut prims) = (Vec::new(), Vec::new(), String::new());
    for shape in &rig.shapes {
        let from = shape.vertices.partition_point(|vertex| *vertex < part.vertices.start);
        let to = shape.vertices.partition_point(|vertex| *vertex < part.vertices.end);
        if from == to {
            continue;
        }
        let name = identifier(&shape.name, &mut names);
        let moved = &shape.vertices[from..to];
        let _ = write!(
            prims,
            "\n        def BlendShape \"{name}\"\n        {{\n            uniform vector3f[] offsets = [{}]\n            \
             uniform int[] pointIndices = [{}]\n        }}\n",
            points(&shape.deltas[from..to]),
            list(moved.iter(), |vertex| format!("{}", vertex - part.vertices.start)),
        );
        tokens.push(quoted(&shape.name));
        targets.push(format!("<{path}/{name}>"));
    }
    if tokens.is_empty() {
        return;
    }
    let _ = write!(
        out,
        "        uniform token[] skel:blendShapes = [{}]\n        rel skel:blendShapeTargets = [\n            {},\n        ]\n{prims}",
        tokens.join(", "),
        targets.join(",\n            "),
    );
}

/// The joints, and what moves them and the shapes.
fn joints(out: &mut String, rig: &Rig, motion: &Motion, first: i64, skeleton: &str, has_jaw: bool) {
    let joints = &JOINTS[..if has_jaw { 2 } else { 1 }];
    let pivot = rig.jaw_pivot_m.unwrap_or_default();
    let stands = [Vec3::ZERO, pivot];
    let names = list(joints.iter(), |joint| quoted(joint));
    let transforms = list(stands[..joints.len()].iter(), |at| text::standing_at(*at));
    let _ = write!(
        out,
        "    def Skeleton \"skeleton\" (\n        prepend apiSchemas = [\"SkelBindingAPI\"]\n    )\n    {{\n        \
         uniform matrix4d[] bindTransforms = [{transforms}]\n        uniform token[] joints = [{names}]\n        \
         uniform matrix4d[] restTransforms = [{transforms}]\n        rel skel:animationSource = <{skeleton}/performance>\n\n        \
         def SkelAnimation \"performance\"\n        {{\n"
    );
    if !rig.shapes.is_empty() {
        let shapes = list(rig.shapes.iter(), |shape| quoted(&shape.name));
        let _ = writeln!(out, "            uniform token[] blendShapes = [{shapes}]");
        let frames = motion.shape_weights.chunks_exact(rig.shapes.len());
        samples(out, "float[] blendShapeWeights", first, frames, |weights| {
            list(weights.iter(), |weight| float(*weight))
        });
    }
    let _ = writeln!(out, "            uniform token[] joints = [{names}]");
    if motion.jaw.is_empty() {
        let still = list(joints.iter(), |_| "(1, 0, 0, 0)");
        let _ = writeln!(out, "            quatf[] rotations = [{still}]");
        let _ = writeln!(out, "            float3[] translations = [{}]", points(&stands[..joints.len()]));
    } else {
        samples(out, "quatf[] rotations", first, motion.jaw.iter(), |key| {
            let [x, y, z, w] = key.rotation.to_array().map(float);
            format!("(1, 0, 0, 0), ({w}, {x}, {y}, {z})")
        });
        samples(out, "float3[] translations", first, motion.jaw.iter(), |key| {
            points(&[Vec3::ZERO, key.joint_translation_m(pivot)])
        });
    }
    let scales = list(joints.iter(), |_| "(1, 1, 1)");
    let _ = writeln!(out, "            half3[] scales = [{scales}]\n        }}\n    }}");
}

/// An attribute over time, a value a frame.
fn samples<T>(out: &mut String, name: &str, first: i64, values: impl Iterator<Item = T>, text: impl Fn(T) -> String) {
    let _ = writeln!(out, "            {name}.timeSamples = {{");
    for (frame, value) in (first..).zip(values) {
        let _ = writeln!(out, "                {frame}: [{}],", text(value));
    }
    out.push_str("            }\n");
}
