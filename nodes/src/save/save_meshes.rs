//! `save_meshes`: animated meshes as files for other programs.

use face_io::{gltf, obj};
use face_math::data::{Curves, Driver, Meshes, Rig, Shape};
use graph_core::cook::{Artifact, FILES};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

const MESHES: Port<Meshes> = Port::new("meshes", "the meshes to write, in metres");

/// Most frames of a GLB file: each is a shape, and a key holds a weight for every shape.
const MOST_FRAMES: usize = 1024;

/// Writes meshes: a whole sequence as GLB, one shape a frame, that any viewer plays; or one frame as OBJ.
///
/// For a sequence of OBJ files, a graph uses this once a frame (`frame`), with the number in `path`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SaveMeshes {
    /// The file to write: `out/{take}.glb` or `out/{take}.obj`.
    path: String,
    /// For OBJ: the frame, numbered as the meshes number it. The first where not given.
    frame: Option<i64>,
}

graph_core::register!(SaveMeshes);

#[typetag::serde(name = "save_meshes")]
impl Node for SaveMeshes {
    fn card(&self) -> Card {
        Card::new("save").takes(&MESHES).writes("path")
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let meshes = inputs.get(&MESHES)?;
        if meshes.frames() == 0 {
            return Err(NodeError::input(MESHES.name(), "there is no frame to write"));
        }
        let ending = self.path.rsplit_once('.').map(|(_, ending)| ending.to_lowercase());
        let bytes = match ending.as_deref() {
            Some("obj") => self.frame_as_obj(meshes)?,
            Some("glb") => sequence_as_glb(meshes)?,
            _ if self.path.is_empty() => sequence_as_glb(meshes)?,
            _ => {
                let problem = format!("`{}` ends neither in .glb nor in .obj", self.path);
                return Err(NodeError::parameter("path", problem));
            }
        };
        Ok(Outputs::default().with(&FILES, Artifact { bytes }))
    }
}

impl SaveMeshes {
    fn frame_as_obj(&self, meshes: &Meshes) -> Result<Vec<u8>, NodeError> {
        let axis = meshes.frame_axis();
        let frame = self.frame.unwrap_or(axis.first);
        let last = axis.slice(&(axis.count - 1..axis.count)).first;
        if !(axis.first..=last).contains(&frame) {
            let problem = format!("there is no frame {frame}; the meshes hold frames {} to {last}", axis.first);
            return Err(NodeError::parameter("frame", problem));
        }
        Ok(obj::write(meshes.parts(), meshes.frame((frame - axis.first) as usize)))
    }
}

fn sequence_as_glb(meshes: &Meshes) -> Result<Vec<u8>, NodeError> {
    let frames = meshes.frames();
    if frames > MOST_FRAMES {
        let problem = format!(
            "{frames} frames are more than the {MOST_FRAMES} that a GLB sequence holds; write every so many-th"
        );
        return Err(NodeError::input(MESHES.name(), problem));
    }
    let rest = meshes.frame(0);
    let names: Vec<String> = (0..frames).map(|frame| format!("frame_{frame:04}")).collect();
    let shape = |(frame, name): (usize, &String)| {
        let moved = (0..).zip(meshes.frame(frame).iter().zip(rest)).filter(|(_, (own, rest))| own != rest);
        let (vertices, deltas) = moved.map(|(vertex, (own, rest))| (vertex, *own - *rest)).unzip();
        Shape { name: name.clone(), driver: Driver::Channel(frame as u32), vertices, deltas }
    };
    let rig = Rig {
        name: "meshes".to_owned(),
        parts: meshes.parts().to_vec(),
        neutral: rest.to_vec(),
        channels: names.clone(),
        shapes: names.iter().enumerate().map(shape).collect(),
        skin: Vec::new(),
        jaw_pivot_m: None,
        jaw: None,
        joints: Vec::new(),
    };
    let weights = (0..frames * frames).map(|at| f32::from(u8::from(at / frames == at % frames))).collect();
    let axis = meshes.frame_axis();
    let curves = Curves::new(axis, names, weights).map_err(NodeError::failed)?;
    let notes = json!({ "first_frame": axis.first, "frames": axis.count, "rate_hz": axis.rate_hz });
    gltf::write_animation(&rig, &curves, &notes).map_err(|error| NodeError::input(MESHES.name(), error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use face_io::no_sibling;
    use face_math::data::Part;
    use glam::Vec3;
    use wire::FrameAxis;

    fn meshes(frames: usize) -> Meshes {
        let part = Part {
            name: "face".into(),
            vertices: 0..4,
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: Vec::new(),
            colour: [0.5; 3],
        };
        let at = |place: usize| {
            Vec3::new((place % 4) as f32 * 0.1, ((place * 7) % 5) as f32 * 0.02, 0.01 * (place / 4) as f32)
        };
        Meshes::new(
            FrameAxis { first: 11, count: frames, rate_hz: 30.0 },
            vec![part],
            4,
            (0..4 * frames).map(at).collect(),
        )
        .unwrap()
    }

    fn saved(parameters: serde_json::Value, meshes: Meshes) -> Result<Vec<u8>, String> {
        let node: SaveMeshes = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&MESHES, meshes)).map_err(|error| error.to_string())?;
        Ok(outputs.get(&FILES).unwrap().bytes.clone())
    }

    #[test]
    fn a_sequence_is_read_back_frame_by_frame() {
        let known = meshes(4);
        let bytes = saved(json!({"path": "a.glb"}), known.clone()).unwrap();
        let rig = gltf::read(&bytes, "a", &mut no_sibling).unwrap();
        let curves = gltf::read_animation(&bytes, None, None, &mut no_sibling).unwrap().curves;
        assert_eq!(curves.frames(), 4);
        for frame in 0..4 {
            let own = face_math::rig::Puppet::new(&rig)
                .unwrap()
                .vertices(curves.arrange(&rig.channels, None).unwrap().frame(frame))
                .unwrap();
            assert!(own.iter().zip(known.frame(frame)).all(|(a, b)| a.abs_diff_eq(*b, 1e-7)));
        }
        assert!(saved(json!({"path": "a.glb"}), meshes(1025)).unwrap_err().contains("1025 frames are more"));
    }

    #[test]
    fn a_frame_is_read_back_from_obj() {
        let known = meshes(3);
        let text = saved(json!({"path": "a.obj", "frame": 13}), known.clone()).unwrap();
        let head = obj::open(&text).unwrap().head("a", face_io::LengthUnit::Metre).unwrap();
        assert!(head.neutral.iter().zip(known.frame(2)).all(|(a, b)| a.abs_diff_eq(*b, 1e-7)));
        assert_eq!(head.parts[0].name, "face");
        assert!(saved(json!({"path": "a.obj", "frame": 14}), known.clone()).unwrap_err().contains("frames 11 to 13"));
        assert!(saved(json!({"path": "a.abc"}), known).unwrap_err().contains("`path`"));
    }
}
