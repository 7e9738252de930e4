//! `edit_curves`: what an artist sets by hand over solved curves. After the jaw's pass, so that the regions follow it, and after
//! the last pass.

use crate::rig::frame_number;
use face_math::data::{Curves, Key, KeyTarget, TakeEdits, nearest_name};
use face_math::solve::{Change, layer};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CURVES: Port<Curves> = Port::new("curves", "solved weights of the take");
const EDITS: Port<TakeEdits> = Port::new("edits", "the take's keys; without it, the curves stay as they are");
const BEFORE: Port<Curves> = Port::new(
    "before",
    "curves that these keys have edited already (the jaw's): at a key of their channels, what they came to there counts as its \
     value, so that no offset is added twice",
);
const EDITED: Port<Curves> = Port::new("curves", "the same channels and frames, with the keys' changes");

/// Lays keys over solved curves. The solve stays what it was: without its key, a frame is again as it was solved.
///
/// At a key's frame the weight is the key's `value`, or the solved one and its `offset`. The change fades over the key's falloff,
/// or passes into the next key's where the two meet, and moves what was solved up or down between them; there, it never leaves 0
/// to 1 unless the solve or a key does.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EditCurves {
    /// Leaves out keys of channels that these curves do not have, as where only the jaw is solved yet. Else they are an error.
    skip_others: bool,
}

graph_core::register!(EditCurves);

#[typetag::serde(name = "edit_curves")]
impl Node for EditCurves {
    fn card(&self) -> Card {
        Card::new("solve").takes(&CURVES).may_take(&EDITS).may_take(&BEFORE).gives(&EDITED)
    }

    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let curves = inputs.get(&CURVES)?;
        let before = inputs.may_get(&BEFORE)?;
        if let Some(before) = before {
            let fits = before.frame_axis().matches(&curves.frame_axis());
            fits.map_err(|error| NodeError::input(BEFORE.name(), error))?;
        }
        let mut values = curves.values().to_vec();
        for (channel, keys) in inputs.may_get(&EDITS)?.iter().flat_map(|edits| &edits.keys) {
            match curves.index(channel) {
                Some(column) => lay(&mut values, curves, column, keys, before)?,
                None if self.skip_others => {}
                None => return Err(unknown(channel, keys, curves)),
            }
        }
        let edited = Curves::new(curves.frame_axis(), curves.channels().to_vec(), values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&EDITED, edited))
    }
}

/// Lays the keys of one channel over it.
fn lay(
    values: &mut [f32],
    curves: &Curves,
    column: usize,
    keys: &[Key],
    before: Option<&Curves>,
) -> Result<(), NodeError> {
    let channel = &curves.channels()[column];
    let width = curves.channels().len();
    let before = before.and_then(|before| Some((before, before.index(channel)?)));
    let mut changes = Vec::with_capacity(keys.len());
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for key in keys {
        let at = place(curves, channel, key)?;
        let solved = f64::from(curves.frame(at)[column]);
        let value = match (before, key.to) {
            (Some((before, column)), _) => f64::from(before.frame(at)[column]),
            (None, KeyTarget::Value(value)) => value,
            (None, KeyTarget::Offset(offset)) => solved + offset,
        };
        (low, high) = (low.min(value), high.max(value));
        let falloff = usize::try_from(key.falloff_frames).unwrap_or(usize::MAX);
        changes.push(Change { at, by: value - solved, falloff, curve: key.curve });
    }
    for (frame, by) in layer(&changes, curves.frames()).into_iter().enumerate() {
        if by != 0.0 {
            let value = &mut values[frame * width + column];
            let solved = f64::from(*value);
            *value = (solved + by).clamp(low.min(solved), high.max(solved)) as f32;
        }
    }
    Ok(())
}

/// Position of a key's frame.
fn place(curves: &Curves, channel: &str, key: &Key) -> Result<usize, NodeError> {
    let axis = curves.frame_axis();
    let place = key.frame.checked_sub(axis.first).and_then(|place| usize::try_from(place).ok());
    place.filter(|place| *place < axis.count).ok_or_else(|| {
        let last = frame_number(axis, axis.count) - 1;
        let problem = format!(
            "channel `{channel}` has a key at frame {}, and the take holds {} to {last}; move the key, or take it out",
            key.frame, axis.first
        );
        NodeError::input(EDITS.name(), problem)
    })
}

