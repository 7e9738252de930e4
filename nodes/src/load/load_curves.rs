//! `load_curves`: animation curves from files: range of motion, edits that come back, truth to measure against.

use super::selection::{Mapping, Selection};
use face_io::curves;
use face_math::data::Curves;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const CURVES: Port<Curves> = Port::new("curves", "one weight per channel and frame, normally 0 to 1");

/// Loads animation curves from tables: plain ones, and recordings of Live Link Face.
///
/// A plain table has a column `frame` and then one a channel. In recordings of Live Link Face, `EyeBlinkLeft` becomes
/// `eyeBlink_L` and so on; `BrowInnerUp` and `CheekPuff` drive `_L` and `_R` both; frames that the recording lost are
/// interpolated. Rotations of head and eyes are left out, for they move no channel.
///
/// The parameters work in this order: `only`, `without`, `rename`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadCurves {
    /// The file, or a pattern such as `rom/*.csv`, which gives one item for each file that it fits.
    path: String,
    /// Frames a second, in place of what the file states. Plain tables that state nothing (a line `# rate_hz: 60`
    /// does) need it.
    #[schemars(range(min = 0.001, max = 100_000.0))]
    rate_hz: Option<f64>,
    /// Names of channels to keep, as patterns: `mouth*`, `{jaw,lip}*`. Keeps all where empty.
    only: Vec<String>,
    /// Names of channels to leave out, as patterns: `eyeLook*`.
    without: Vec<String>,
    /// New names by old ones: `{"CTRL_jaw": "jawOpen"}`, or by patterns: `{"CTRL_*": "*"}`. A name that is not in the file
    /// is an error.
    rename: BTreeMap<String, String>,
}

graph_core::register!(LoadCurves);

#[typetag::serde(name = "load_curves")]
impl Node for LoadCurves {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&CURVES)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let file = source.name.as_str();
        if super::extension(file) != "csv" {
            let problem = "curves are read from tables (.csv), plain or of Live Link Face; export the file as one";
            return Err(NodeError::file(file, problem));
        }
        let mut table = curves::open(&source.bytes).map_err(|error| NodeError::file(file, error))?;
        table.rate_hz = self.rate_hz.or(table.rate_hz);
        let curves = table.into_curves(None).map_err(|error| NodeError::file(file, error))?;
        let selection = Selection {
            what: "channel",
            only: &self.only,
            without: &self.without,
            rename: &self.rename,
            mapping: Mapping::default(),
        };
        let chosen = selection.apply(file, curves.channels())?;
        let (columns, names): (Vec<usize>, Vec<String>) = chosen.kept.into_iter().unzip();
        let values = (0..curves.frames()).flat_map(|frame| {
            let all = curves.frame(frame);
            columns.iter().map(|column| all[*column])
        });
        let curves = Curves::new(curves.frame_axis(), names, values.collect());
        Ok(Outputs::default().with(&CURVES, curves.map_err(|error| NodeError::file(file, error))?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, made, test_data};
    use serde_json::json;
    use wire::FrameAxis;

    fn load(parameters: serde_json::Value, name: &str, bytes: &[u8]) -> Result<Curves, String> {
        let node: LoadCurves = made(parameters);
        let outputs = Bench::default().with_source(name, bytes).compute(&node, &Inputs::default());
        outputs.map(|outputs| outputs.get(&CURVES).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_written_table_is_read_back() {
        let axis = FrameAxis { first: 1001, count: 2, rate_hz: 29.97 };
        let names = ["jawOpen", "mouthSmile_L"].map(str::to_owned).to_vec();
        let curves = Curves::new(axis, names, vec![0.25, 1.0, 0.1, -0.5]).unwrap();
        let bytes = curves::write(&curves, true).unwrap();
        assert_eq!(load(json!({}), "a.csv", &bytes).unwrap(), curves);
    }

    #[test]
    fn the_rate_comes_from_the_file_or_the_parameter() {
        let table = b"frame,jawOpen,brow\n0,0,1\n1,0.5,1\n";
        assert!(load(json!({}), "a.csv", table).unwrap_err().starts_with("a.csv: "));
        assert_eq!(load(json!({"rate_hz": 24.0}), "a.csv", table).unwrap().frame_axis(), FrameAxis::new(2, 24.0));
        let stated = b"# rate_hz: 60\nframe,jawOpen,brow\n0,0,1\n1,0.5,1\n";
        assert_eq!(load(json!({"rate_hz": 24.0}), "a.csv", stated).unwrap().frame_axis(), FrameAxis::new(2, 24.0));
    }

    #[test]
    fn channels_are_chosen_and_renamed() {
        let table = b"frame,jawOpen,brow\n0,0,1\n1,0.5,0.75\n";
        let with = json!({"rate_hz": 60.0, "only": ["brow"], "rename": {"brow": "browDown_L"}});
        let curves = load(with, "a.csv", table).unwrap();
        assert_eq!((curves.channels(), curves.values()), (&["browDown_L".to_owned()][..], &[1.0, 0.75][..]));
        let error = load(json!({"rate_hz": 60.0, "rename": {"jawopen": "a"}}), "a.csv", table).unwrap_err();
        assert!(error.contains("did you mean `jawOpen`?"), "{error}");
    }

    #[test]
    fn other_files_are_refused() {
        assert!(load(json!({}), "a.fbx", b"").unwrap_err().contains("curves are read from tables (.csv)"));
        assert!(load(json!({}), "a.csv", b"time,a\n0,1\n").unwrap_err().starts_with("a.csv: "));
    }

    #[test]
    fn a_real_recording_drives_the_channels_of_a_rig() {
        let Some(folder) = test_data("actors/ict_actor_a/rom") else { return };
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "csv") {
                continue;
            }
            let curves = load(json!({}), "rom.csv", &std::fs::read(&path).unwrap()).unwrap();
            assert!(curves.index("eyeBlink_L").is_some() && curves.index("browInnerUp_R").is_some());
            assert!(curves.frames() > 100 && curves.frame_axis().rate_hz > 20.0, "{}", path.display());
        }
    }
}
