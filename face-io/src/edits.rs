//! Files of edits: keys over solved curves, and poses that anchor takes, in RON, written by hand or by `grimace edit-key`.
//!
//! ```text
//! (
//!     takes: {
//!         "day1_161": (
//!             anchors: [(frame: 52), (frame: 700, weights: {"jawOpen": 0.3})],
//!             keys: {
//!                 "jawOpen": [(frame: 120, value: 0.4, falloff_frames: 8), (frame: 180, offset: 0.1, curve: linear)],
//!             },
//!         ),
//!     },
//! )
//! ```

use crate::ReadError;
use face_math::data::{AnchorPose, Edits, Key, KeyCurve, KeyTarget, TakeEdits};
use ron::extensions::Extensions;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Frames over which a key fades where it does not say so.
pub const USUAL_FALLOFF_FRAMES: u32 = 8;

/// Why text is no file of edits.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EditsError {
    /// Bytes that are no UTF-8 text.
    #[error("byte {at} is not UTF-8 text; save the file as UTF-8")]
    NotText {
        /// Position of the byte.
        at: usize,
    },
    /// A mistake at a place of the text.
    #[error("{line}:{column}: {problem}")]
    At {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// A key that says nothing, or two things.
    #[error("take `{take}`, channel `{channel}`, frame {frame}: a key has either a `value` or an `offset`")]
    Target {
        /// The take.
        take: String,
        /// The channel.
        channel: String,
        /// The frame.
        frame: i64,
    },
    /// Two keys or anchors at one frame.
    #[error("take `{take}`, {what}: frame {frame} stands twice; leave one of them")]
    Twice {
        /// The take.
        take: String,
        /// Which list.
        what: String,
        /// The frame.
        frame: i64,
    },
    /// A number that is none.
    #[error("take `{take}`, {what}, frame {frame}: {number} is no weight; give a number")]
    NoNumber {
        /// The take.
        take: String,
        /// Which list.
        what: String,
        /// The frame.
        frame: i64,
        /// What stands there.
        number: f64,
    },
}

#[derive(Deserialize)]
#[serde(rename = "Edits", deny_unknown_fields)]
struct EditsBody {
    takes: BTreeMap<String, TakeBody>,
}

#[derive(Deserialize)]
#[serde(rename = "Take", deny_unknown_fields, default)]
#[derive(Default)]
struct TakeBody {
    anchors: Vec<AnchorBody>,
    keys: BTreeMap<String, Vec<KeyBody>>,
}

#[derive(Deserialize)]
#[serde(rename = "Anchor", deny_unknown_fields)]
struct AnchorBody {
    frame: i64,
    #[serde(default)]
    weights: BTreeMap<String, f64>,
}

#[derive(Deserialize)]
#[serde(rename = "Key", deny_unknown_fields)]
struct KeyBody {
    frame: i64,
    value: Option<f64>,
    offset: Option<f64>,
    #[serde(default = "usual_falloff")]
    falloff_frames: u32,
    #[serde(default)]
    curve: KeyCurve,
}

fn usual_falloff() -> u32 {
    USUAL_FALLOFF_FRAMES
}

/// Reads a file of edits.
///
/// # Errors
/// See [`EditsError`].
pub fn read(bytes: &[u8]) -> Result<Edits, ReadError> {
    Ok(parse(bytes)?)
}

/// Whether bytes are a file of edits.
pub(crate) fn detect(bytes: &[u8]) -> bool {
    parse(bytes).is_ok()
}

fn parse(bytes: &[u8]) -> Result<Edits, EditsError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| EditsError::NotText { at: error.valid_up_to() })?;
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let body: EditsBody = options.from_str(text).map_err(|error| EditsError::At {
        line: error.span.start.line,
        column: error.span.start.col,
        problem: error.code.to_string(),
    })?;
    let takes = body.takes.into_iter().map(|(name, take)| Ok((name.clone(), take_of(&name, take)?)));
    Ok(Edits { takes: takes.collect::<Result<_, EditsError>>()? })
}

