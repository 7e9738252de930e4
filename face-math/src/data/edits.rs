//! Edits: what an artist sets by hand over a solve, key by key, and poses that anchor a take. Kept apart from what is solved,
//! so that a new solve keeps them.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::{Data, DecodeError, Decoder, Encoder, Value, ValueKind};

/// How a key's change passes into its neighbour's, or fades where none is near.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KeyCurve {
    /// Slowly at both ends.
    #[default]
    Smooth,
    /// In a straight line.
    Linear,
    /// Not at all: the change holds until the next key, or to the end of its falloff.
    Hold,
}

/// What a key asks for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KeyTarget {
    /// This weight exactly, whatever was solved.
    Value(f64),
    /// So much more than was solved.
    Offset(f64),
}

/// One key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Key {
    /// Number of the frame, as the take counts it.
    pub frame: i64,
    /// What it asks for.
    pub to: KeyTarget,
    /// Frames over which the change fades on either side.
    pub falloff_frames: u32,
    /// How it passes.
    pub curve: KeyCurve,
}

/// A frame at which the puppet's pose is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AnchorPose {
    /// Number of the frame, as the take counts it.
    pub frame: i64,
    /// Weights at which the puppet looks like the take in that frame, by channel.
    pub weights: BTreeMap<String, f64>,
}

/// The edits of one take.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TakeEdits {
    /// Poses that anchor it, in the order in which they apply.
    pub anchors: Vec<AnchorPose>,
    /// Keys by channel, in the order of their frames.
    pub keys: BTreeMap<String, Vec<Key>>,
}

/// The edits of all takes, by the take's name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Edits {
    /// The takes that have any.
    pub takes: BTreeMap<String, TakeEdits>,
}

impl TakeEdits {
    fn counts(&self) -> (usize, usize) {
        (self.keys.values().map(Vec::len).sum(), self.anchors.len())
    }

    fn size(&self) -> usize {
        let (keys, anchors) = self.counts();
        keys * 64 + anchors * 400
    }
}

impl Value for TakeEdits {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(self);
    }

    fn summary(&self) -> String {
        let (keys, anchors) = self.counts();
        format!("{keys} keys on {} channels, {anchors} anchors", self.keys.len())
    }

    fn size(&self) -> usize {
        self.size()
    }
}

impl Data for TakeEdits {
    const NAME: &'static str = "TakeEdits";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        input.record()
    }
}

impl Value for Edits {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&self.takes);
    }

    fn summary(&self) -> String {
        let sum = |count: fn((usize, usize)) -> usize| -> usize {
            self.takes.values().map(|take| count(take.counts())).sum()
        };
        format!("{} takes: {} keys, {} anchors", self.takes.len(), sum(|both| both.0), sum(|both| both.1))
    }

    fn size(&self) -> usize {
        self.takes.values().map(TakeEdits::size).sum()
    }
}

impl Data for Edits {
    const NAME: &'static str = "Edits";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(Self { takes: input.record()? })
    }
}