fn unknown(channel: &str, keys: &[Key], curves: &Curves) -> NodeError {
    let near = nearest_name(channel, curves.channels().iter().map(String::as_str));
    let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
    let frame = keys.first().map(|key| format!(" at frame {}", key.frame)).unwrap_or_default();
    NodeError::input(
        EDITS.name(),
        format!("there is a key{frame} on `{channel}`, which is no channel of the curves{near}"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use face_math::data::KeyCurve;
    use serde_json::json;
    use wire::FrameAxis;

    /// Two channels over frames 101 to 120: 0.25, and a ramp.
    fn solved() -> Curves {
        let axis = FrameAxis { first: 101, count: 20, rate_hz: 60.0 };
        let values = (0..20).flat_map(|frame| [0.25, frame as f32 / 20.0]).collect();
        Curves::new(axis, vec!["jawOpen".into(), "smile".into()], values).unwrap()
    }

    fn key(frame: i64, to: KeyTarget) -> Key {
        Key { frame, to, falloff_frames: 2, curve: KeyCurve::Linear }
    }

    fn edits(channel: &str, keys: Vec<Key>) -> TakeEdits {
        TakeEdits { keys: [(channel.to_owned(), keys)].into(), ..TakeEdits::default() }
    }

    fn edit(edits: TakeEdits, before: Option<Curves>, skip_others: bool) -> Result<Vec<f32>, String> {
        let node: EditCurves = made(json!({ "skip_others": skip_others }));
        let inputs = Inputs::default().with(&CURVES, solved()).with(&EDITS, edits);
        let inputs = match before {
            Some(before) => inputs.with(&BEFORE, before),
            None => inputs,
        };
        let outputs = compute(&node, &inputs).map_err(|error| error.to_string())?;
        let edited = outputs.get(&EDITED).unwrap();
        Ok((0..20).flat_map(|frame| edited.frame(frame).to_vec()).collect())
    }

    #[test]
    fn a_key_moves_its_frames_and_no_others() {
        let edited = edit(edits("jawOpen", vec![key(110, KeyTarget::Value(0.7))]), None, false).unwrap();
        let solved: Vec<f32> = solved().values().to_vec();
        assert_eq!(edited[2 * 9].to_bits(), 0.7_f32.to_bits());
        let changed: Vec<_> = (0..40).filter(|at| edited[*at].to_bits() != solved[*at].to_bits()).collect();
        assert_eq!(changed, [14, 16, 18, 20, 22], "two frames on either side, in one channel");
        assert!((edited[16] - 0.55).abs() < 1e-6);
        assert_eq!(edit(TakeEdits::default(), None, false).unwrap(), solved);
    }

    #[test]
    fn offsets_add_to_the_solve_and_only_once() {
        let keys = edits("jawOpen", vec![key(105, KeyTarget::Offset(0.1))]);
        let edited = edit(keys.clone(), None, false).unwrap();
        assert!((edited[8] - 0.35).abs() < 1e-6);
        // The jaw was edited before, and came to 0.3 there.
        let axis = solved().frame_axis();
        let before = Curves::new(axis, vec!["jawOpen".into()], vec![0.3; 20]).unwrap();
        assert!((edit(keys, Some(before), false).unwrap()[8] - 0.3).abs() < 1e-6);
    }

    #[test]
    fn what_is_between_stays_within_0_and_1() {
        let wide = Key { falloff_frames: 9, ..key(112, KeyTarget::Value(1.0)) };
        let edited = edit(edits("smile", vec![wide]), None, false).unwrap();
        assert!(edited.iter().all(|value| (0.0..=1.0).contains(value)));
        // An artist's own number may leave them.
        let keys = vec![key(119, KeyTarget::Value(-0.5)), key(120, KeyTarget::Value(1.5))];
        let edited = edit(edits("smile", keys), None, false).unwrap();
        assert_eq!((edited[37], edited[39]), (-0.5, 1.5));
    }

    #[test]
    fn keys_that_fit_nothing_are_named() {
        let unknown = || edits("jawOpne", vec![key(105, KeyTarget::Value(0.1))]);
        let told = edit(unknown(), None, false).unwrap_err();
        assert!(told.contains("frame 105") && told.contains("did you mean `jawOpen`?"), "{told}");
        assert!(edit(unknown(), None, true).is_ok());
        let told = edit(edits("smile", vec![key(4, KeyTarget::Value(0.1))]), None, false).unwrap_err();
        assert!(told.contains("frame 4") && told.contains("101 to 120"), "{told}");
    }
}
