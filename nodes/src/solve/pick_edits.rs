//! `pick_edits`: the edits of one take out of all. A node of its own, so that a key of one take cooks that take alone.

use face_math::data::{Edits, TakeEdits};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const EDITS: Port<Edits> = Port::new("edits", "the edits of all takes; without it, there are none");
const OWN: Port<TakeEdits> = Port::new("edits", "the edits of this take, none where it is not named");

/// Takes the edits of one take.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PickEdits {
    /// The name of the take: `{take}`.
    take: String,
}

graph_core::register!(PickEdits);

#[typetag::serde(name = "pick_edits")]
impl Node for PickEdits {
    fn card(&self) -> Card {
        Card::new("solve").may_take(&EDITS).gives(&OWN)
    }

    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        if self.take.is_empty() {
            let problem = "name the take whose edits are wanted: \"{take}\"";
            return Err(NodeError::parameter("take", problem));
        }
        let own = inputs.may_get(&EDITS)?.and_then(|edits| edits.takes.get(&self.take));
        Ok(Outputs::default().with(&OWN, own.cloned().unwrap_or_default()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use face_math::data::AnchorPose;
    use serde_json::json;

    #[test]
    fn a_take_has_its_own_edits_and_others_none() {
        let anchor = AnchorPose { frame: 3, weights: [("jawOpen".to_owned(), 0.5)].into() };
        let own = TakeEdits { anchors: vec![anchor], ..TakeEdits::default() };
        let edits = Edits { takes: [("a".to_owned(), own.clone())].into() };
        let of = |take: &str| {
            let node: PickEdits = made(json!({ "take": take }));
            let outputs = compute(&node, &Inputs::default().with(&EDITS, edits.clone()));
            outputs.map(|outputs| outputs.get(&OWN).unwrap().clone()).map_err(|error| error.to_string())
        };
        assert_eq!(of("a").unwrap(), own);
        assert_eq!(of("b").unwrap(), TakeEdits::default());
        assert!(of("").unwrap_err().contains("{take}"));
    }
}
