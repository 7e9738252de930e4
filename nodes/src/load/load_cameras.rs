//! `load_cameras`: calibrated cameras from a file; where triangulation begins.

use face_io::camera_json;
use face_math::data::Cameras;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CAMERAS: Port<Cameras> =
    Port::new("cameras", "calibrated cameras: place, direction, focal length in pixels, lens distortion");

/// Loads calibrated cameras from JSON, in the conventions of `OpenCV`.
///
/// The file has a list `cameras`; each camera has `name`, `width` and `height` in pixels, `K` (3 x 3), `R` (3 x 3) and
/// `t_mm`, `t_cm` or `t_m`, so that `x_cam = R x_world + t` with z forward and y down, and the distortion of its lens as
/// `dist_k1k2p1p2`, `dist_k1k2p1p2k3` or `dist`. `OpenCV`'s own names and matrix objects are understood too. Where the
/// calibration has another world than the markers, transform it first: the world here is Y up, in the frame of the face.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadCameras {
    /// The file, or a pattern of files, which gives one item for each file that it fits.
    path: String,
}

graph_core::register!(LoadCameras);

#[typetag::serde(name = "load_cameras")]
impl Node for LoadCameras {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&CAMERAS)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let cameras = camera_json::read(&source.bytes).map_err(|error| NodeError::file(&source.name, error))?;
        Ok(Outputs::default().with(&CAMERAS, cameras))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, test_data};

    fn load(bytes: &[u8]) -> Result<Cameras, String> {
        let bench = Bench::default().with_source("cameras.json", bytes);
        let outputs = bench.compute(&LoadCameras::default(), &Inputs::default());
        outputs.map(|outputs| outputs.get(&CAMERAS).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_real_calibration_is_read() {
        let Some(path) = test_data("actors/ict_actor_a/cameras.json") else { return };
        let cameras = load(&std::fs::read(path).unwrap()).unwrap();
        assert_eq!(cameras.names(), ["cam0", "cam1", "cam2", "cam3", "cam4"]);
        // The cameras stand some 70 cm before the face.
        assert!(cameras.cameras().iter().all(|camera| (0.6..0.8).contains(&camera.eye_m().length())));
    }

    #[test]
    fn mistakes_name_the_file() {
        assert!(load(b"{\"cameras\": []}").unwrap_err().starts_with("cameras.json: cameras: "));
    }
}
