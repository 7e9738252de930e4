//! `set_anchors`: the poses at which an artist says what the puppet looks like (Eq. 5 of FDLS); `align_anchors` moves the
//! take by them. A node of its own, so that the aligning stays frame by frame.

use crate::rig::frame_number;
use crate::values::Anchors;
use face_math::data::{AnchorPose, Attachment, Curves, Markers, Rig, TakeEdits, nearest_name};
use face_math::rig::{MarkerPose, MarkerRig};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const MARKERS: Port<Markers> = Port::new("markers", "the take, in metres");
const RIG: Port<Rig> = Port::new("rig", "the puppet");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where the markers sit on it");
const CURVES: Port<Curves> = Port::new(
    "curves",
    "weights of the take, solved or edited: at each anchor they stand for the channels that its `weights` leave out",
);
const FOUND: Port<Anchors> = Port::new(
    "found",
    "anchors for a take for which none are given here (`find_anchor`); without it, that is an error",
);
const EDITS: Port<TakeEdits> =
    Port::new("edits", "the take's edits: where they name anchors, these go before those of the parameters");
const ANCHORS: Port<Anchors> = Port::new("anchors", "the take's and the puppet's markers at each anchor");

/// Takes frames of a take at which the puppet's pose is known: x and g(w) of Eq. 5 of FDLS at each.
///
/// The first anchor should be a neutral frame, or nearly: it corrects all frames alike. Each further one corrects the frames
/// that look like it. Where takes come one after the other, each has its own in `by_take`; a take for which none are given has
/// those of `found`. Without `curves`, channels that an anchor does not name are 0: an empty list of weights says that the
/// face is at rest there.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SetAnchors {
    /// The anchors, in the order in which they apply.
    anchors: Vec<Anchor>,
    /// The anchors of certain takes, by the name of the take, in place of `anchors`:
    /// `{"day2_167": [(frame: 52), (frame: 700, weights: {"jawOpen": 0.3})]}`.
    by_take: BTreeMap<String, Vec<Anchor>>,
    /// The name of this take, for `by_take`: `{take}`.
    take: String,
}

/// An anchor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Anchor {
    /// Number of the frame, as the take counts it.
    frame: i64,
    /// Weights at which the puppet looks like the take in that frame, by channel: `{"jawOpen": 0.3}`.
    #[serde(default)]
    weights: BTreeMap<String, f64>,
}

graph_core::register!(SetAnchors);

#[typetag::serde(name = "set_anchors")]
impl Node for SetAnchors {
    fn card(&self) -> Card {
        Card::new("solve")
            .takes(&MARKERS)
            .takes(&RIG)
            .takes(&ATTACHMENT)
            .may_take(&CURVES)
            .may_take(&FOUND)
            .may_take(&EDITS)
            .gives(&ANCHORS)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let take = inputs.get(&MARKERS)?;
        let curves = inputs.may_get(&CURVES)?;
        let set = inputs.may_get(&EDITS)?.map(|edits| edits.anchors.iter().map(Anchor::of).collect::<Vec<_>>());
        let set = set.filter(|anchors| !anchors.is_empty());
        let chosen = match &set {
            Some(anchors) => anchors.as_slice(),
            None => self.chosen()?,
        };
        if chosen.is_empty() {
            if let Some(found) = inputs.may_get(&FOUND)? {
                return Ok(Outputs::default().with(&ANCHORS, found.clone()));
            }
            let problem = "there is no anchor; give at least one: a frame, and the weights that match it";
            return Err(NodeError::parameter("anchors", problem));
        }
        if let Some(curves) = curves {
            take.frame_axis().matches(&curves.frame_axis()).map_err(|error| NodeError::input(CURVES.name(), error))?;
        }
        let puppet = MarkerRig::attached(inputs.get(&RIG)?, inputs.get(&ATTACHMENT)?)
            .map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let (mut captured, mut posed) = (Vec::new(), Vec::new());
        let mut pose = MarkerPose::default();
        for anchor in chosen {
            let place = place(take, anchor.frame)?;
            captured.extend_from_slice(take.frame(place));
            puppet.pose(&weights(anchor, &puppet, curves, place)?, &mut pose);
            posed.extend(pose.positions().iter().map(|position| position.as_vec3()));
        }
        let axis = Anchors::axis(chosen.len());
        let captured = Markers::new(axis, take.names().to_vec(), captured).map_err(NodeError::failed)?;
        let posed = Markers::new(axis, puppet.names().to_vec(), posed).map_err(NodeError::failed)?;
        let frames = chosen.iter().map(|anchor| anchor.frame).collect();
        let anchors = Anchors::new(frames, captured, posed).map_err(NodeError::failed)?;
        if let Some(blind) = (0..chosen.len()).find(|anchor| anchors.offsets(*anchor).is_empty()) {
            let frame = chosen[blind].frame;
            let problem = format!("frame {frame} shows no marker of the puppet; choose a frame in which they are seen");
            return Err(NodeError::parameter("anchors", problem));
        }
        Ok(Outputs::default().with(&ANCHORS, anchors))
    }
}

