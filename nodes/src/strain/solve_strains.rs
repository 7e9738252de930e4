//! `solve_strains`: the strains that bring a strain rig onto meshes, its joints known (section B.3 of Animatomy).

use crate::values::StrainAutoencoder;
use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::{Manifold, StrainSolveOptions, solve_strains};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a strain rig (`fit_strain_shapes`)");
const MESHES: Port<Meshes> = Port::new("meshes", "the meshes to reproduce, in metres; all vertices of the rig");
const POSES: Port<Curves> =
    Port::new("poses", "the poses of the joints in the same frames (`measure_poses`, `solve_jaw_pose`)");
const AUTOENCODER: Port<StrainAutoencoder> =
    Port::new("autoencoder", "the manifold of plausible strains (`train_strain_autoencoder`); none where left open");
const STRAINS: Port<Curves> = Port::new("strains", "the solved strains");
const RESIDUAL: Port<Curves> =
    Port::new("residual", "`rms_mm`: root mean square distance that is left over the vertices, in each frame");

/// Solves the strains of a whole take at once: near to the meshes, calm over time, and plausible.
///
/// Time grows with the number of frames, whatever the weights.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SolveStrains {
    /// How calm strains are over time (the paper's alpha): the distance in millimetres that the whole face (the root of the
    /// sum of squares over its vertices) may be off for a strain whose second difference is 1. 0 is none.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    acceleration_mm: f64,
    /// How strongly strains are held on the manifold (the paper's beta), in the same measure. Counts with an autoencoder.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    manifold_mm: f64,
    /// How strongly strains are drawn to 0, in the same measure; for meshes that do not show all of them.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    ridge_mm: f64,
    /// Steps of descent at most, where there is an autoencoder.
    #[schemars(range(min = 1, max = 10_000))]
    steps: usize,
}

impl Default for SolveStrains {
    fn default() -> Self {
        Self { acceleration_mm: 0.0, manifold_mm: 10.0, ridge_mm: 0.0, steps: 30 }
    }
}

graph_core::register!(SolveStrains);

#[typetag::serde(name = "solve_strains")]
impl Node for SolveStrains {
    fn card(&self) -> Card {
        let card = Card::new("strain").version(2).takes(&RIG).takes(&MESHES).takes(&POSES).may_take(&AUTOENCODER);
        card.gives(&STRAINS).gives(&RESIDUAL)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (rig, meshes, poses) = (inputs.get(&RIG)?, inputs.get(&MESHES)?, inputs.get(&POSES)?);
        let square_m2 = |mm: f64| (mm / 1000.0).powi(2);
        let options = StrainSolveOptions {
            acceleration_m2: square_m2(self.acceleration_mm),
            manifold_m2: square_m2(self.manifold_mm),
            ridge_m2: square_m2(self.ridge_mm),
            steps: self.steps,
        };
        let manifold = match inputs.may_get(&AUTOENCODER)? {
            Some(autoencoder) => {
                Some(autoencoder.on(rig).map_err(|error| NodeError::input(AUTOENCODER.name(), error))?)
            }
            None => None,
        };
        let manifold = manifold.as_ref().map(|manifold| manifold as &dyn Manifold);
        let solved =
            solve_strains(rig, meshes, poses, &options, manifold, || !context.cancelled()).map_err(super::fault)?;
        let solved = solved.ok_or(NodeError::Cancelled)?;
        let residual = super::millimetres(meshes, "rms_mm", &solved.residual_m)?;
        Ok(Outputs::default().with(&STRAINS, solved.strains).with(&RESIDUAL, residual))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{Bench, compute, made};
    use face_math::data::{Driver, Shape};
    use face_math::strain::measure_poses;
    use serde_json::json;

    /// The base with two strains, each a shape of the actor.
    fn strained() -> Rig {
        let mut rig = toy::BASE.clone();
        for name in ["mouthSmile_L", "browInnerUp_R"] {
            let shape = toy::ACTOR.shapes.iter().find(|shape| shape.name == name).unwrap().clone();
            let driver = Driver::Channel(rig.channels.len() as u32);
            rig.channels.push(name.to_owned());
            rig.shapes.push(Shape { driver, ..shape });
        }
        rig
    }

    #[test]
    fn strains_that_drove_meshes_are_found() {
        let rig = strained();
        let motion = toy::motion(40);
        let poses = measure_poses(&toy::BASE, &toy::evaluated(&toy::ACTOR, &motion)).unwrap();
        let strains = motion.arrange(&rig.channels[12..], None).unwrap();
        let values = (0..poses.frames()).flat_map(|frame| [poses.frame(frame), strains.frame(frame)].concat());
        let both = Curves::new(poses.frame_axis(), rig.channels.clone(), values.collect()).unwrap();
        let inputs =
            Inputs::default().with(&RIG, rig.clone()).with(&MESHES, toy::evaluated(&rig, &both)).with(&POSES, poses);
        let node: SolveStrains = made(json!({}));
        let outputs = compute(&node, &inputs).unwrap();
        for (a, b) in outputs.get(&STRAINS).unwrap().values().iter().zip(strains.values()) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
        assert!(outputs.get(&RESIDUAL).unwrap().values().iter().all(|rms| *rms < 1e-3));
        assert!(matches!(Bench::default().cancelled_after(0).compute(&node, &inputs), Err(NodeError::Cancelled)));
        assert!(compute(&node, &inputs.with(&RIG, toy::ACTOR.clone())).is_err());
    }
}
