//! `keep_frames`: a few frames of a take, the others blank; before a node that looks at a few frames all over the take.

use face_math::data::Markers;
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "a take, in metres");
const KEPT: Port<Markers> = Port::new("markers", "the same frames, of which all but a few hold no marker");

/// Keeps frames spread evenly over a take, and blanks the others.
///
/// A node behind this one is not made anew when a frame changes that it does not look at.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct KeepFrames {
    /// How many frames are kept: the middle one of each of so many equal parts of the take. All, where the take is shorter.
    #[schemars(range(min = 1, max = 1_000_000))]
    frames: usize,
}

impl Default for KeepFrames {
    fn default() -> Self {
        Self { frames: 32 }
    }
}

graph_core::register!(KeepFrames);

#[typetag::serde(name = "keep_frames")]
impl Node for KeepFrames {
    fn card(&self) -> Card {
        Card::new("clean").takes(&MARKERS).gives(&KEPT)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let take = inputs.get(&MARKERS)?;
        let mut positions = vec![Vec3::NAN; take.positions().len()];
        let width = take.names().len();
        for frame in face_math::solve::spread_frames(take.frames(), self.frames) {
            positions[frame * width..(frame + 1) * width].copy_from_slice(take.frame(frame));
        }
        let kept = take.with_positions(positions).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&KEPT, kept))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use serde_json::json;
    use wire::FrameAxis;

    fn keep(frames: usize, of: usize) -> Vec<usize> {
        let positions = (0..2 * of).map(|point| Vec3::splat(point as f32)).collect();
        let take = Markers::new(FrameAxis::new(of, 60.0), vec!["a".into(), "b".into()], positions).unwrap();
        let node: KeepFrames = made(json!({ "frames": frames }));
        let outputs = compute(&node, &Inputs::default().with(&MARKERS, take.clone())).unwrap();
        let kept = outputs.get(&KEPT).unwrap();
        assert_eq!(kept.frame_axis(), take.frame_axis());
        let whole = |frame: &usize| kept.frame(*frame).iter().all(|point| point.is_finite());
        let frames: Vec<usize> = (0..of).filter(whole).collect();
        assert!(frames.iter().all(|frame| kept.frame(*frame) == take.frame(*frame)));
        frames
    }

    #[test]
    fn frames_are_spread_over_the_take() {
        assert_eq!(keep(1, 9), [4]);
        assert_eq!(keep(3, 9), [1, 4, 7]);
        assert_eq!(keep(4, 10), [1, 3, 6, 8]);
        assert_eq!(keep(20, 5), [0, 1, 2, 3, 4]);
    }
}
