//! `load_curves`: animation curves from files: range of motion, edits that come back, truth to measure against.

use crate::selection::{Mapping, Selection};
use face_io::curves::{self, Timing};
use face_io::gltf;
use face_math::data::Curves;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port, SourceFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const CURVES: Port<Curves> = Port::new("curves", "one weight per channel and frame, normally 0 to 1");

/// Loads animation curves from tables, plain ones and recordings of Live Link Face, and from animated GLB and glTF files.
///
/// A plain table has a column `frame` and then one a channel. In recordings of Live Link Face, `EyeBlinkLeft` becomes
/// `eyeBlink_L` and so on; `BrowInnerUp` and `CheekPuff` drive `_L` and `_R` both; frames that the recording lost are
/// interpolated, up to `longest_gap_s`. Rotations of head and eyes are left out, for they move no channel. Timecodes may
/// be drop-frame (`18:45:19;28`), which is 29.97 or 59.94 Hz.
///
/// Of an animated file, the weights of morph targets are read, at each frame between its first key and its last.
/// Weights of combinations (`a+b`) and in-betweens (`a@0.5`) are left out, since rigs compute them.
///
/// The last parameters work in this order: `only`, `without`, `rename`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadCurves {
    /// The file (`.csv`, `.glb`, `.gltf`), or a pattern such as `rom/*.csv`, which gives one item for each file that it
    /// fits.
    path: String,
    /// Frames a second, in place of what the file states. Plain tables that state nothing (a line `# rate_hz: 60`
    /// does) need it. Animated files are sampled at this rate; without it, at the one that their keys show.
    #[schemars(range(min = 0.001, max = 100_000.0))]
    rate_hz: Option<f64>,
    /// Lays the frames of a recording exactly where its timecodes say that time passes, at `rate_hz` or else at the rate
    /// of the timecode. Otherwise rows that come at a steady pace are the frames, though devices run a little slow.
    by_timecode: bool,
    /// The longest gap in a recording that is interpolated, in seconds; one with a longer gap is refused.
    #[schemars(range(min = 0.0, max = 3600.0))]
    longest_gap_s: f64,
    /// Name of the animation, where an animated file has several.
    animation: Option<String>,
    /// Reads the weights of an animated file though it moves joints as well, and leaves the joints' motion out. Files
    /// of `save_animation` need it not: their jaw follows the channels.
    without_joints: bool,
    /// Names of channels to keep, as patterns: `mouth*`, `{jaw,lip}*`. Keeps all where empty.
    only: Vec<String>,
    /// Names of channels to leave out, as patterns: `eyeLook*`.
    without: Vec<String>,
    /// New names by old ones: `{"CTRL_jaw": "jawOpen"}`, or by patterns: `{"CTRL_*": "*"}`. A name that is not in the file
    /// is an error.
    rename: BTreeMap<String, String>,
}

impl Default for LoadCurves {
    fn default() -> Self {
        Self {
            path: String::new(),
            rate_hz: None,
            by_timecode: false,
            longest_gap_s: 0.5,
            animation: None,
            without_joints: false,
            only: Vec::new(),
            without: Vec::new(),
            rename: BTreeMap::new(),
        }
    }
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
        let curves = match super::extension(file).as_str() {
            "csv" => self.table(&source)?,
            "glb" | "gltf" => self.animated(context, &source)?,
            _ => {
                let problem = "curves are read from tables (.csv), plain or of Live Link Face, and from animated .glb \
                               and .gltf files; export the file as one";
                return Err(NodeError::file(file, problem));
            }
        };
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

impl LoadCurves {
    fn table(&self, source: &SourceFile) -> Result<Curves, NodeError> {
        let wrong = |error: face_io::ReadError| NodeError::file(&source.name, error);
        let rate_hz = self.rate_hz.filter(|_| self.by_timecode);
        let timing = Timing { exact: self.by_timecode, rate_hz };
        let mut table = curves::open_with(&source.bytes, timing).map_err(wrong)?;
        if self.by_timecode && table.live_link.is_none() {
            let problem = format!("{} is a plain table, which has no timecodes", source.name);
            return Err(NodeError::parameter("by_timecode", problem));
        }
        table.refuse_gaps(self.longest_gap_s).map_err(|error| wrong(error.into()))?;
        table.rate_hz = self.rate_hz.or(table.rate_hz);
        table.into_curves(None).map_err(wrong)
    }

