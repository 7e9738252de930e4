//! Keys and anchors written into a file of edits, which `load_edits` reads: only what an edit is about changes, every other byte
//! stays. `grimace edit-key` and the editor both write through here.

use face_io::{ReadError, edits};
use face_math::data::{AnchorPose, Edits, Key, KeyTarget};
use graph_core::document::edit::{Change, Draft, EditFault, Step, apply};

/// A file without edits.
pub const EMPTY: &str = "(\n    takes: {\n    },\n)\n";

/// What is done to the keys of one channel.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyEdit {
    /// This key stands in its frame, whatever stood there.
    Set(Key),
    /// The key of one frame stands in another.
    Move {
        /// Where it stands.
        from: i64,
        /// Where it is to stand.
        to: i64,
    },
    /// The key of this frame is taken out.
    Remove(i64),
}

/// What is done to the anchors of a take.
#[derive(Debug, Clone, PartialEq)]
pub enum AnchorEdit {
    /// This pose anchors its frame, whatever anchored it. A new one comes last.
    Set(AnchorPose),
    /// The anchor of this frame is taken out.
    Remove(i64),
}

/// What an edit makes of a text.
#[derive(Debug, Clone)]
pub struct Edited {
    /// The changes that make it.
    pub changes: Vec<Change>,
    /// The text with them.
    pub text: String,
    /// The key that stood in the frame which was set, moved from or removed.
    pub before: Option<Key>,
}

