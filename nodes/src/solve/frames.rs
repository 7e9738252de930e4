//! Ranges of frames in parameters, in the studios' grammar: `1001-1100x2,1200`.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A set of frames, by the numbers that the take counts them with. The empty text means all frames.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub(crate) struct Frames {
    text: String,
    ranges: Vec<Range>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Range {
    first: i64,
    last: i64,
    step: i64,
}

impl Frames {
    /// How many frames `frame` is away from the nearest one of the set: 0 within it.
    pub fn distance(&self, frame: i64) -> u64 {
        let to = |range: &Range| {
            // The last frame of the range that its step reaches.
            let last = range.last - (range.last - range.first) % range.step;
            let near = if frame <= range.first {
                range.first
            } else if frame >= last {
                last
            } else {
                let below = frame - (frame - range.first) % range.step;
                if frame - below <= range.step - (frame - below) { below } else { below + range.step }
            };
            frame.abs_diff(near)
        };
        self.ranges.iter().map(to).min().unwrap_or(0)
    }
}

impl From<Frames> for String {
    fn from(frames: Frames) -> Self {
        frames.text
    }
}

impl TryFrom<String> for Frames {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let ranges = if text.trim().is_empty() {
            Vec::new()
        } else {
            text.split(',').map(|part| read(part.trim())).collect::<Result<_, _>>()?
        };
        Ok(Self { text, ranges })
    }
}

/// Reads `5`, `1-10` or `1-10x2`; numbers may be negative (`-5--1`).
fn read(part: &str) -> Result<Range, String> {
    let wrong =
        |why: &str| format!("`{part}` is no range of frames: {why}; write `1001-1100`, `1001-1100x2` or `1001`");
    let number = |text: &str| text.parse::<i64>().map_err(|_| wrong(&format!("`{text}` is not a whole number")));
    let (span, step) = match part.split_once('x') {
        Some((span, step)) => (span, number(step)?),
        None => (part, 1),
    };
    if step < 1 {
        return Err(wrong("the step must be 1 or more"));
    }
    // The first sign belongs to the number, so the dash between two numbers is looked for behind it.
    let dash = span.char_indices().skip(1).find(|(_, letter)| *letter == '-').map(|(place, _)| place);
    let (first, last) = match dash {
        Some(dash) => (number(&span[..dash])?, number(&span[dash + 1..])?),
        None => (number(span)?, number(span)?),
    };
    if last < first {
        return Err(wrong("it ends before it begins"));
    }
    Ok(Range { first, last, step })
}

impl JsonSchema for Frames {
    fn schema_name() -> Cow<'static, str> {
        "Frames".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        String::json_schema(generator)
    }

    fn inline_schema() -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(text: &str) -> Frames {
        Frames::try_from(text.to_owned()).unwrap()
    }

    #[test]
    fn the_studios_grammar_is_read() {
        let set = frames("1001-1010x3, 1200,-5--3");
        let inside: Vec<i64> = (-10..1300).filter(|frame| set.distance(*frame) == 0).collect();
        assert_eq!(inside, [-5, -4, -3, 1001, 1004, 1007, 1010, 1200]);
        assert_eq!((frames("").distance(7), frames(" ").distance(-7)), (0, 0));
    }

    #[test]
    fn the_way_to_the_nearest_frame_is_counted() {
        let set = frames("10-20x4,40");
        for (frame, away) in [(3, 7), (10, 0), (11, 1), (12, 2), (13, 1), (18, 0), (20, 2), (29, 11), (30, 10), (45, 5)]
        {
            assert_eq!(set.distance(frame), away, "frame {frame}");
        }
        assert_eq!(frames("").distance(-7), 0);
    }

    #[test]
    fn it_is_written_as_it_was_read() {
        let set: Frames = serde_json::from_str("\"1-10x2\"").unwrap();
        assert_eq!(serde_json::to_string(&set).unwrap(), "\"1-10x2\"");
    }

    #[test]
    fn mistakes_are_named() {
        let error = |text: &str| Frames::try_from(text.to_owned()).unwrap_err();
        assert!(error("10-1").contains("ends before it begins"));
        assert!(error("1-10x0").contains("step"));
        assert!(error("1-1o").contains("`1o` is not a whole number"));
        assert!(error("1,,2").contains("is no range of frames"));
    }
}
