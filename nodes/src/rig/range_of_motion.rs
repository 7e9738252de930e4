//! `range_of_motion`: lays pieces of motion end to end, in the channels of a rig; what the networks are trained on.

use face_math::data::{Curves, Rig, nearest_name};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use wire::FrameAxis;

const CURVES: Port<Curves> = Port::new(
    "curves",
    "pieces of motion: a FACS sweep, recordings of the actor's range of motion, approved shots; taken in the order of their \
     names",
);
const RIG: Port<Rig> = Port::new("rig", "the head whose channels the motion is for");
const MOTION: Port<Curves> =
    Port::new("curves", "all pieces end to end: the weights of all channels of the rig, in its order");

/// Lays pieces of motion end to end, with the channels of a rig in the rig's order.
///
/// A channel of the rig that a piece lacks rests at 0 in that piece. A channel that the rig lacks is an error, unless
/// `ignore_unknown` is set. Frames are counted from 0 at the rate of the first piece: what is trained on them knows no
/// time, so pieces of other rates are laid beside it frame for frame.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RangeOfMotion {
    /// Whether to pass over channels that the rig lacks, such as the head's rotation in recordings of phones.
    ignore_unknown: bool,
    /// Takes every so many-th frame of each piece: 1 takes all.
    #[schemars(range(min = 1, max = 10_000))]
    frame_step: usize,
    /// Whether to move weights into 0 to 1. Weights outside are kept otherwise.
    clamp: bool,
}

impl Default for RangeOfMotion {
    fn default() -> Self {
        Self { ignore_unknown: false, frame_step: 1, clamp: false }
    }
}

graph_core::register!(RangeOfMotion);

#[typetag::serde(name = "range_of_motion")]
impl Node for RangeOfMotion {
    fn card(&self) -> Card {
        Card::new("rig").gathers(&CURVES).takes(&RIG).gives(&MOTION)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let rig = inputs.get(&RIG)?;
        let pieces = inputs.items(&CURVES)?;
        let mut values = Vec::new();
        let mut rate_hz = None;
        for (item, piece) in &pieces {
            context.go_on()?;
            if !self.ignore_unknown {
                known(rig, item, piece)?;
            }
            let arranged =
                piece.arrange(&rig.channels, Some(0.0)).map_err(|error| NodeError::input(CURVES.name(), error))?;
            super::check_finite(&named(item), &arranged)?;
            rate_hz = rate_hz.or(Some(piece.frame_axis().rate_hz));
            for frame in (0..arranged.frames()).step_by(self.frame_step.max(1)) {
                let clamped = |weight: &f32| if self.clamp { weight.clamp(0.0, 1.0) } else { *weight };
                values.extend(arranged.frame(frame).iter().map(clamped));
            }
        }
        let rate_hz = rate_hz.ok_or_else(|| NodeError::input(CURVES.name(), "there is no piece of motion"))?;
        let axis = FrameAxis::new(values.len() / rig.channels.len().max(1), rate_hz);
        let motion = Curves::new(axis, rig.channels.clone(), values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&MOTION, motion))
    }
}

/// The port and the item, for messages.
fn named(item: &str) -> String {
    if item.is_empty() { CURVES.name().to_owned() } else { format!("{}@{item}", CURVES.name()) }
}

/// Refuses channels that the rig lacks, all in one message.
fn known(rig: &Rig, item: &str, piece: &Curves) -> Result<(), NodeError> {
    let own: BTreeSet<&String> = rig.channels.iter().collect();
    let strange: Vec<_> = piece.channels().iter().filter(|channel| !own.contains(channel)).collect();
    if strange.is_empty() {
        return Ok(());
    }
    let told: Vec<_> = strange
        .iter()
        .take(8)
        .map(|channel| match nearest_name(channel, rig.channels.iter().map(String::as_str)) {
            Some(near) => format!("`{channel}` (did you mean `{near}`?)"),
            None => format!("`{channel}`"),
        })
        .collect();
    let more =
        if strange.len() > told.len() { format!(" and {} more", strange.len() - told.len()) } else { String::new() };
    let problem = format!(
        "rig `{}` has no channel {}{more}; rename them where they are loaded, or set `ignore_unknown`",
        rig.name,
        told.join(", ")
    );
    Err(NodeError::input(&named(item), problem))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    fn piece(channels: &[&str], rate_hz: f64, values: Vec<f32>) -> Curves {
        let axis = FrameAxis { first: 30, count: values.len() / channels.len(), rate_hz };
        Curves::new(axis, channels.iter().map(|channel| (*channel).to_owned()).collect(), values).unwrap()
    }

    fn lay(parameters: serde_json::Value, pieces: Vec<(&str, Curves)>) -> Result<Curves, String> {
        let node: RangeOfMotion = made(parameters);
        let pieces = pieces.into_iter().map(|(name, piece)| (name.to_owned(), piece));
        let outputs = compute(&node, &Inputs::default().with(&RIG, toy::rig()).with_list(&CURVES, pieces));
        outputs.map(|outputs| outputs.get(&MOTION).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn pieces_lie_end_to_end_in_the_channels_of_the_rig() {
        let a = piece(&["browUp", "jawOpen"], 60.0, vec![0.1, 0.2, 0.3, 1.4]);
        let b = piece(&["smile_R"], 30.0, vec![-0.5]);
        let motion = lay(json!({}), vec![("a", a.clone()), ("b", b.clone())]).unwrap();
        assert_eq!(motion.channels(), toy::rig().channels);
        assert_eq!(motion.frame_axis(), FrameAxis::new(3, 60.0));
        assert_eq!(motion.values(), [0.2, 0.0, 0.0, 0.1, 1.4, 0.0, 0.0, 0.3, 0.0, 0.0, -0.5, 0.0]);
        let clamped = lay(json!({"clamp": true}), vec![("a", a), ("b", b)]).unwrap();
        assert_eq!((clamped.values()[4], clamped.values()[10]), (1.0, 0.0));
    }

    #[test]
    fn frames_can_be_thinned() {
        let values: Vec<f32> = (0..7).map(|frame| frame as f32 / 10.0).collect();
        let motion = lay(json!({"frame_step": 3}), vec![("a", piece(&["jawOpen"], 60.0, values))]).unwrap();
        let jaw: Vec<f32> = (0..motion.frames()).map(|frame| motion.frame(frame)[0]).collect();
        assert_eq!(jaw, [0.0, 0.3, 0.6]);
    }

    #[test]
    fn unknown_channels_are_named_or_passed_over() {
        let strange = piece(&["jawOpn", "headYaw"], 60.0, vec![0.5, 0.5]);
        let error = lay(json!({}), vec![("rom", strange.clone())]).unwrap_err();
        assert!(
            error.contains("curves@rom") && error.contains("`jawOpn` (did you mean `jawOpen`?), `headYaw`"),
            "{error}"
        );
        let motion = lay(json!({"ignore_unknown": true}), vec![("rom", strange)]).unwrap();
        assert_eq!(motion.values(), [0.0; 4]);
    }

    #[test]
    fn broken_weights_and_no_pieces_are_refused() {
        let broken = piece(&["jawOpen"], 60.0, vec![0.0, f32::INFINITY]);
        let error = lay(json!({}), vec![("rom", broken)]).unwrap_err();
        assert!(error.contains("curves@rom") && error.contains("`jawOpen` is inf in frame 31"), "{error}");
        assert!(lay(json!({}), Vec::new()).unwrap_err().contains("no piece of motion"));
    }
}
