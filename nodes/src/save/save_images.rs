//! `save_images`: pictures as files.

use face_io::png;
use face_math::data::Image;
use graph_core::cook::{Artifact, FILES};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const IMAGE: Port<Image> = Port::new("image", "an 8-bit sRGB picture");

/// Writes a picture as PNG.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SaveImages {
    /// The file to write, such as `out/{take}.png`.
    path: String,
}

graph_core::register!(SaveImages);

#[typetag::serde(name = "save_images")]
impl Node for SaveImages {
    fn card(&self) -> Card {
        Card::new("save").takes(&IMAGE).writes("path")
    }

    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let bytes = png::write(inputs.get(&IMAGE)?).map_err(|error| NodeError::input(IMAGE.name(), error))?;
        Ok(Outputs::default().with(&FILES, Artifact { bytes }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::compute;

    #[test]
    fn the_picture_is_read_back() {
        let image = Image::new(3, 2, (0..18).collect()).unwrap();
        let outputs = compute(&SaveImages::default(), &Inputs::default().with(&IMAGE, image.clone())).unwrap();
        assert_eq!(png::read(&outputs.get(&FILES).unwrap().bytes).unwrap(), image);
    }

    #[test]
    fn an_empty_picture_is_refused() {
        let inputs = Inputs::default().with(&IMAGE, Image::filled(0, 5, [0; 3]));
        let error = compute(&SaveImages::default(), &inputs).unwrap_err().to_string();
        assert!(error.starts_with("input `image`: PNG: width"), "{error}");
    }
}
