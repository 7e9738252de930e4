//! `save_curves`: solved curves as a table, for an animation package or for `load_curves`.

use face_io::curves::{self, Timecode};
use face_math::data::Curves;
use graph_core::cook::{Artifact, FILES};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CURVES: Port<Curves> = Port::new("curves", "one weight per channel and frame");

/// Which table is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Style {
    /// A column `frame`, then one a channel, under the names of the channels.
    #[default]
    Plain,
    /// A recording of Live Link Face: timecodes from 00:00:00:00 on and the 52 columns of `ARKit`.
    LiveLink,
}

/// Writes curves as a table (CSV).
///
/// Numbers are the shortest that read back as the same. For Live Link Face the curves must have its channels, under
/// the names that `load_curves` gives them (`eyeBlink_L`); only `tongueOut` may be absent. `BrowInnerUp` and
/// `CheekPuff` become the mean of their two sides. Timecodes count on from `first_timecode`; written with a `;` before
/// its frames it is drop-frame, which keeps 29.97 and 59.94 Hz beside the clock.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SaveCurves {
    /// The file to write, such as `out/{take}.csv`.
    path: String,
    /// Which table is written.
    style: Style,
    /// Whether the first line of a plain table is the comment `# rate_hz: 60`. Turn it off for programs that know no
    /// comments; the rate must then be told to whoever reads the file.
    state_rate: bool,
    /// Timecode of the first frame in a recording of Live Link Face: `18:45:19:00`, or `18:45:19;00` for drop-frame.
    first_timecode: String,
}

impl Default for SaveCurves {
    fn default() -> Self {
        Self { path: String::new(), style: Style::Plain, state_rate: true, first_timecode: "00:00:00:00".to_owned() }
    }
}

graph_core::register!(SaveCurves);

#[typetag::serde(name = "save_curves")]
impl Node for SaveCurves {
    fn card(&self) -> Card {
        Card::new("save").takes(&CURVES).writes("path")
    }

    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let curves = inputs.get(&CURVES)?;
        let bytes = match self.style {
            Style::Plain => curves::write(curves, self.state_rate),
            Style::LiveLink => curves::write_live_link(curves, self.first_timecode()?),
        };
        let bytes = bytes.map_err(|error| NodeError::input(CURVES.name(), error))?;
        Ok(Outputs::default().with(&FILES, Artifact { bytes }))
    }
}

impl SaveCurves {
    fn first_timecode(&self) -> Result<Timecode, NodeError> {
        Timecode::from_text(&self.first_timecode).ok_or_else(|| {
            let problem = format!("`{}` is no timecode such as 18:45:19:00", self.first_timecode);
            NodeError::parameter("first_timecode", problem)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{HEAD, compute, made};
    use serde_json::json;
    use wire::FrameAxis;

    fn saved(parameters: serde_json::Value, curves: &Curves) -> Result<String, String> {
        let node: SaveCurves = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&CURVES, curves.clone()));
        let bytes = outputs.map_err(|error| error.to_string())?.get(&FILES).unwrap().bytes.clone();
        Ok(String::from_utf8(bytes).unwrap())
    }

    fn curves(value: f32) -> Curves {
        let axis = FrameAxis { first: 7, count: 2, rate_hz: 60.0 };
        Curves::new(axis, vec!["jawOpen".into(), "brow".into()], vec![0.5, 0.1, value, 1.0]).unwrap()
    }

    #[test]
    fn a_plain_table_may_leave_the_rate_out() {
        assert_eq!(
            saved(json!({}), &curves(0.25)).unwrap(),
            "# rate_hz: 60\nframe,jawOpen,brow\n7,0.5,0.1\n8,0.25,1\n"
        );
        let bare = saved(json!({"state_rate": false}), &curves(0.25)).unwrap();
        assert_eq!(bare, "frame,jawOpen,brow\n7,0.5,0.1\n8,0.25,1\n");
    }

    #[test]
    fn live_link_face_reads_back() {
        let text = saved(json!({"style": "live_link"}), &HEAD.range_of_motion).unwrap();
        let back = curves::read(text.as_bytes(), None).unwrap();
        let (own, read) = (&HEAD.range_of_motion, back.index("jawOpen").unwrap());
        let column = own.index("jawOpen").unwrap();
        assert_eq!((back.frames(), back.frame_axis().rate_hz), (own.frames(), 60.0));
        assert!((0..own.frames()).all(|t| own.frame(t)[column].to_bits() == back.frame(t)[read].to_bits()));
    }

    #[test]
    fn timecodes_count_on_drop_frame_too() {
        let own = &HEAD.range_of_motion;
        let axis = FrameAxis { rate_hz: 60_000.0 / 1001.0, ..own.frame_axis() };
        let slow = Curves::new(axis, own.channels().to_vec(), own.values().to_vec()).unwrap();
        let with = |first: &str| json!({"style": "live_link", "first_timecode": first});
        let text = saved(with("10:00:58;30"), &slow).unwrap();
        assert!(text.lines().nth(1).unwrap().starts_with("10:00:58;30.000,52,"));
        assert!(text.contains("\n10:00:59;59.000,") && text.contains("\n10:01:00;04.000,"));
        let back = curves::read(text.as_bytes(), None).unwrap();
        assert_eq!((back.frames(), back.frame_axis().rate_hz.to_bits()), (own.frames(), axis.rate_hz.to_bits()));
        assert!(saved(with("10:01:00;03"), &slow).unwrap_err().contains("leaves it out"));
        assert!(saved(with("10:00:58;30"), own).unwrap_err().contains("needs curves at 29.97"));
        assert!(saved(with("soon"), own).unwrap_err().contains("`first_timecode`"));
    }

    #[test]
    fn what_cannot_be_written_is_named() {
        let error = saved(json!({}), &curves(f32::NAN)).unwrap_err();
        assert!(error.contains("input `curves`") && error.contains("`jawOpen` in frame 8"), "{error}");
        let error = saved(json!({"style": "live_link"}), &curves(0.0)).unwrap_err();
        assert!(error.contains("`brow`"), "{error}");
    }
}
