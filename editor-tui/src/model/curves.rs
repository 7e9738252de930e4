//! Curve work: one take's curves with the keys that lie over its solve, and how far they are off. What stands in the file of
//! edits is the truth about keys; what the graph's nodes gave is the truth about curves and errors.

use super::State;
use face_math::data::{AnchorPose, Curves, Key, KeyTarget, TakeEdits};
use face_math::solve::worst_frames;
use std::path::PathBuf;
use std::sync::Arc;

/// The channel of errors over all markers.
const ALL: &str = "rms_mm";
/// The worst frames that are gone through.
const WORST: usize = 12;

/// What a cook gave for the work on one take's curves.
#[derive(Debug, Clone)]
pub struct Desk {
    /// The cell that lays the keys over the solve.
    pub cell: String,
    /// The take, as the file of edits names it.
    pub take: String,
    /// The file of edits.
    pub file: PathBuf,
    /// The curves with their keys.
    pub edited: Arc<Curves>,
    /// The curves that the keys are laid over.
    pub solved: Arc<Curves>,
    /// How far the edited ones are off, in millimetres by region, where the graph measures that.
    pub errors: Option<Arc<Curves>>,
    /// Whether the graph takes anchors from these edits.
    pub anchored: bool,
}

/// Work on one take's curves.
#[derive(Debug, Clone)]
pub struct CurveWork {
    /// The cell and port that it began at.
    pub of: (String, String),
    /// What there is to work on; none while it is on its way.
    pub desk: Option<Arc<Desk>>,
    /// The texts' revision that the desk was made of.
    pub made_of: u64,
    /// The texts' revision of which it was last asked for.
    pub asked_of: Option<u64>,
    /// What went wrong with the last cook of it.
    pub problem: Option<String>,
    /// The frame, by its position.
    pub frame: usize,
    /// The channel.
    pub channel: usize,
    /// The row of errors that worst frames go by.
    pub region: usize,
    /// Which of the worst frames was gone to last.
    pub worst: Option<usize>,
    /// Frames that the chart shows; 0 for all.
    pub span: usize,
    /// Whether frames go on by themselves.
    pub playing: bool,
    /// The take's edits as they stand in the file, or what is wrong with it.
    pub edits: Result<TakeEdits, String>,
    /// The texts' revision that they were read of.
    pub read_of: Option<u64>,
}

/// Frames that a beat goes on while curves play.
pub const FRAMES_A_BEAT: isize = 4;
/// Spans of frames that a chart shows, one after the other.
pub const SPANS: [usize; 4] = [240, 60, 0, 720];

impl CurveWork {
    /// Work that begins at a cell's output.
    pub fn new(of: (String, String)) -> Self {
        Self {
            of,
            desk: None,
            made_of: 0,
            asked_of: None,
            problem: None,
            frame: 0,
            channel: 0,
            region: 0,
            worst: None,
            span: SPANS[0],
            playing: false,
            edits: Ok(TakeEdits::default()),
            read_of: None,
        }
    }

    /// Takes what a cook gave.
    pub fn shown(&mut self, desk: Result<Arc<Desk>, String>, revision: u64) {
        match desk {
            Ok(desk) => {
                (self.problem, self.made_of, self.read_of) = (None, revision, None);
                self.frame = self.frame.min(desk.edited.frames().saturating_sub(1));
                self.channel = self.channel.min(desk.edited.channels().len().saturating_sub(1));
                self.region = self.region.min(regions(&desk).len().saturating_sub(1));
                self.desk = Some(desk);
            }
            // What failed says why better than the cook can.
            Err(problem) => drop(self.problem.get_or_insert(problem)),
        }
    }

    /// The number of the frame, as the take counts it.
    pub fn frame_number(&self) -> i64 {
        let first = self.desk.as_ref().map_or(0, |desk| desk.edited.frame_axis().first);
        first + self.frame as i64
    }

    /// The name of the channel.
    pub fn channel_name(&self) -> Option<&str> {
        self.desk.as_ref()?.edited.channels().get(self.channel).map(String::as_str)
    }

