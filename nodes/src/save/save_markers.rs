//! `save_markers`: markers as files that other programs read.

use crate::unit::Unit;
use face_io::{c3d, marker_csv};
use face_math::data::Markers;
use graph_core::cook::{Artifact, FILES};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "named points over frames, in metres");

/// In which format markers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Format {
    /// C3D with PC numbers in real format; missing points have residual −1.
    #[default]
    C3d,
    /// A table: a column `frame`, then three a marker (`chin_x_mm`, `chin_y_mm`, `chin_z_mm`); missing points are empty.
    Csv,
    /// A table of one frame, a face at rest: the columns `marker`, `x_mm`, `y_mm`, `z_mm`.
    NeutralCsv,
}

/// Writes markers as C3D or as a table (CSV).
///
/// `load_markers` reads all of them back.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SaveMarkers {
    /// The file to write, such as `out/{take}.c3d`. Its ending does not choose the format: `format` does.
    path: String,
    /// The format.
    format: Format,
    /// Unit of the coordinates in the file.
    unit: Unit,
}

impl Default for SaveMarkers {
    fn default() -> Self {
        Self { path: String::new(), format: Format::C3d, unit: Unit::Millimetres }
    }
}

graph_core::register!(SaveMarkers);

#[typetag::serde(name = "save_markers")]
impl Node for SaveMarkers {
    fn card(&self) -> Card {
        Card::new("save").takes(&MARKERS).writes("path")
    }

    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (markers, unit) = (inputs.get(&MARKERS)?, self.unit.into());
        let bytes = match self.format {
            Format::C3d => c3d::write(markers, unit),
            Format::Csv => marker_csv::write(markers, unit),
            Format::NeutralCsv => marker_csv::write_neutral(markers, unit),
        };
        let bytes = bytes.map_err(|error| NodeError::input(MARKERS.name(), error))?;
        Ok(Outputs::default().with(&FILES, Artifact { bytes }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use glam::Vec3;
    use serde_json::json;
    use wire::FrameAxis;

    fn saved(parameters: serde_json::Value, markers: &Markers) -> Result<Vec<u8>, String> {
        let node: SaveMarkers = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&MARKERS, markers.clone()));
        outputs.map(|outputs| outputs.get(&FILES).unwrap().bytes.clone()).map_err(|error| error.to_string())
    }

    fn take(frames: usize) -> Markers {
        let axis = FrameAxis { first: 1, count: frames, rate_hz: 120.0 };
        let positions = (0..2 * frames).map(|i| Vec3::new(i as f32 * 0.01, 0.1, -0.02)).collect();
        Markers::new(axis, vec!["chin".into(), "brow".into()], positions).unwrap()
    }

    #[test]
    fn all_formats_and_units_read_back() {
        for unit in ["mm", "m", "in"] {
            let bytes = saved(json!({"unit": unit}), &take(3)).unwrap();
            assert!((c3d::read(&bytes).unwrap().frame(2)[1].x - 0.05).abs() < 1e-6);
            let bytes = saved(json!({"unit": unit, "format": "csv"}), &take(3)).unwrap();
            assert_eq!(marker_csv::read(&bytes, None).unwrap().frame_axis(), take(3).frame_axis());
            let bytes = saved(json!({"unit": unit, "format": "neutral_csv"}), &take(1)).unwrap();
            assert!(marker_csv::open(&bytes).unwrap().neutral);
        }
    }

    #[test]
    fn a_take_is_no_face_at_rest() {
        let error = saved(json!({"format": "neutral_csv"}), &take(2)).unwrap_err();
        assert!(error.starts_with("input `markers`: ") && error.contains("frames"), "{error}");
    }
}
