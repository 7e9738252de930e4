//! `learn_shape_space`: the shapes that a face's markers take, from frames in which all are seen; what `fill_gaps` tells lost
//! markers by.

use crate::patterns::Patterns;
use face_math::clean::{ShapeError, learn_shapes};
use face_math::data::{Markers, ShapeSpace};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new(
    "markers",
    "what to learn from, in metres: training markers (`synthesize_markers`), or takes; frames with gaps are passed over",
);
const SPACE: Port<ShapeSpace> = Port::new("space", "the mean face and its modes, the head's motion taken out");

/// Learns how a face's markers move together: principal components of the frames in which all of them are seen.
///
/// The head's motion is taken out of each frame first. Learn from the markers of the training motion, which show all that
/// a face does and never change, or from takes themselves, which fit best; then a new or edited take is learned anew.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LearnShapeSpace {
    /// Markers to learn, as patterns; those that all inputs have where empty.
    only: Vec<String>,
    /// Markers to leave out, as patterns: such as are seldom seen.
    without: Vec<String>,
    /// Number of modes at most. More follow the training closely, and faces that it does not show less well.
    #[schemars(range(min = 1, max = 1000))]
    modes: usize,
}

impl Default for LearnShapeSpace {
    fn default() -> Self {
        Self { only: Vec::new(), without: Vec::new(), modes: 12 }
    }
}

graph_core::register!(LearnShapeSpace);

#[typetag::serde(name = "learn_shape_space")]
impl Node for LearnShapeSpace {
    fn card(&self) -> Card {
        Card::new("clean").gathers(&MARKERS).gives(&SPACE)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let takes: Vec<&Markers> = inputs.items(&MARKERS)?.into_iter().map(|(_, take)| take).collect();
        let first = takes.first().ok_or_else(|| NodeError::input(MARKERS.name(), "there is nothing to learn from"))?;
        let shared = |name: &&String| takes.iter().all(|take| take.index(name).is_some());
        let names: Vec<String> = first.names().iter().filter(shared).cloned().collect();
        let patterns = |parameter| Patterns { parameter, what: "marker", names: &names };
        let mut kept = patterns("only").chosen(&self.only)?;
        let left_out = patterns("without").fits(&self.without)?;
        kept.retain(|name| names.iter().position(|own| own == name).is_some_and(|place| !left_out[place]));
        let space = learn_shapes(&takes, &kept, self.modes);
        let space = space.map_err(|error: ShapeError| NodeError::input(MARKERS.name(), error))?;
        Ok(Outputs::default().with(&SPACE, space))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use face_math::rig::MarkerRig;
    use serde_json::json;

    fn learn(parameters: serde_json::Value, takes: &[Markers]) -> Result<ShapeSpace, String> {
        let node: LearnShapeSpace = made(parameters);
        let items = takes.iter().enumerate().map(|(index, take)| (format!("take{index}"), take.clone()));
        let outputs = compute(&node, &Inputs::default().with_list(&MARKERS, items));
        outputs.map(|outputs| outputs.get(&SPACE).unwrap().clone()).map_err(|error| error.to_string())
    }

    fn take(frames: usize) -> Markers {
        MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap().drive(&toy::curves(frames, 3)).unwrap()
    }

    #[test]
    fn markers_that_all_takes_have_are_learned() {
        let fewer = take(60).pick(&take(1).names()[..9]).unwrap();
        let space = learn(json!({"modes": 4}), &[take(60), fewer]).unwrap();
        assert_eq!((space.markers().len(), space.spreads_m().len()), (9, 4));
        let some = learn(json!({"without": ["m1*"]}), &[take(60)]).unwrap();
        assert_eq!(some.markers().len(), 9);
    }

    #[test]
    fn mistakes_are_named() {
        assert!(learn(json!({}), &[]).unwrap_err().contains("nothing to learn from"));
        assert!(learn(json!({}), &[take(5)]).unwrap_err().contains("5 frames show all 12 markers"));
        assert!(learn(json!({"only": ["x*"]}), &[take(30)]).unwrap_err().contains("`only`"));
    }
}