    fn animated(&self, context: &Context<'_>, source: &SourceFile) -> Result<Curves, NodeError> {
        let name = self.animation.as_deref();
        let read = gltf::read_animation(&source.bytes, name, self.rate_hz, &mut super::beside(context));
        let animation = read.map_err(|error| NodeError::file(&source.name, error))?;
        if !animation.moving_nodes.is_empty() && !animation.joints_follow && !self.without_joints {
            let problem = format!(
                "it moves {} besides its weights, which curves cannot hold; bake that to shapes, or set `without_joints` \
                 to leave it out",
                animation.moving_nodes.join(", ")
            );
            return Err(NodeError::file(&source.name, problem));
        }
        Ok(animation.curves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, HEAD, made, test_data};
    use face_math::rig::{SkinJawOptions, skin_jaw};
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

    /// A recording at 60 Hz with the given frames lost.
    fn recording(lost: std::ops::Range<usize>) -> String {
        let row = |frame: usize| format!("00:00:{:02}:{:02}.000,52,{}\n", frame / 60, frame % 60, frame as f32 / 200.0);
        let rows = (0..200).filter(|frame| !lost.contains(frame)).map(row);
        std::iter::once("Timecode,BlendshapeCount,JawOpen\n".to_owned()).chain(rows).collect()
    }

    #[test]
    fn short_gaps_are_bridged_and_long_ones_refused() {
        let short = load(json!({}), "a.csv", recording(70..90).as_bytes()).unwrap();
        assert_eq!(short.frames(), 200);
        assert!((0..200).all(|frame| (short.frame(frame)[0] - frame as f32 / 200.0).abs() < 1e-6));
        let error = load(json!({}), "a.csv", recording(70..110).as_bytes()).unwrap_err();
        assert!(error.contains("line 72: 40 frames (0.68 s) are missing"), "{error}");
        assert!(load(json!({"longest_gap_s": 1.0}), "a.csv", recording(70..110).as_bytes()).is_ok());
        let half = load(json!({"by_timecode": true, "rate_hz": 30.0}), "a.csv", recording(0..0).as_bytes()).unwrap();
        assert_eq!(half.frame_axis(), FrameAxis::new(100, 30.0));
        assert!((half.frame(7)[0] - 14.0 / 200.0).abs() < 1e-6);
        let error = load(json!({"by_timecode": true}), "a.csv", b"frame,a\n0,1\n").unwrap_err();
        assert!(error.contains("`by_timecode`"), "{error}");
    }

    #[test]
    fn animated_heads_give_their_channels_back() {
        let curves = &HEAD.range_of_motion;
        let axis = curves.frame_axis();
        let notes = json!({"first_frame": axis.first, "frames": axis.count, "rate_hz": axis.rate_hz});
        let jawed = skin_jaw(&HEAD.rig, &SkinJawOptions::default()).unwrap().rig;
        for rig in [&HEAD.rig, &jawed] {
            let file = gltf::write_animation(rig, curves, &notes).unwrap();
            assert!(load(json!({}), "head.glb", &file).unwrap() == curves.arrange(&rig.channels, None).unwrap());
        }
        // The same motion, written by who knows whom.
        let mut foreign = gltf::write_animation(&jawed, curves, &notes).unwrap();
        let generator = foreign.windows(8).position(|bytes| bytes == b"grimace ").unwrap();
        foreign[generator] = b'x';
        assert!(load(json!({}), "head.glb", &foreign).unwrap_err().contains("it moves jaw besides its weights"));
        let read = load(json!({"without_joints": true}), "head.glb", &foreign).unwrap();
        assert_eq!((read.frames(), read.frame_axis().rate_hz), (axis.count, axis.rate_hz));
        assert!(load(json!({"animation": "idle"}), "head.glb", &foreign).unwrap_err().contains("performance"));
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
