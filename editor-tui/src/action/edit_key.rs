//! Keys and anchors of the take that is worked on: each command is one operation on the file of edits, written as
//! `grimace edit-key` writes it.

use super::changed;
use crate::model::curves::CurveWork;
use crate::model::line::Line;
use crate::model::{Ask, Effect, Overlay, State};
use face_math::data::{AnchorPose, Key, KeyCurve, KeyTarget};
use nodes::edits_text::{AnchorEdit, Edited, EditsFault, KeyEdit, edit_anchor, edit_key};

/// Frames over which a new key fades.
const FALLOFF_FRAMES: u32 = 8;
/// How far a key is moved up or down at a time, finely and coarsely.
const NUDGE: (f64, f64) = (0.01, 0.1);

/// Edits the file of edits: makes an operation of what `edit` changes, for the take's name and the text.
fn edit(
    state: &mut State,
    label: String,
    edit: impl FnOnce(&str, &str) -> Result<Edited, EditsFault>,
) -> Result<Vec<Effect>, String> {
    let Some(desk) = state.work.as_ref().and_then(|work| work.desk.clone()) else {
        return Err("there are no curves to edit yet".to_owned());
    };
    let Some(text) = state.texts.get(&desk.file) else {
        return Err(format!("{} is not read yet, or cannot be", desk.file.display()));
    };
    let edited = edit(&text.now, &desk.take).map_err(|fault| fault.to_string())?;
    let operation = state.texts.edit(label, &desk.file, &edited.changes);
    Ok(changed(state, operation))
}

fn told(state: &mut State, done: Result<Vec<Effect>, String>) -> Vec<Effect> {
    done.unwrap_or_else(|problem| {
        state.complain(problem);
        Vec::new()
    })
}

/// Makes `edit` of the keys of the chosen channel.
fn edit_keys(state: &mut State, does: &str, wanted: &KeyEdit) -> Result<Vec<Effect>, String> {
    let Some(work) = &state.work else { return Ok(Vec::new()) };
    let Some(channel) = work.channel_name().map(str::to_owned) else {
        return Err("there are no curves to edit yet".to_owned());
    };
    let label = format!("{does} {channel} at frame {}", work.frame_number());
    edit(state, label, |text, take| edit_key(text, take, &channel, wanted))
}

/// The key in the frame, or one that holds the curve where it is.
fn key_or_new(work: &CurveWork) -> Option<Key> {
    let (edited, _) = work.weights()?;
    let holding = || Key {
        frame: work.frame_number(),
        to: KeyTarget::Value(rounded(f64::from(edited))),
        falloff_frames: FALLOFF_FRAMES,
        curve: KeyCurve::Smooth,
    };
    Some(work.key().cloned().unwrap_or_else(holding))
}

/// To a thousandth, as people write weights.
fn rounded(weight: f64) -> f64 {
    (weight * 1000.0).round() / 1000.0
}

/// Changes the key in the frame, or a new one that is made for it.
fn set(state: &mut State, does: &str, change: impl FnOnce(&mut Key)) -> Vec<Effect> {
    let Some(mut key) = state.work.as_ref().and_then(key_or_new) else { return Vec::new() };
    change(&mut key);
    let done = edit_keys(state, does, &KeyEdit::Set(key));
    told(state, done)
}

fn nudge(state: &mut State, by: f64) -> Vec<Effect> {
    set(state, "key", |key| {
        let (KeyTarget::Value(number) | KeyTarget::Offset(number)) = &mut key.to;
        *number = rounded(*number + by);
    })
}

/// A little more.
pub fn up(state: &mut State) -> Vec<Effect> {
    nudge(state, NUDGE.0)
}

/// A little less.
pub fn down(state: &mut State) -> Vec<Effect> {
    nudge(state, -NUDGE.0)
}

/// Much more.
pub fn up_more(state: &mut State) -> Vec<Effect> {
    nudge(state, NUDGE.1)
}

/// Much less.
pub fn down_more(state: &mut State) -> Vec<Effect> {
    nudge(state, -NUDGE.1)
}

/// Fades over more frames.
pub fn wider(state: &mut State) -> Vec<Effect> {
    set(state, "widen the key on", |key| key.falloff_frames = key.falloff_frames.saturating_add(2))
}

/// Fades over fewer frames.
pub fn narrower(state: &mut State) -> Vec<Effect> {
    set(state, "narrow the key on", |key| key.falloff_frames = key.falloff_frames.saturating_sub(2))
}

/// The next way in which a key fades.
pub fn curve(state: &mut State) -> Vec<Effect> {
    set(state, "reshape the key on", |key| {
        key.curve = match key.curve {
            KeyCurve::Smooth => KeyCurve::Linear,
            KeyCurve::Linear => KeyCurve::Hold,
            KeyCurve::Hold => KeyCurve::Smooth,
        };
    })
}

