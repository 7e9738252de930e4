//! `merge_curves`: curves of different channels side by side; where poses and strains become the curves of one rig.

use face_math::data::Curves;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const CURVES: Port<Curves> = Port::new("curves", "curves of the same frames and of different channels");
const MERGED: Port<Curves> = Port::new("curves", "the channels of all, one after the other");

/// Lays curves of the same frames side by side. No two may have a channel of the same name.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MergeCurves {}

graph_core::register!(MergeCurves);

#[typetag::serde(name = "merge_curves")]
impl Node for MergeCurves {
    fn card(&self) -> Card {
        Card::new("rig").gathers(&CURVES).gives(&MERGED).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let all = inputs.items(&CURVES)?;
        let wrong = |problem: String| NodeError::input(CURVES.name(), problem);
        let (first, curves) = all.first().ok_or_else(|| wrong("there are no curves to merge".to_owned()))?;
        let axis = curves.frame_axis();
        for (item, other) in &all {
            if other.frames() != axis.count {
                let problem = format!("{} frames of `{item}` beside {} of `{first}`", other.frames(), axis.count);
                return Err(wrong(problem));
            }
        }
        let channels = all.iter().flat_map(|(_, curves)| curves.channels()).cloned().collect();
        let values = (0..axis.count).flat_map(|frame| all.iter().flat_map(move |(_, curves)| curves.frame(frame)));
        let merged =
            Curves::new(axis, channels, values.copied().collect()).map_err(|error| wrong(error.to_string()))?;
        Ok(Outputs::default().with(&MERGED, merged))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::compute;

    #[test]
    fn channels_stand_side_by_side() {
        let curves = toy::curves(5, 1);
        let halves =
            [&curves.channels()[..1], &curves.channels()[1..]].map(|names| curves.arrange(names, None).unwrap());
        let [a, b] = halves;
        let merge = |list: Vec<(String, Curves)>| {
            let outputs = compute(&MergeCurves {}, &Inputs::default().with_list(&CURVES, list));
            outputs.map(|outputs| outputs.get(&MERGED).unwrap().clone()).map_err(|error| error.to_string())
        };
        assert_eq!(merge(vec![("a".into(), a.clone()), ("b".into(), b)]).unwrap(), curves);
        assert!(merge(vec![("a".into(), a.clone()), ("b".into(), a.clone())]).unwrap_err().contains("stands twice"));
        assert!(merge(vec![("a".into(), a), ("b".into(), toy::curves(4, 1))]).unwrap_err().contains("4 frames of `b`"));
    }
}