impl Anchor {
    fn of(pose: &AnchorPose) -> Self {
        Self { frame: pose.frame, weights: pose.weights.clone() }
    }
}

impl SetAnchors {
    /// The anchors of this take.
    fn chosen(&self) -> Result<&[Anchor], NodeError> {
        if !self.by_take.is_empty() && self.take.is_empty() {
            let problem = "name this take, so that its anchors can be told from those of others: \"{take}\"";
            return Err(NodeError::parameter("take", problem));
        }
        Ok(self.by_take.get(&self.take).unwrap_or(&self.anchors))
    }
}

/// Position of the frame that the take numbers `frame`.
fn place(take: &Markers, frame: i64) -> Result<usize, NodeError> {
    let axis = take.frame_axis();
    let place =
        frame.checked_sub(axis.first).and_then(|place| usize::try_from(place).ok()).filter(|place| *place < axis.count);
    place.ok_or_else(|| {
        let last = frame_number(axis, axis.count) - 1;
        NodeError::parameter("anchors", format!("there is no frame {frame}; the take holds {} to {last}", axis.first))
    })
}

/// Weights of all channels at an anchor.
fn weights(anchor: &Anchor, puppet: &MarkerRig, curves: Option<&Curves>, place: usize) -> Result<Vec<f64>, NodeError> {
    let channels = puppet.channels();
    for (channel, weight) in &anchor.weights {
        if !channels.contains(channel) {
            let near = nearest_name(channel, channels.iter().map(String::as_str));
            let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            let problem = format!("frame {}: the rig has no channel `{channel}`{near}", anchor.frame);
            return Err(NodeError::parameter("anchors", problem));
        }
        if !weight.is_finite() {
            let problem = format!("frame {}: the weight of `{channel}` is {weight}; give a number", anchor.frame);
            return Err(NodeError::parameter("anchors", problem));
        }
    }
    let mut weights = vec![0.0; channels.len()];
    if let Some(curves) = curves {
        for (weight, channel) in weights.iter_mut().zip(channels) {
            if let Some(column) = curves.index(channel) {
                *weight = f64::from(curves.frame(place)[column]);
            }
        }
        if let Some(channel) = weights.iter().position(|weight| !weight.is_finite()) {
            let problem = format!("channel `{}` is not a number in frame {}", channels[channel], anchor.frame);
            return Err(NodeError::input(CURVES.name(), problem));
        }
    }
    for (weight, channel) in weights.iter_mut().zip(channels) {
        *weight = anchor.weights.get(channel).copied().unwrap_or(*weight);
    }
    Ok(weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use glam::Vec3;
    use serde_json::json;

    fn puppet() -> MarkerRig {
        MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap()
    }

    /// The toy's markers, all moved by 1 mm along x.
    fn take(curves: &Curves) -> Markers {
        let exact = puppet().drive(curves).unwrap();
        exact.with_positions(exact.positions().iter().map(|point| *point + Vec3::X * 0.001).collect()).unwrap()
    }

    fn set(parameters: serde_json::Value, take: Markers, curves: Option<Curves>) -> Result<Anchors, String> {
        let node: SetAnchors = made(parameters);
        let inputs = Inputs::default().with(&MARKERS, take).with(&RIG, toy::rig()).with(&ATTACHMENT, toy::attachment());
        let inputs = match curves {
            Some(curves) => inputs.with(&CURVES, curves),
            None => inputs,
        };
        let outputs = compute(&node, &inputs);
        outputs.map(|outputs| outputs.get(&ANCHORS).unwrap().clone()).map_err(|error| error.to_string())
    }

    fn close(anchors: &Anchors, anchor: usize) -> bool {
        let offsets = anchors.offsets(anchor);
        offsets.len() == 12 && offsets.iter().all(|(_, offset)| offset.abs_diff_eq(Vec3::X * 0.001, 1e-6))
    }

    #[test]
    fn offsets_are_those_of_the_take_from_the_puppet() {
        let curves = toy::curves(6, 1);
        let weights: BTreeMap<_, _> = curves.channels().iter().zip(curves.frame(2)).collect();
        let anchors = set(json!({"anchors": [{"frame": 103, "weights": weights}]}), take(&curves), None).unwrap();
        assert_eq!(anchors.frames(), [103]);
        assert!(close(&anchors, 0), "{:?}", anchors.offsets(0));
        let rest = set(json!({"anchors": [{"frame": 103}]}), take(&curves), None).unwrap();
        for (own, rest) in rest.puppet().frame(0).iter().zip(toy::neutral().frame(0)) {
            assert!(own.abs_diff_eq(*rest, 1e-6));
        }
    }

    #[test]
    fn curves_stand_for_what_an_anchor_leaves_out() {
        let curves = toy::curves(6, 2);
        let with = json!({"anchors": [{"frame": 101}, {"frame": 105, "weights": {"browUp": 0.0}}]});
        let anchors = set(with, take(&curves), Some(curves.clone())).unwrap();
        assert!(close(&anchors, 0) && !close(&anchors, 1));
    }

    #[test]
    fn each_take_has_its_own_and_others_what_was_found() {
        let curves = toy::curves(6, 4);
        let one = set(json!({"anchors": [{"frame": 101}]}), take(&curves), None).unwrap();
        let node: SetAnchors = made(json!({"by_take": {"b": [{"frame": 104}]}, "take": "a"}));
        let inputs = || {
            Inputs::default()
                .with(&MARKERS, take(&curves))
                .with(&RIG, toy::rig())
                .with(&ATTACHMENT, toy::attachment())
                .with(&FOUND, one.clone())
        };
        assert_eq!(compute(&node, &inputs()).unwrap().get(&ANCHORS).unwrap(), &one);
        let node = SetAnchors { take: "b".into(), ..node };
        assert_eq!(compute(&node, &inputs()).unwrap().get(&ANCHORS).unwrap().frames(), [104]);
    }

    #[test]
    fn mistakes_are_named() {
        let curves = toy::curves(6, 3);
        let fault = |parameters: serde_json::Value| set(parameters, take(&curves), None).unwrap_err();
        assert!(fault(json!({})).contains("there is no anchor"));
        assert!(fault(json!({"anchors": [{"frame": 107}]})).contains("the take holds 101 to 106"));
        let error = fault(json!({"anchors": [{"frame": 101, "weights": {"browUpp": 0.5}}]}));
        assert!(error.contains("did you mean `browUp`?"), "{error}");
        let by_take = json!({"by_take": {"other": [{"frame": 101}]}, "take": "this"});
        assert!(fault(by_take).contains("there is no anchor"));
        assert!(fault(json!({"by_take": {"other": [{"frame": 101}]}})).contains("`take`"));
        let gone = take(&curves).with_positions(vec![Vec3::NAN; 72]).unwrap();
        let error = set(json!({"anchors": [{"frame": 101}]}), gone, None).unwrap_err();
        assert!(error.contains("frame 101 shows no marker"), "{error}");
    }
}
