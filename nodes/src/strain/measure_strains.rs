//! `measure_strains`: how much longer each muscle is than at rest, in every frame of animated meshes.

use face_math::data::{Curves, Meshes, Muscles};
use face_math::strain::measure_strains;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MUSCLES: Port<Muscles> = Port::new("muscles", "muscle fibres of the head (`trace_muscles`)");
const MESHES: Port<Meshes> = Port::new("meshes", "animated meshes of the same head, in metres; all its vertices");
const STRAINS: Port<Curves> = Port::new(
    "strains",
    "length over rest length, less 1, of every fibre; exactly 0 at rest, 0.1 where it is a tenth longer",
);

/// Measures the strain of every muscle fibre: its length over its length at rest, less 1.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeasureStrains {}

graph_core::register!(MeasureStrains);

#[typetag::serde(name = "measure_strains")]
impl Node for MeasureStrains {
    fn card(&self) -> Card {
        Card::new("strain").takes(&MUSCLES).takes(&MESHES).gives(&STRAINS).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let strains = measure_strains(inputs.get(&MUSCLES)?, inputs.get(&MESHES)?);
        Ok(Outputs::default().with(&STRAINS, strains.map_err(|error| NodeError::input(MESHES.name(), error))?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::compute;
    use face_math::data::{MuscleCurve, RidingPoint};

    #[test]
    fn rest_is_nought_and_other_heads_are_refused() {
        let rig = &toy::ACTOR;
        let triangle = rig.parts[0].triangles[40];
        let point = |weights| RidingPoint { vertices: triangle, weights };
        let points = vec![point([1.0, 0.0, 0.0]), point([0.0, 0.5, 0.5])];
        let mut curve = MuscleCurve { name: "m".into(), points, rest_length_m: 1.0 };
        curve.rest_length_m = curve.length_m(&rig.neutral);
        let muscles = Muscles::new(vec![curve], rig.neutral.len()).unwrap();
        let rest = toy::motion(600);
        let still = Curves::new(rest.frame_axis(), rest.channels().to_vec(), vec![0.0; rest.values().len()]).unwrap();
        let inputs = Inputs::default().with(&MUSCLES, muscles).with(&MESHES, toy::evaluated(rig, &still));
        let outputs = compute(&MeasureStrains {}, &inputs).unwrap();
        assert_eq!(outputs.get(&STRAINS).unwrap().values(), [0.0]);
        let few = Meshes::new(rest.frame_axis(), Vec::new(), 1, vec![glam::Vec3::ZERO]).unwrap();
        let error = compute(&MeasureStrains {}, &inputs.with(&MESHES, few)).unwrap_err().to_string();
        assert!(error.contains("vertices of the meshes: 1 where"), "{error}");
    }
}