/// Why a text cannot be edited so.
#[derive(Debug, thiserror::Error)]
pub enum EditsFault {
    /// The text is no file of edits, before the edit or with it.
    #[error(transparent)]
    Unreadable(#[from] ReadError),
    /// Its parts are not known.
    #[error(transparent)]
    Text(#[from] EditFault),
    /// There is no such key.
    #[error("take `{take}` has no key on `{channel}` at frame {frame}{}", others_told(.others))]
    NoKey {
        /// The take.
        take: String,
        /// The channel.
        channel: String,
        /// The frame.
        frame: i64,
        /// The frames that have one.
        others: Vec<i64>,
    },
    /// A key would come to stand on another.
    #[error("take `{take}` has a key on `{channel}` at frame {frame} already; take that out first")]
    Taken {
        /// The take.
        take: String,
        /// The channel.
        channel: String,
        /// The frame.
        frame: i64,
    },
    /// There is no such anchor.
    #[error("take `{take}` has no anchor at frame {frame}")]
    NoAnchor {
        /// The take.
        take: String,
        /// The frame.
        frame: i64,
    },
    /// A number that is none.
    #[error("`{0}` is no weight; give a number, mostly 0 to 1")]
    NoWeight(f64),
}

fn others_told(frames: &[i64]) -> String {
    if frames.is_empty() {
        return String::new();
    }
    let frames: Vec<String> = frames.iter().map(i64::to_string).collect();
    format!("; its keys there are at {}", frames.join(", "))
}

/// The edits that stand in `text`.
///
/// # Errors
/// Where it is no file of edits.
pub fn read(text: &str) -> Result<Edits, EditsFault> {
    Ok(edits::read(text.as_bytes())?)
}

/// Edits the keys of `channel` in `take`.
///
/// # Errors
/// Where `text` is no file of edits, or what the edit speaks of is not there, or is in the way.
pub fn edit_key(text: &str, take: &str, channel: &str, edit: &KeyEdit) -> Result<Edited, EditsFault> {
    let known = read(text)?;
    let mut keys = known.takes.get(take).and_then(|take| take.keys.get(channel)).cloned().unwrap_or_default();
    let frame = match edit {
        KeyEdit::Set(key) => key.frame,
        KeyEdit::Move { from, .. } => *from,
        KeyEdit::Remove(frame) => *frame,
    };
    let before = keys.iter().position(|key| key.frame == frame).map(|place| keys.remove(place));
    let (take_name, channel_name) = (take.to_owned(), channel.to_owned());
    match (edit, &before) {
        (KeyEdit::Set(key), _) => {
            let (KeyTarget::Value(number) | KeyTarget::Offset(number)) = key.to;
            if !number.is_finite() {
                return Err(EditsFault::NoWeight(number));
            }
            keys.push(key.clone());
        }
        (_, None) => {
            let others = keys.iter().map(|key| key.frame).collect();
            return Err(EditsFault::NoKey { take: take_name, channel: channel_name, frame, others });
        }
        (KeyEdit::Move { to, .. }, Some(_)) if keys.iter().any(|key| key.frame == *to) => {
            return Err(EditsFault::Taken { take: take_name, channel: channel_name, frame: *to });
        }
        (KeyEdit::Move { to, .. }, Some(key)) => keys.push(Key { frame: *to, ..key.clone() }),
        (KeyEdit::Remove(_), Some(_)) => {}
    }
    keys.sort_by_key(|key| key.frame);
    let place = [Step::Field("takes"), Step::Entry(take), Step::Field("keys"), Step::Entry(channel)];
    let value = (!keys.is_empty()).then(|| edits::keys_text(&keys));
    Ok(Edited { before, ..written(text, &place, value.as_deref())? })
}

/// Edits the anchors of `take`.
///
/// # Errors
/// Where `text` is no file of edits, or the anchor is not there.
pub fn edit_anchor(text: &str, take: &str, edit: &AnchorEdit) -> Result<Edited, EditsFault> {
    let known = read(text)?;
    let mut anchors = known.takes.get(take).map(|take| take.anchors.clone()).unwrap_or_default();
    match edit {
        AnchorEdit::Set(pose) => {
            if let Some(number) = pose.weights.values().find(|number| !number.is_finite()) {
                return Err(EditsFault::NoWeight(*number));
            }
            match anchors.iter_mut().find(|anchor| anchor.frame == pose.frame) {
                Some(anchor) => anchor.clone_from(pose),
                None => anchors.push(pose.clone()),
            }
        }
        AnchorEdit::Remove(frame) => {
            let place = anchors.iter().position(|anchor| anchor.frame == *frame);
            let missing = || EditsFault::NoAnchor { take: take.to_owned(), frame: *frame };
            anchors.remove(place.ok_or_else(missing)?);
        }
    }
    let place = [Step::Field("takes"), Step::Entry(take), Step::Field("anchors")];
    let value = (!anchors.is_empty()).then(|| edits::anchors_text(&anchors));
    written(text, &place, value.as_deref())
}

/// `text` with `value` at `place`, or with nothing there. What is written can be read again, whatever stood there.
fn written(text: &str, place: &[Step<'_>], value: Option<&str>) -> Result<Edited, EditsFault> {
    let draft = Draft::of(text)?;
    let changes = match value {
        Some(value) => draft.set_at(place, value)?,
        None => draft.remove_at(place)?,
    };
    let text = apply(text, &changes);
    read(&text)?;
    Ok(Edited { changes, text, before: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use face_math::data::KeyCurve;

    const TEXT: &str =
        "// mine\n(takes: {\n    // the first\n    \"a\": (keys: {\"jawOpen\": [(frame: 3, value: 0.25)]}),\n})\n";

    fn key(frame: i64, value: f64) -> Key {
        Key { frame, to: KeyTarget::Value(value), falloff_frames: 8, curve: KeyCurve::Smooth }
    }

    #[test]
    fn keys_are_set_moved_and_taken_out_in_their_own_bytes() {
        let edit = |text: &str, edit| edit_key(text, "a", "jawOpen", &edit).map(|edited| edited.text);
        let two = edit(TEXT, KeyEdit::Set(key(9, 0.5))).unwrap();
        assert_eq!(two, TEXT.replace("0.25)", "0.25), (frame: 9, value: 0.5)"));
        let moved = edit(&two, KeyEdit::Move { from: 9, to: -2 }).unwrap();
        assert_eq!(moved, TEXT.replace("[(", "[(frame: -2, value: 0.5), ("));
        assert_eq!(edit(&moved, KeyEdit::Remove(-2)).unwrap(), TEXT);
        assert_eq!(edit(TEXT, KeyEdit::Remove(3)).unwrap(), TEXT.replace("\"jawOpen\": [(frame: 3, value: 0.25)]", ""));
        let told = |text: &str, wanted| edit(text, wanted).unwrap_err().to_string();
        assert!(told(&two, KeyEdit::Move { from: 3, to: 9 }).contains("at frame 9 already"));
        assert!(told(&two, KeyEdit::Remove(4)).contains("its keys there are at 3, 9"));
        assert!(told(TEXT, KeyEdit::Set(key(4, f64::NAN))).contains("`NaN` is no weight"));
        assert!(edit("( takes", KeyEdit::Remove(4)).is_err());
    }

    #[test]
    fn anchors_come_last_and_go_alone() {
        let pose = |frame, weight| AnchorPose { frame, weights: [("jawOpen".to_owned(), weight)].into() };
        let edit = |text: &str, edit| edit_anchor(text, "a", &edit).map(|edited| edited.text);
        let one = edit(TEXT, AnchorEdit::Set(pose(50, 0.5))).unwrap();
        let two = edit(&one, AnchorEdit::Set(pose(7, 0.0))).unwrap();
        let frames =
            |text: &str| read(text).unwrap().takes["a"].anchors.iter().map(|anchor| anchor.frame).collect::<Vec<_>>();
        assert_eq!((frames(&one), frames(&two)), (vec![50], vec![50, 7]));
        assert_eq!(edit(&two, AnchorEdit::Remove(7)).unwrap(), one);
        assert_eq!(read(&edit(&one, AnchorEdit::Remove(50)).unwrap()).unwrap(), read(TEXT).unwrap());
        assert!(edit(TEXT, AnchorEdit::Remove(7)).unwrap_err().to_string().contains("no anchor at frame 7"));
        assert!(two.starts_with("// mine\n(takes: {\n    // the first\n"), "{two}");
    }
}