fn take_of(name: &str, body: TakeBody) -> Result<TakeEdits, EditsError> {
    let weight = |what: &str, frame: i64, number: f64| {
        let (take, what) = (name.to_owned(), what.to_owned());
        if number.is_finite() { Ok(()) } else { Err(EditsError::NoNumber { take, what, frame, number }) }
    };
    let mut take = TakeEdits::default();
    for AnchorBody { frame, weights } in body.anchors {
        for number in weights.values() {
            weight("anchors", frame, *number)?;
        }
        if take.anchors.iter().any(|other| other.frame == frame) {
            return Err(EditsError::Twice { take: name.to_owned(), what: "anchors".to_owned(), frame });
        }
        take.anchors.push(AnchorPose { frame, weights });
    }
    for (channel, bodies) in body.keys {
        let what = format!("channel `{channel}`");
        let mut keys = Vec::with_capacity(bodies.len());
        for KeyBody { frame, value, offset, falloff_frames, curve } in bodies {
            let to = match (value, offset) {
                (Some(value), None) => KeyTarget::Value(value),
                (None, Some(offset)) => KeyTarget::Offset(offset),
                _ => return Err(EditsError::Target { take: name.to_owned(), channel, frame }),
            };
            let (KeyTarget::Value(number) | KeyTarget::Offset(number)) = to;
            weight(&what, frame, number)?;
            keys.push(Key { frame, to, falloff_frames, curve });
        }
        keys.sort_by_key(|key| key.frame);
        if let Some(pair) = keys.windows(2).find(|pair| pair[0].frame == pair[1].frame) {
            return Err(EditsError::Twice { take: name.to_owned(), what, frame: pair[0].frame });
        }
        take.keys.insert(channel, keys);
    }
    Ok(take)
}

/// The keys of one channel as they stand in a file.
pub fn keys_text(keys: &[Key]) -> String {
    let mut texts = Vec::with_capacity(keys.len());
    for key in keys {
        let mut text = format!("(frame: {}", key.frame);
        let _ = match key.to {
            KeyTarget::Value(value) => write!(text, ", value: {value:?}"),
            KeyTarget::Offset(offset) => write!(text, ", offset: {offset:?}"),
        };
        if key.falloff_frames != USUAL_FALLOFF_FRAMES {
            let _ = write!(text, ", falloff_frames: {}", key.falloff_frames);
        }
        match key.curve {
            KeyCurve::Smooth => {}
            KeyCurve::Linear => text.push_str(", curve: linear"),
            KeyCurve::Hold => text.push_str(", curve: hold"),
        }
        texts.push(text + ")");
    }
    format!("[{}]", texts.join(", "))
}

/// The anchors of one take as they stand in a file.
pub fn anchors_text(anchors: &[AnchorPose]) -> String {
    let text = |anchor: &AnchorPose| {
        if anchor.weights.is_empty() {
            return format!("(frame: {})", anchor.frame);
        }
        let weights: Vec<String> =
            anchor.weights.iter().map(|(channel, weight)| format!("{channel:?}: {weight:?}")).collect();
        format!("(frame: {}, weights: {{{}}})", anchor.frame, weights.join(", "))
    };
    let texts: Vec<String> = anchors.iter().map(text).collect();
    format!("[{}]", texts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str) -> String {
        read(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn keys_are_read_as_they_are_written() {
        let text = "(takes: {\"a\": (anchors: [(frame: 3), (frame: -1, weights: {\"jawOpen\": 0.5})], keys: {\n\
                    // a comment\n\"jawOpen\": [(frame: 9, offset: -0.25, falloff_frames: 0, curve: hold), (frame: 2, value: 1)]}), \
                    \"b\": ()})";
        let edits = read(text.as_bytes()).unwrap();
        let take = &edits.takes["a"];
        assert_eq!(take.anchors.iter().map(|anchor| anchor.frame).collect::<Vec<_>>(), [3, -1]);
        assert_eq!(take.keys["jawOpen"].iter().map(|key| key.frame).collect::<Vec<_>>(), [2, 9]);
        let (anchors, keys) = (anchors_text(&take.anchors), keys_text(&take.keys["jawOpen"]));
        let again = format!("(takes: {{\"a\": (anchors: {anchors}, keys: {{\"jawOpen\": {keys}}})}})");
        assert_eq!(read(again.as_bytes()).unwrap().takes["a"], *take);
        assert_eq!(edits.takes["b"], TakeEdits::default());
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        assert!(
            told("(takes: {\n  \"a\": (kees: {}),\n})").contains("2:"),
            "{}",
            told("(takes: {\n  \"a\": (kees: {}),\n})")
        );
        let key = |key: &str| format!("(takes: {{\"a\": (keys: {{\"jawOpen\": [{key}]}})}})");
        assert!(told(&key("(frame: 1)")).contains("channel `jawOpen`, frame 1: a key has either"));
        assert!(told(&key("(frame: 1, value: 0.5, offset: 1.0)")).contains("either a `value` or an `offset`"));
        assert!(told(&key("(frame: 1, value: 0.5), (frame: 1, value: 1.0)")).contains("frame 1 stands twice"));
        assert!(told(&key("(frame: 1, value: inf)")).contains("is no weight"));
        assert!(
            told("(takes: {\"a\": (anchors: [(frame: 1), (frame: 1)])})").contains("anchors: frame 1 stands twice")
        );
    }
}