    /// Goes to the frame that the take numbers so, or as near as there is one.
    pub fn go_to(&mut self, number: i64) {
        let Some(desk) = &self.desk else { return };
        let axis = desk.edited.frame_axis();
        let at = usize::try_from(number - axis.first).unwrap_or(0);
        self.frame = at.min(axis.count.saturating_sub(1));
    }

    /// Goes `by` frames on, past neither end.
    pub fn scrub(&mut self, by: isize) {
        let frames = self.desk.as_ref().map_or(0, |desk| desk.edited.frames());
        self.frame = self.frame.saturating_add_signed(by).min(frames.saturating_sub(1));
    }

    /// The weight of the channel in the frame, edited and as it was solved.
    pub fn weights(&self) -> Option<(f32, f32)> {
        let desk = self.desk.as_ref()?;
        let edited = *desk.edited.frame(self.frame).get(self.channel)?;
        let column = desk.solved.index(self.channel_name()?)?;
        Some((edited, *desk.solved.frame(self.frame).get(column)?))
    }

    /// The keys of a channel, in the order of their frames.
    pub fn keys_of(&self, channel: &str) -> &[Key] {
        let keys = self.edits.as_ref().ok().and_then(|edits| edits.keys.get(channel));
        keys.map_or(&[], Vec::as_slice)
    }

    /// The keys of the chosen channel.
    pub fn keys(&self) -> &[Key] {
        self.channel_name().map_or(&[], |channel| self.keys_of(channel))
    }

    /// The key in the frame.
    pub fn key(&self) -> Option<&Key> {
        let frame = self.frame_number();
        self.keys().iter().find(|key| key.frame == frame)
    }

    /// The take's anchors.
    pub fn anchors(&self) -> &[AnchorPose] {
        self.edits.as_ref().map_or(&[], |edits| edits.anchors.as_slice())
    }

    /// The name of the row of errors that worst frames go by.
    pub fn region_name(&self) -> Option<&str> {
        regions(self.desk.as_ref()?).get(self.region).copied()
    }

    /// The frames of the largest errors of the chosen row, the largest first: position and millimetres.
    pub fn worst_frames(&self) -> Vec<(usize, f64)> {
        let errors = self.desk.as_ref().and_then(|desk| desk.errors.as_ref());
        let found = errors.zip(self.region_name()).map(|(errors, region)| worst_frames(errors, region, WORST));
        found.unwrap_or_default()
    }
}

/// The rows of errors: all markers, then each region.
pub fn regions(desk: &Desk) -> Vec<&str> {
    let channels = desk.errors.as_ref().map_or(&[][..], |errors| errors.channels());
    channels.iter().map(String::as_str).filter(|channel| *channel != "worst_mm").collect()
}

/// What a row of errors is called.
pub fn region_title(channel: &str) -> &str {
    if channel == ALL { "all" } else { channel.trim_end_matches("_mm") }
}

/// A key in a few words: `0.400 ±8 frames`.
pub fn key_text(key: &Key) -> String {
    let shape = match key.curve {
        face_math::data::KeyCurve::Smooth => "",
        face_math::data::KeyCurve::Linear => " linear",
        face_math::data::KeyCurve::Hold => " hold",
    };
    let target = match key.to {
        KeyTarget::Value(value) => format!("{value:.3}"),
        KeyTarget::Offset(offset) => format!("{offset:+.3} to the solve"),
    };
    format!("{target} ±{} frames{shape}", key.falloff_frames)
}

impl State {
    /// Reads the edits of the take that is worked on anew, where the texts changed since.
    pub fn read_edits(&mut self) {
        let Some(work) = &mut self.work else { return };
        let Some(desk) = work.desk.clone() else { return };
        if work.read_of == Some(self.texts.revision) {
            return;
        }
        let Some(text) = self.texts.get(&desk.file) else { return };
        work.read_of = Some(self.texts.revision);
        let read = nodes::edits_text::read(&text.now);
        let own = read.map(|edits| edits.takes.get(&desk.take).cloned().unwrap_or_default());
        work.edits = own.map_err(|problem| format!("{}: {problem}", desk.file.display()));
    }
}
