//! `join_shapes`: heads with one shape each, as a folder of sculpts gives them, put together into one rig.

use face_math::data::Rig;
use face_math::rig::{Sculpts, join_shapes};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const HEADS: Port<Rig> = Port::new("heads", "heads of one neutral face, each with some of the shapes");
const RIG: Port<Rig> = Port::new("rig", "one head with all the shapes, in the order of the items' names");

/// What files of combinations and in-betweens show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Shown {
    /// The whole face at those weights, as it was sculpted: `a+b` with both channels at 1, `a@0.5` with `a` at 0.5.
    #[default]
    Whole,
    /// The neutral face plus the corrective alone, as programs extract it.
    Offsets,
}

/// Joins heads of one neutral face into one rig.
///
/// A folder of OBJ files becomes a rig so: `load_rig` with a pattern and `neutral` gives a head with one shape for each
/// file, and this node puts them together. An edited file then costs that file and the joining, nothing else. What
/// shapes mean is read off their names over all heads: `a+b` is a combination, `a@0.5` an in-between, every other one
/// a channel. Heads with several shapes may be joined too, such as a GLB with its missing shapes as OBJ files.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct JoinShapes {
    /// Name of the rig in messages and in files written from it.
    name: String,
    /// What the files of combinations and in-betweens show.
    correctives: Shown,
}

impl Default for JoinShapes {
    fn default() -> Self {
        Self { name: "head".to_owned(), correctives: Shown::Whole }
    }
}

graph_core::register!(JoinShapes);

#[typetag::serde(name = "join_shapes")]
impl Node for JoinShapes {
    fn card(&self) -> Card {
        Card::new("rig").gathers(&HEADS).gives(&RIG)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let sculpts = match self.correctives {
            Shown::Whole => Sculpts::Whole,
            Shown::Offsets => Sculpts::Offsets,
        };
        let rig = join_shapes(&inputs.items(&HEADS)?, &self.name, sculpts);
        let rig = rig.map_err(|error| NodeError::input(HEADS.name(), error))?;
        if rig.shapes.is_empty() {
            let problem = "no head has a shape; load the files of shapes along with the neutral one";
            return Err(NodeError::input(HEADS.name(), problem));
        }
        Ok(Outputs::default().with(&RIG, rig))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{HEAD, compute, made};
    use serde_json::json;

    /// The procedural head in pieces: its neutral face, and one head for each of some shapes.
    fn pieces() -> Vec<(String, Rig)> {
        let with = |shapes: &[usize]| {
            let mut rig = HEAD.rig.clone();
            rig.shapes = shapes.iter().map(|shape| HEAD.rig.shapes[*shape].clone()).collect();
            rig.channels = HEAD.rig.channels.clone();
            rig
        };
        let singles = (0..HEAD.rig.shapes.len()).map(|shape| (HEAD.rig.shapes[shape].name.clone(), with(&[shape])));
        std::iter::once(("neutral".to_owned(), with(&[]))).chain(singles).collect()
    }

    fn joined(parameters: serde_json::Value, heads: Vec<(String, Rig)>) -> Result<Rig, String> {
        let node: JoinShapes = made(parameters);
        let outputs = compute(&node, &Inputs::default().with_list(&HEADS, heads)).map_err(|error| error.to_string())?;
        Ok(outputs.get(&RIG).unwrap().clone())
    }

    #[test]
    fn a_head_in_pieces_is_put_together_again() {
        let rig = joined(json!({"name": "anna"}), pieces()).unwrap();
        assert!(rig.name == "anna" && rig.neutral == HEAD.rig.neutral && rig.skin == HEAD.rig.skin);
        assert!(rig.channels.is_sorted() && rig.channels.len() == HEAD.rig.channels.len());
        for shape in &HEAD.rig.shapes {
            let same = rig.shapes.iter().find(|same| same.name == shape.name).unwrap();
            assert!((&same.vertices, &same.deltas) == (&shape.vertices, &shape.deltas), "{}", shape.name);
        }
    }

    #[test]
    fn pieces_of_other_heads_and_nothing_are_refused() {
        let mut heads = pieces();
        heads[1].1.neutral.pop();
        let error = joined(json!({}), heads).unwrap_err();
        assert!(error.starts_with("input `heads`: ") && error.contains("vertices, but `browDown_L` has"), "{error}");
        let error = joined(json!({"correctives": "offsets"}), pieces()[..1].to_vec()).unwrap_err();
        assert!(error.contains("no head has a shape"), "{error}");
    }
}
