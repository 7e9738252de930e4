//! `save_markers`: markers as files that other programs read.

use crate::unit::Unit;
use face_io::markers::trc;
use face_io::{c3d, marker_csv};
use face_math::data::Markers;
use graph_core::cook::{Artifact, FILES};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "named points over frames, in metres");

/// In which format markers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Format {
    /// As the ending of `path` says: `.c3d`, `.trc` or `.csv`.
    #[default]
    ByEnding,
    /// C3D, as `c3d_processor` and `c3d_storage` say; missing points have residual −1.
    C3d,
    /// TRC, a table parted by tabs; missing points are empty.
    Trc,
    /// A table: a column `frame`, then three a marker (`chin_x_mm`, `chin_y_mm`, `chin_z_mm`); missing points are empty.
    Csv,
    /// A table of one frame, a face at rest: the columns `marker`, `x_mm`, `y_mm`, `z_mm`.
    NeutralCsv,
}

impl Format {
    /// The format that the ending of a path stands for.
    fn of(path: &str) -> Option<Self> {
        match path.rsplit_once('.')?.1.to_lowercase().as_str() {
            "c3d" => Some(Self::C3d),
            "trc" => Some(Self::Trc),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }
}

/// Whose number formats a C3D file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Processor {
    /// Those of PCs, which every reader understands.
    #[default]
    Intel,
    /// Those of DEC machines (VAX).
    Dec,
    /// Those of SGI and other MIPS machines.
    Mips,
}

impl From<Processor> for c3d::Processor {
    fn from(processor: Processor) -> Self {
        match processor {
            Processor::Intel => Self::Intel,
            Processor::Dec => Self::Dec,
            Processor::Mips => Self::Mips,
        }
    }
}

/// How a C3D file stores coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Storage {
    /// As 32-bit floats: every bit is kept.
    #[default]
    Real,
    /// As 16-bit integers: half the size, in steps of the farthest coordinate / 32,767 (5 µm where that is 0.15 m).
    Integer,
}

/// Writes markers as C3D, TRC or as a table (CSV).
///
/// `load_markers` reads all of them back.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SaveMarkers {
    /// The file to write, such as `out/{take}.c3d`. Its ending chooses the format.
    path: String,
    /// The format, where the ending does not say it.
    format: Format,
    /// Unit of the coordinates in the file.
    unit: Unit,
    /// Whose number formats a C3D file has, for programs that ask for one.
    c3d_processor: Processor,
    /// How a C3D file stores coordinates.
    c3d_storage: Storage,
}

impl Default for SaveMarkers {
    fn default() -> Self {
        let (c3d_processor, c3d_storage) = (Processor::default(), Storage::default());
        Self { path: String::new(), format: Format::ByEnding, unit: Unit::Millimetres, c3d_processor, c3d_storage }
    }
}

// Paths are no part of a node's key, formats are. The format that a path's ending chooses is therefore put into
// `format` as soon as the node is read, so that another ending is another key.
impl<'de> Deserialize<'de> for SaveMarkers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(default, deny_unknown_fields)]
        struct Stated {
            path: String,
            format: Format,
            unit: Unit,
            c3d_processor: Processor,
            c3d_storage: Storage,
        }
        impl Default for Stated {
            fn default() -> Self {
                let SaveMarkers { path, format, unit, c3d_processor, c3d_storage } = SaveMarkers::default();
                Self { path, format, unit, c3d_processor, c3d_storage }
            }
        }
        let Stated { path, format, unit, c3d_processor, c3d_storage } = Stated::deserialize(deserializer)?;
        let format = match format {
            Format::ByEnding => Format::of(&path).unwrap_or_default(),
            format => format,
        };
        Ok(Self { path, format, unit, c3d_processor, c3d_storage })
    }
}

impl SaveMarkers {
    fn flavour(&self) -> c3d::Flavour {
        c3d::Flavour { processor: self.c3d_processor.into(), integers: self.c3d_storage == Storage::Integer }
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
            Format::ByEnding => {
                let problem = format!(
                    "the ending of `{}` is that of no format of markers; end it in .c3d, .trc or .csv, or set `format`",
                    self.path
                );
                return Err(NodeError::parameter("path", problem));
            }
            Format::Trc => trc::write(markers, unit),
            Format::C3d => c3d::write(markers, unit, self.flavour()),
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
    use face_io::markers;
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
            for ending in ["c3d", "TRC", "csv"] {
                let bytes = saved(json!({"unit": unit, "path": format!("out/a.b.{ending}")}), &take(3)).unwrap();
                let again = markers::read("file", &bytes, None).unwrap();
                assert_eq!((again.names(), again.frame_axis()), (take(3).names(), take(3).frame_axis()));
                for (a, b) in again.positions().iter().zip(take(3).positions()) {
                    assert!((*a - *b).abs().max_element() < 1e-6);
                }
            }
            let bytes = saved(json!({"unit": unit, "format": "neutral_csv", "path": "a.csv"}), &take(1)).unwrap();
            assert!(marker_csv::open(&bytes).unwrap().is_neutral());
        }
        let table = saved(json!({"format": "csv", "path": "a.c3d"}), &take(1)).unwrap();
        assert!(String::from_utf8(table).unwrap().starts_with("# rate_hz"));
    }

    #[test]
    fn all_flavours_of_c3d_read_back() {
        for processor in ["intel", "dec", "mips"] {
            for (storage, off_m) in [("real", 0.0), ("integer", 2e-6)] {
                let flavour = json!({"path": "a.c3d", "c3d_processor": processor, "c3d_storage": storage});
                let again = c3d::read_take(&saved(flavour, &take(3)).unwrap()).unwrap();
                assert_eq!(again.storage.name(), storage);
                for (a, b) in again.markers.positions().iter().zip(take(3).positions()) {
                    assert!((*a - *b).abs().max_element() <= off_m, "{processor}, {storage}: {a} beside {b}");
                }
            }
        }
    }

    #[test]
    fn an_ending_that_says_nothing_asks_for_the_format() {
        for path in ["out/take", "out/take.txt", "out.c3d/take"] {
            let error = saved(json!({"path": path}), &take(2)).unwrap_err();
            assert!(error.starts_with("parameter `path`: ") && error.contains(".trc"), "{error}");
        }
    }

    #[test]
    fn another_ending_is_another_key() {
        let format = |path: &str| {
            let node: SaveMarkers = made(json!({"path": path}));
            serde_json::to_value(&node).unwrap()["format"].clone()
        };
        assert_eq!((format("a.c3d"), format("{take}.trc")), (json!("c3d"), json!("trc")));
    }

    #[test]
    fn a_take_is_no_face_at_rest() {
        let error = saved(json!({"format": "neutral_csv"}), &take(2)).unwrap_err();
        assert!(error.starts_with("input `markers`: ") && error.contains("frames"), "{error}");
    }
}
