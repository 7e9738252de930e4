//! `save_animation`: a rig moved by curves as a file that any viewer plays.

use super::parts;
use face_io::{WriteError, gltf, usda};
use face_math::data::{Curves, Rig};
use graph_core::cook::{Artifact, FILES};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::json;

const RIG: Port<Rig> = Port::new("rig", "the head that is moved");
const CURVES: Port<Curves> =
    Port::new("curves", "a weight for each channel of the rig and each frame; other channels are left out");

/// In which format a head is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Format {
    /// GLB: one binary file that browsers, Blender and game engines play.
    Glb,
    /// USD as text, with `UsdSkel`: for Houdini, Maya, Omniverse and their like.
    Usda,
}

/// Writes a rig with its animation as GLB, or as USD (`UsdSkel`) where the path ends in `.usda`.
///
/// Every shape becomes a morph target (blend shape) with a weight track, correctives and in-betweens included, so that
/// the file plays the same everywhere; where the jaw has been split off (`skin_jaw`), it becomes a joint that turns. One
/// key a frame. In GLB, time begins at 0 s with the first frame, whose number stands in the file's `asset.extras`; in USD,
/// time codes are the numbers of the frames.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SaveAnimation {
    /// The file to write, such as `out/{take}.glb` or `out/{take}.usda`.
    path: String,
    /// The format, where the ending of the path is not to choose it.
    format: Option<Format>,
    /// Parts to leave out of the file, such as `tongue`.
    without_parts: Vec<String>,
}

graph_core::register!(SaveAnimation);

/// The path is no part of what a result depends on, but its ending chooses the format: that is written in its stead.
impl Serialize for SaveAnimation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("SaveAnimation", 3)?;
        fields.serialize_field("path", &self.path)?;
        fields.serialize_field("format", &self.chosen())?;
        fields.serialize_field("without_parts", &self.without_parts)?;
        fields.end()
    }
}

impl SaveAnimation {
    /// The format asked for, or else the one that the path's ending names.
    fn chosen(&self) -> Option<Format> {
        let ending = self.path.rsplit_once('.').map(|(_, ending)| ending.to_lowercase());
        self.format.or(match ending.as_deref() {
            Some("usda") => Some(Format::Usda),
            Some("glb") => Some(Format::Glb),
            _ => None,
        })
    }
}

#[typetag::serde(name = "save_animation")]
impl Node for SaveAnimation {
    fn card(&self) -> Card {
        Card::new("save").takes(&RIG).takes(&CURVES).writes("path")
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (rig, curves) = (inputs.get(&RIG)?, inputs.get(&CURVES)?);
        let axis = curves.frame_axis();
        if axis.count == 0 {
            return Err(NodeError::input(CURVES.name(), "there is no frame to write"));
        }
        context.go_on()?;
        let provenance = json!({ "first_frame": axis.first, "frames": axis.count, "rate_hz": axis.rate_hz });
        let write = match self.chosen() {
            Some(Format::Usda) => usda::write_animation,
            Some(Format::Glb) => gltf::write_animation,
            None if self.path.is_empty() => gltf::write_animation,
            None => {
                let problem = format!(
                    "`{}` ends neither in .glb nor in .usda; name the file so, or say which `format`",
                    self.path
                );
                return Err(NodeError::parameter("path", problem));
            }
        };
        let bytes = if self.without_parts.is_empty() {
            write(rig, curves, &provenance)
        } else {
            write(&parts::without(rig, "without_parts", &self.without_parts)?, curves, &provenance)
        };
        let bytes = bytes.map_err(|error| match error {
            WriteError::Data(_) | WriteError::NotFinite { .. } => NodeError::input(CURVES.name(), error),
            _ => NodeError::input(RIG.name(), error),
        })?;
        Ok(Outputs::default().with(&FILES, Artifact { bytes }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{HEAD, compute, made};
    use face_io::no_sibling;
    use face_math::rig::{SkinJawOptions, skin_jaw};

    fn saved(parameters: serde_json::Value, rig: &Rig, curves: &Curves) -> Result<Vec<u8>, String> {
        let node: SaveAnimation = made(parameters);
        let inputs = Inputs::default().with(&RIG, rig.clone()).with(&CURVES, curves.clone());
        let outputs = compute(&node, &inputs).map_err(|error| error.to_string())?;
        Ok(outputs.get(&FILES).unwrap().bytes.clone())
    }

    /// The JSON chunk of a GLB file.
    fn outline(bytes: &[u8]) -> serde_json::Value {
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        serde_json::from_slice(&bytes[20..20 + length]).unwrap()
    }

    fn tracks(file: &serde_json::Value) -> Vec<String> {
        let channels = file["animations"][0]["channels"].as_array().unwrap();
        channels.iter().map(|channel| channel["target"]["path"].as_str().unwrap().to_owned()).collect()
    }

    #[test]
    fn the_file_is_a_rig_with_weight_tracks_and_a_turning_jaw() {
        let bytes = saved(json!({}), &HEAD.rig, &HEAD.range_of_motion).unwrap();
        let file = outline(&bytes);
        assert_eq!(tracks(&file), ["weights"]);
        assert_eq!(file["asset"]["extras"]["frames"], 600);
        let back = gltf::read(&bytes, "back", &mut no_sibling).unwrap();
        assert_eq!(back.channels, HEAD.rig.channels);
        assert_eq!(back.parts.len(), HEAD.rig.parts.len());

        let jawed = skin_jaw(&HEAD.rig, &SkinJawOptions::default()).unwrap().rig;
        let file = outline(&saved(json!({}), &jawed, &HEAD.range_of_motion).unwrap());
        assert_eq!(tracks(&file), ["weights", "rotation", "translation"]);
    }

    #[test]
    fn the_ending_chooses_the_format() {
        let with =
            |path: &str| saved(json!({"path": path, "without_parts": ["tongue"]}), &HEAD.rig, &HEAD.range_of_motion);
        let text = String::from_utf8(with("out/Head.USDA").unwrap()).unwrap();
        assert!(text.starts_with("#usda 1.0\n") && text.contains("int64 \"frames\" = 600"));
        assert!(text.contains("def Mesh \"face\"") && !text.contains("def Mesh \"tongue\""));
        assert!(with("out/{take}.glb").unwrap().starts_with(b"glTF"));
        assert!(with("head.usdc").unwrap_err().contains("neither in .glb nor in .usda"));
        let key =
            |path: &str| serde_json::to_value(made::<SaveAnimation>(json!({"path": path}))).unwrap()["format"].clone();
        assert_eq!([key("a.usda"), key("a.glb"), key("")], [json!("usda"), json!("glb"), json!(null)]);
    }

    #[test]
    fn parts_may_be_left_out() {
        let bytes = saved(json!({"without_parts": ["tongue"]}), &HEAD.rig, &HEAD.range_of_motion).unwrap();
        let back = gltf::read(&bytes, "back", &mut no_sibling).unwrap();
        assert!(back.part("tongue").is_none() && back.parts.len() == HEAD.rig.parts.len() - 1);
        let error = saved(json!({"without_parts": ["tounge"]}), &HEAD.rig, &HEAD.range_of_motion).unwrap_err();
        assert!(error.contains("did you mean `tongue`?"), "{error}");
    }

    #[test]
    fn curves_that_lack_a_channel_are_refused() {
        let some = HEAD.range_of_motion.arrange(&["jawOpen".to_owned()], None).unwrap();
        let error = saved(json!({}), &HEAD.rig, &some).unwrap_err();
        assert!(error.starts_with("input `curves`: no channel `browDown_L`"), "{error}");
    }
}
