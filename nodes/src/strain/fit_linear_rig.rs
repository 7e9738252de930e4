//! `fit_linear_rig`: a plain blendshape rig fitted to animated meshes; what strain rigs are measured against.

use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::{StrainError, fit_linear_rig};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a head, of which the neutral surface counts");
const MESHES: Port<Meshes> = Port::new("meshes", "its animated meshes, in metres");
const CURVES: Port<Curves> = Port::new("curves", "weights of the channels in the same frames");
const LINEAR: Port<Rig> = Port::new("rig", "the head with one shape a channel, without joints or correctives");

/// Fits one shape a channel to animated meshes by least squares: the best linear rig of those channels.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FitLinearRig {}

graph_core::register!(FitLinearRig);

#[typetag::serde(name = "fit_linear_rig")]
impl Node for FitLinearRig {
    fn card(&self) -> Card {
        Card::new("strain").version(2).takes(&RIG).takes(&MESHES).takes(&CURVES).gives(&LINEAR)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let rig = fit_linear_rig(inputs.get(&RIG)?, inputs.get(&MESHES)?, inputs.get(&CURVES)?);
        let rig = rig.map_err(|error| match error {
            StrainError::NotFinite { what: "channel", .. } | StrainError::Data(_) => {
                NodeError::input(CURVES.name(), error)
            }
            _ => NodeError::input(MESHES.name(), error),
        })?;
        Ok(Outputs::default().with(&LINEAR, rig))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::compute;

    #[test]
    fn it_has_the_channels_and_comes_near() {
        let curves = toy::motion(6);
        let meshes = toy::evaluated(&toy::ACTOR, &curves);
        let inputs = Inputs::default()
            .with(&RIG, toy::ACTOR.clone())
            .with(&MESHES, meshes.clone())
            .with(&CURVES, curves.clone());
        let outputs = compute(&FitLinearRig {}, &inputs).unwrap();
        let linear = outputs.get(&LINEAR).unwrap();
        assert_eq!(linear.channels, toy::ACTOR.channels);
        let own = toy::evaluated(linear, &curves);
        let far: f64 = own.positions().iter().zip(meshes.positions()).map(|(a, b)| f64::from(a.distance(*b))).sum();
        assert!(far / (meshes.positions().len() as f64) < 3e-4);
    }
}