/// Asks for a key's value.
pub fn ask(state: &mut State) -> Vec<Effect> {
    if let Some(key) = state.work.as_ref().and_then(key_or_new) {
        let line = Line::new(match key.to {
            KeyTarget::Value(value) if value < 0.0 => format!("={value}"),
            KeyTarget::Value(value) => value.to_string(),
            KeyTarget::Offset(offset) => format!("{offset:+}"),
        });
        state.overlay = Overlay::Prompt { ask: Ask::Key, line, error: None };
    }
    Vec::new()
}

/// Takes what was typed: `0.4` is a weight, `+0.1` and `-0.1` are added to what was solved, `=-0.1` is a weight below 0.
pub fn typed(state: &mut State, text: &str) -> Result<Vec<Effect>, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let to = match text.strip_prefix('=') {
        Some(rest) => number(rest).map(KeyTarget::Value),
        None if text.starts_with(['+', '-']) => number(text).map(KeyTarget::Offset),
        None => number(text).map(KeyTarget::Value),
    };
    let to = to.ok_or_else(|| format!("`{text}` is no weight: write 0.4, or +0.1 to add to the solve"))?;
    let Some(key) = state.work.as_ref().and_then(key_or_new) else { return Ok(Vec::new()) };
    edit_keys(state, "key", &KeyEdit::Set(Key { to, ..key }))
}

fn shift(state: &mut State, by: i64) -> Vec<Effect> {
    let Some(work) = &state.work else { return Vec::new() };
    let Some(from) = work.key().map(|key| key.frame) else {
        state.complain("there is no key in this frame; [ and ] go to those of the channel");
        return Vec::new();
    };
    let axis = work.desk.as_ref().map(|desk| desk.edited.frame_axis());
    let to = from + by;
    if axis.is_none_or(|axis| to < axis.first || to >= axis.first + axis.count as i64) {
        state.complain("the take ends here");
        return Vec::new();
    }
    match edit_keys(state, "move the key on", &KeyEdit::Move { from, to }) {
        Ok(effects) => {
            if let Some(work) = &mut state.work {
                work.go_to(to);
            }
            effects
        }
        Err(problem) => told(state, Err(problem)),
    }
}

/// Moves the key a frame back, and goes with it.
pub fn earlier(state: &mut State) -> Vec<Effect> {
    shift(state, -1)
}

/// Moves the key a frame on, and goes with it.
pub fn later(state: &mut State) -> Vec<Effect> {
    shift(state, 1)
}

/// Takes the key out.
pub fn delete(state: &mut State) -> Vec<Effect> {
    let Some(frame) = state.work.as_ref().map(CurveWork::frame_number) else { return Vec::new() };
    let done = edit_keys(state, "delete the key on", &KeyEdit::Remove(frame));
    told(state, done)
}

/// Anchors the take in this frame by the curves as they are, or takes its anchor away.
pub fn anchor(state: &mut State) -> Vec<Effect> {
    let Some(work) = &state.work else { return Vec::new() };
    let Some(desk) = work.desk.clone() else { return Vec::new() };
    let frame = work.frame_number();
    if !desk.anchored {
        state.complain("no `set_anchors` of the graph takes anchors from this file");
        return Vec::new();
    }
    let (label, wanted) = if work.anchors().iter().any(|anchor| anchor.frame == frame) {
        (format!("take the anchor at frame {frame} away"), AnchorEdit::Remove(frame))
    } else {
        let weights = desk.edited.channels().iter().zip(desk.edited.frame(work.frame));
        let weights = weights.map(|(channel, weight)| (channel.clone(), rounded(f64::from(*weight)))).collect();
        (format!("anchor frame {frame}"), AnchorEdit::Set(AnchorPose { frame, weights }))
    };
    let done = edit(state, label, |text, take| edit_anchor(text, take, &wanted));
    told(state, done)
}

fn to_key(state: &mut State, back: bool) -> Vec<Effect> {
    let Some(work) = &mut state.work else { return Vec::new() };
    let here = work.frame_number();
    let mut frames = work.keys().iter().map(|key| key.frame);
    let found = if back { frames.rfind(|frame| *frame < here) } else { frames.find(|frame| *frame > here) };
    match found {
        Some(frame) => work.go_to(frame),
        None => state.complain("there is no further key on this channel"),
    }
    Vec::new()
}

/// The next key of the channel.
pub fn next(state: &mut State) -> Vec<Effect> {
    to_key(state, false)
}

/// The previous one.
pub fn previous(state: &mut State) -> Vec<Effect> {
    to_key(state, true)
}
