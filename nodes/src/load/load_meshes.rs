//! `load_meshes`: animated meshes from files: scans and simulations that no rig made.

use crate::unit::Unit;
use face_io::{gltf, obj};
use face_math::data::{Meshes, Rig};
use face_math::rig::Puppet;
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wire::FrameAxis;

const MESHES: Port<Meshes> =
    Port::new("meshes", "the mesh of every frame, in metres: one frame of an OBJ file, all of an animated GLB");

/// Loads meshes: the frames of an animated GLB or glTF file, or the one frame that an OBJ file is.
///
/// A sequence of OBJ files is loaded by a pattern (`scan/frame.*.obj`), which gives one item a file; `join_meshes` lays them one
/// after the other, in the order of the numbers in their names. All files must be of one topology.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadMeshes {
    /// The file: `.obj`, `.glb` or `.gltf`, or a pattern that gives one item for each file that it fits.
    path: String,
    /// For OBJ, which states none: the unit of the positions.
    unit: Option<Unit>,
    /// Frames a second: of OBJ files, and in place of what animated files say.
    #[schemars(range(min = 0.001, max = 100_000.0))]
    rate_hz: Option<f64>,
    /// Takes every so many-th frame of an animated file: 1 takes all.
    #[schemars(range(min = 1, max = 10_000))]
    frame_step: usize,
}

impl Default for LoadMeshes {
    fn default() -> Self {
        Self { path: String::new(), unit: None, rate_hz: None, frame_step: 1 }
    }
}

graph_core::register!(LoadMeshes);

#[typetag::serde(name = "load_meshes")]
impl Node for LoadMeshes {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&MESHES)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let wrong = |error: &dyn std::fmt::Display| NodeError::file(&source.name, error);
        let meshes = match super::extension(&source.name).as_str() {
            "obj" => {
                let Some(unit) = self.unit else {
                    let problem =
                        format!("{} states no unit, as no OBJ file does; say which (m, cm, mm …)", source.name);
                    return Err(NodeError::parameter("unit", problem));
                };
                let head = obj::open(&source.bytes)
                    .and_then(|file| file.head("mesh", unit.into()))
                    .map_err(|error| wrong(&error))?;
                let axis = FrameAxis::new(1, self.rate_hz.unwrap_or(24.0));
                Meshes::new(axis, head.parts, head.neutral.len(), head.neutral).map_err(|error| wrong(&error))?
            }
            "glb" | "gltf" => {
                let beside = &mut super::beside(context);
                let rig = gltf::read(&source.bytes, "mesh", beside).map_err(|error| wrong(&error))?;
                let animation =
                    gltf::read_animation(&source.bytes, None, self.rate_hz, beside).map_err(|error| wrong(&error))?;
                if !animation.moving_nodes.is_empty() {
                    let problem = format!(
                        "it moves {} besides its weights; bake that to shapes and export again",
                        animation.moving_nodes.join(", ")
                    );
                    return Err(wrong(&problem));
                }
                self.animated(context, &rig, &animation.curves).map_err(|error| wrong(&error))?
            }
            _ => return Err(wrong(&"meshes are read from OBJ (.obj) and animated GLB and glTF (.glb, .gltf) files")),
        };
        Ok(Outputs::default().with(&MESHES, meshes))
    }
}

impl LoadMeshes {
    fn animated(
        &self,
        context: &Context<'_>,
        rig: &Rig,
        curves: &face_math::data::Curves,
    ) -> Result<Meshes, NodeError> {
        let puppet = Puppet::new(rig).map_err(NodeError::failed)?;
        let curves = curves.arrange(&rig.channels, None).map_err(NodeError::failed)?;
        let frames: Vec<usize> = (0..curves.frames()).step_by(self.frame_step).collect();
        context.claim("frame_step", frames.len() * rig.neutral.len() * 12)?;
        let mut positions: Vec<Vec3> = Vec::with_capacity(frames.len() * rig.neutral.len());
        for frame in &frames {
            context.go_on()?;
            positions.extend(puppet.vertices(curves.frame(*frame)).map_err(NodeError::failed)?);
        }
        let axis = FrameAxis {
            count: frames.len(),
            rate_hz: curves.frame_axis().rate_hz / self.frame_step as f64,
            ..curves.frame_axis()
        };
        Meshes::new(axis, rig.parts.clone(), rig.neutral.len(), positions).map_err(NodeError::failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, HEAD, made};
    use face_math::data::Curves;
    use serde_json::json;

    fn load(parameters: serde_json::Value, name: &str, bytes: &[u8]) -> Result<Meshes, String> {
        let node: LoadMeshes = made(parameters);
        let outputs = Bench::default().with_source(name, bytes).compute(&node, &Inputs::default());
        outputs.map(|outputs| outputs.get(&MESHES).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn an_obj_file_is_a_frame() {
        let text = b"v 0 0 0\nv 10 0 0\nv 0 20 0\nf 1 2 3\n";
        let meshes = load(json!({"unit": "cm"}), "a.obj", text).unwrap();
        assert_eq!((meshes.frames(), meshes.frame(0)[2]), (1, Vec3::new(0.0, 0.2, 0.0)));
        assert!(load(json!({}), "a.obj", text).unwrap_err().contains("`unit`"));
        assert!(load(json!({}), "a.abc", text).unwrap_err().contains("are read from OBJ"));
    }

    #[test]
    fn an_animated_file_is_all_its_frames() {
        let all = &HEAD.range_of_motion;
        let axis = FrameAxis { count: 5, ..all.frame_axis() };
        let curves =
            Curves::new(axis, all.channels().to_vec(), all.values()[..5 * all.channels().len()].to_vec()).unwrap();
        let notes = json!({"first_frame": axis.first, "frames": 5, "rate_hz": axis.rate_hz});
        let file = gltf::write_animation(&HEAD.rig, &curves, &notes).unwrap();
        let meshes = load(json!({"frame_step": 2}), "a.glb", &file).unwrap();
        assert_eq!(meshes.frames(), 3);
        let known = Puppet::new(&HEAD.rig)
            .unwrap()
            .vertices(curves.arrange(&HEAD.rig.channels, None).unwrap().frame(4))
            .unwrap();
        assert!(meshes.frame(2).iter().zip(&known).all(|(a, b)| a.abs_diff_eq(*b, 1e-6)));
    }
}
