//! `train_strain_autoencoder`: the manifold of plausible strains, learned from a strain rig's training (A.4 of Animatomy).

use crate::patterns::Patterns;
use crate::values::StrainAutoencoder;
use face_math::data::Curves;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use learn::{AutoencoderTraining, Matrix, TrainError, train_autoencoder};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const STRAINS: Port<Curves> = Port::new("strains", "refined strains of the training meshes (`fit_strain_shapes`)");
const POSES: Port<Curves> = Port::new("poses", "the poses of the joints in the same frames");
const AUTOENCODER: Port<StrainAutoencoder> =
    Port::new("autoencoder", "gives plausible strains back as they are, and others as the nearest that it knows");

/// Trains an autoencoder of strains under the jaw's pose, with the optimiser LAMB. A face at rest stays exactly at rest.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrainStrainAutoencoder {
    /// Pose channels that go in beside the strains, as patterns. None where empty.
    conditions: Vec<String>,
    /// The network, and how it is trained.
    training: AutoencoderTraining,
}

impl Default for TrainStrainAutoencoder {
    fn default() -> Self {
        Self { conditions: vec!["jaw_*".to_owned()], training: AutoencoderTraining::default() }
    }
}

graph_core::register!(TrainStrainAutoencoder);

#[typetag::serde(name = "train_strain_autoencoder")]
impl Node for TrainStrainAutoencoder {
    fn card(&self) -> Card {
        Card::new("strain").takes(&STRAINS).takes(&POSES).gives(&AUTOENCODER)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (strains, poses) = (inputs.get(&STRAINS)?, inputs.get(&POSES)?);
        if strains.frames() != poses.frames() {
            let problem = format!("{} frames beside {} of the strains", poses.frames(), strains.frames());
            return Err(NodeError::input(POSES.name(), problem));
        }
        crate::rig::check_finite(STRAINS.name(), strains)?;
        crate::rig::check_finite(POSES.name(), poses)?;
        let patterns = Patterns { parameter: "conditions", what: "channel", names: poses.channels() };
        let chosen = if self.conditions.is_empty() { Vec::new() } else { patterns.chosen(&self.conditions)? };
        let conditions = poses.arrange(&chosen, None).map_err(|error| NodeError::input(POSES.name(), error))?;
        let matrix = |curves: &Curves| {
            let rows = (curves.frames(), curves.channels().len());
            Matrix::new(rows.0, rows.1, curves.values().to_vec()).map_err(NodeError::failed)
        };
        let trained = train_autoencoder(&self.training, &matrix(strains)?, &matrix(&conditions)?, |epoch, loss| {
            context.progress((epoch + 1) as f64 / self.training.epochs as f64, &[("loss", loss)]);
            !context.cancelled()
        });
        let (network, losses) = trained.map_err(|error| match error {
            TrainError::Cancelled { .. } => NodeError::Cancelled,
            TrainError::Setting { .. } => NodeError::parameter("training", error),
            _ => NodeError::failed(error),
        })?;
        let made = StrainAutoencoder { strains: strains.channels().to_vec(), poses: chosen, network, losses };
        Ok(Outputs::default().with(&AUTOENCODER, made))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{Bench, compute, made};
    use face_math::strain::measure_poses;
    use serde_json::json;
    use wire::{Data, Value, ValueKind};

    fn inputs() -> Inputs {
        let motion = toy::motion(10);
        let poses = measure_poses(&toy::BASE, &toy::evaluated(&toy::ACTOR, &motion)).unwrap();
        Inputs::default().with(&STRAINS, motion).with(&POSES, poses)
    }

    #[test]
    fn it_is_trained_and_round_trips() {
        let node: TrainStrainAutoencoder =
            made(json!({"training": {"hidden": 16, "latent": 8, "epochs": 30, "batch": 8, "learning_rate": 0.03}}));
        let outputs = compute(&node, &inputs()).unwrap();
        let trained = outputs.get(&AUTOENCODER).unwrap();
        assert!(trained.losses[29] < 0.8 * trained.losses[0], "{:?}", trained.losses);
        assert_eq!(trained.poses.len(), 6);
        let encoded = (trained as &dyn Value).encoded();
        let decoded = (ValueKind::of::<StrainAutoencoder>().decode)(&encoded).unwrap();
        assert_eq!(decoded.downcast_ref::<StrainAutoencoder>(), Some(trained));
        assert_eq!(StrainAutoencoder::NAME, "StrainAutoencoder");
        assert!(trained.on(&toy::BASE).is_err(), "a rig without strains has other channels");
    }

    #[test]
    fn it_stops_and_names_what_is_wrong() {
        let node: TrainStrainAutoencoder = made(json!({}));
        assert!(matches!(Bench::default().cancelled_after(1).compute(&node, &inputs()), Err(NodeError::Cancelled)));
        let wrong: TrainStrainAutoencoder = made(json!({"conditions": ["jow_*"]}));
        assert!(compute(&wrong, &inputs()).unwrap_err().to_string().contains("`conditions`"));
    }
}
