//! `keep_parts`: some parts of a head as a head of their own; before whatever needs the skin alone.

use crate::patterns::Patterns;
use face_math::data::{Attachment, Part, Rig};
use face_math::rig::{keep_parts, keep_points};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a head of several parts");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "points on the head: markers, or landmarks");
const KEPT: Port<Rig> = Port::new("rig", "the same head with the chosen parts alone, its vertices counted anew");
const POINTS: Port<Attachment> =
    Port::new("attachment", "the points that lie on the chosen parts; none where no points were given");

/// Keeps some parts of a head. Channels and shapes stay, also those that move nothing any more.
///
/// Meshes of `evaluate_rig` with these parts have the vertices of this head.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct KeepParts {
    /// Parts to keep, as patterns: `face`, `teeth_*`. All where empty.
    parts: Vec<String>,
}

graph_core::register!(KeepParts);

#[typetag::serde(name = "keep_parts")]
impl Node for KeepParts {
    fn card(&self) -> Card {
        Card::new("rig").takes(&RIG).may_take(&ATTACHMENT).gives(&KEPT).gives(&POINTS)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let rig = inputs.get(&RIG)?;
        let names: Vec<String> = rig.parts.iter().map(|part| part.name.clone()).collect();
        let chosen = Patterns { parameter: "parts", what: "part", names: &names }.chosen(&self.parts)?;
        let keep = |part: &Part| chosen.contains(&part.name);
        let points = inputs.may_get(&ATTACHMENT)?.map(|attachment| keep_points(rig, attachment, keep));
        let kept = keep_parts(rig, keep).checked().map_err(NodeError::failed)?;
        let points = points.unwrap_or(Attachment { points: Vec::new() });
        Ok(Outputs::default().with(&KEPT, kept).with(&POINTS, points))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{HEAD, compute, made};
    use serde_json::json;

    #[test]
    fn the_face_alone_is_a_rig() {
        let keep = |parts: serde_json::Value| {
            let node: KeepParts = made(json!({ "parts": parts }));
            compute(&node, &Inputs::default().with(&RIG, HEAD.rig.clone()))
        };
        let outputs = keep(json!(["face", "eyeball_*"])).unwrap();
        let kept = outputs.get(&KEPT).unwrap();
        let names: Vec<&str> = kept.parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, ["face", "eyeball_L", "eyeball_R"]);
        assert_eq!(kept.neutral.len(), kept.parts.iter().map(|part| part.vertices.len()).sum::<usize>());
        assert!(outputs.get(&POINTS).unwrap().points.is_empty());
        assert!(keep(json!(["fase"])).unwrap_err().to_string().contains("did you mean `face`?"));
    }
}
