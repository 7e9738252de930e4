//! `evaluate_rig`: the posed surface of a head, frame by frame; between curves and everything that shows or saves meshes.

use crate::patterns::Patterns;
use face_math::data::{Curves, Meshes, Part, Rig};
use face_math::rig::{Puppet, renumbered};
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "the head to pose, in metres");
const CURVES: Port<Curves> =
    Port::new("curves", "weights of every channel of the rig, one value a frame; other channels are passed over");
const MESHES: Port<Meshes> = Port::new("meshes", "the posed vertices of each frame, in metres");

/// Poses a rig by animation curves and gives the mesh of every frame.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EvaluateRig {
    /// Parts to give, as patterns: `face`, `teeth_*`. All parts where empty.
    parts: Vec<String>,
}

graph_core::register!(EvaluateRig);

#[typetag::serde(name = "evaluate_rig")]
impl Node for EvaluateRig {
    fn card(&self) -> Card {
        Card::new("rig").takes(&RIG).takes(&CURVES).gives(&MESHES).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let rig = inputs.get(&RIG)?;
        let curves = inputs.get(&CURVES)?;
        let wrong = |error: &dyn std::fmt::Display| NodeError::input(CURVES.name(), error);
        let puppet = Puppet::new(rig).map_err(|error| NodeError::input(RIG.name(), error))?;
        let arranged = curves.arrange(&rig.channels, None).map_err(|error| wrong(&error))?;
        super::check_finite(CURVES.name(), &arranged)?;
        let parts = self.parts(rig)?;
        let kept: usize = parts.iter().map(|part| part.vertices.len()).sum();
        let axis = curves.frame_axis();
        let mut positions: Vec<Vec3> = Vec::with_capacity(axis.count * kept);
        let mut posed = Vec::new();
        for frame in 0..axis.count {
            context.go_on()?;
            puppet.vertices_into(arranged.frame(frame), &mut posed).map_err(|error| wrong(&error))?;
            for part in &parts {
                positions.extend_from_slice(&posed[part.vertices.start as usize..part.vertices.end as usize]);
            }
        }
        let meshes = Meshes::new(axis, renumbered(parts), kept, positions).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&MESHES, meshes))
    }
}

impl EvaluateRig {
    fn parts(&self, rig: &Rig) -> Result<Vec<Part>, NodeError> {
        let names: Vec<String> = rig.parts.iter().map(|part| part.name.clone()).collect();
        let chosen = Patterns { parameter: "parts", what: "part", names: &names }.chosen(&self.parts)?;
        Ok(rig.parts.iter().filter(|part| chosen.contains(&part.name)).cloned().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    /// The toy with a second part before the face.
    fn rig() -> Rig {
        let mut rig = toy::rig();
        let face = rig.parts.remove(0);
        rig.parts.push(Part { name: "hat".into(), vertices: 0..10, triangles: vec![[0, 1, 9]], ..face.clone() });
        let triangles = face.triangles.iter().copied().filter(|t| t.iter().all(|v| *v >= 10)).collect();
        rig.parts.push(Part { vertices: 10..25, triangles, ..face });
        rig
    }

    fn evaluate(parameters: serde_json::Value, curves: Curves) -> Result<Meshes, String> {
        let node: EvaluateRig = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&RIG, rig()).with(&CURVES, curves));
        outputs.map(|outputs| outputs.get(&MESHES).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn each_frame_is_the_puppet_at_its_weights() {
        let (rig, curves) = (rig(), toy::curves(3, 1));
        let meshes = evaluate(json!({}), curves.clone()).unwrap();
        let expected = Puppet::new(&rig).unwrap().vertices(curves.frame(2)).unwrap();
        assert_eq!(meshes.frame(2), expected);
        assert_eq!(meshes.frame_axis(), curves.frame_axis());
        let face = evaluate(json!({"parts": ["face"]}), curves).unwrap();
        assert_eq!(face.frame(2), &expected[10..]);
        assert_eq!(face.parts().len(), 1);
        assert_eq!(face.part("face").unwrap().vertices, 0..15);
        let (own, whole) = (&face.parts()[0].triangles, &rig.parts[1].triangles);
        assert!(own.iter().flatten().zip(whole.iter().flatten()).all(|(own, whole)| own + 10 == *whole));
    }

    #[test]
    fn blocks_equal_the_whole() {
        let curves = toy::curves(7, 2);
        let block = evaluate(json!({}), toy::cut(&curves, 2..5)).unwrap();
        assert!(toy::same_bits(&evaluate(json!({}), curves).unwrap(), 2..5, &block));
    }

    #[test]
    fn missing_channels_and_values_are_named() {
        let curves = toy::curves(2, 3);
        let some = curves.arrange(&curves.channels()[1..], None).unwrap();
        assert!(evaluate(json!({}), some).unwrap_err().contains("jawOpen"));
        let mut values = curves.values().to_vec();
        values[5] = f32::NAN;
        let broken = Curves::new(curves.frame_axis(), curves.channels().to_vec(), values).unwrap();
        let error = evaluate(json!({}), broken).unwrap_err();
        assert!(error.contains("`smile_L` is NaN in frame 102"), "{error}");
        assert!(evaluate(json!({"parts": ["hut"]}), curves).unwrap_err().contains("did you mean `hat`?"));
    }
}
