//! `solve_jaw_pose`: the pose of the jaw from meshes, over a whole take (section B.2 of Animatomy).

use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::{JawSolveOptions, expression_weights, solve_jaw_pose};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a strain rig, or one with pose shapes alone");
const MESHES: Port<Meshes> = Port::new("meshes", "the meshes to reproduce, in metres; all vertices of the rig");
const POSES: Port<Curves> =
    Port::new("poses", "known poses of the other joints, such as eyes; at rest where left open");
const STRAINS: Port<Curves> = Port::new(
    "strains",
    "strains that the face takes (those of the training); vertices that they move count less. All count alike where left open",
);
const SOLVED: Port<Curves> =
    Port::new("poses", "the poses of all joints: the jaw's as solved, the others as they were given");
const RESIDUAL: Port<Curves> = Port::new("residual", "`rms_mm`: root mean square distance that is left, in each frame");

/// Solves the jaw of a whole take at once, calm over time. Expressions are taken to be at rest, as in the paper.
///
/// A smile pulls the skin of the jaw along. With `strains`, vertices count less the more expressions move them.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SolveJawPose {
    /// How calm the jaw is over time (the paper's lambda): the distance in millimetres that the whole face (the root of the
    /// sum of squares over its vertices) may be off for a second difference of one radian. 0 is none.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    acceleration_mm: f64,
    /// The translation that weighs as much as a radian.
    #[schemars(range(min = 0.1, max = 10_000.0))]
    lever_mm: f64,
    /// With strains: a vertex that expressions move by this counts half.
    #[schemars(range(min = 0.000_1, max = 1000.0))]
    noise_mm: f64,
    /// Steps at most.
    #[schemars(range(min = 1, max = 1000))]
    steps: usize,
}

impl Default for SolveJawPose {
    fn default() -> Self {
        Self { acceleration_mm: 100.0, lever_mm: 100.0, noise_mm: 0.05, steps: 30 }
    }
}

graph_core::register!(SolveJawPose);

#[typetag::serde(name = "solve_jaw_pose")]
impl Node for SolveJawPose {
    fn card(&self) -> Card {
        let card = Card::new("strain").version(2).takes(&RIG).takes(&MESHES).may_take(&POSES).may_take(&STRAINS);
        card.gives(&SOLVED).gives(&RESIDUAL)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (rig, meshes) = (inputs.get(&RIG)?, inputs.get(&MESHES)?);
        let weights = match inputs.may_get(&STRAINS)? {
            Some(strains) => expression_weights(rig, strains, self.noise_mm / 1000.0)
                .map_err(|error| NodeError::input(STRAINS.name(), error))?,
            None => vec![1.0; rig.neutral.len()],
        };
        let options = JawSolveOptions {
            acceleration_m2: (self.acceleration_mm / 1000.0).powi(2),
            lever_m: self.lever_mm / 1000.0,
            steps: self.steps,
        };
        let solved = solve_jaw_pose(rig, meshes, inputs.may_get(&POSES)?, &weights, &options, || !context.cancelled());
        let solved = solved.map_err(super::fault)?.ok_or(NodeError::Cancelled)?;
        let residual = super::millimetres(meshes, "rms_mm", &solved.residual_m)?;
        Ok(Outputs::default().with(&SOLVED, solved.poses).with(&RESIDUAL, residual))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{Bench, compute, made};
    use face_math::strain::measure_poses;
    use serde_json::json;

    #[test]
    fn the_jaw_of_a_rig_without_expressions_is_found() {
        let poses = measure_poses(&toy::BASE, &toy::evaluated(&toy::ACTOR, &toy::motion(30))).unwrap();
        let meshes = toy::evaluated(&toy::BASE, &poses);
        let inputs = Inputs::default().with(&RIG, toy::BASE.clone()).with(&MESHES, meshes);
        let node: SolveJawPose = made(json!({"acceleration_mm": 0.0}));
        let outputs = compute(&node, &inputs).unwrap();
        let found = outputs.get(&SOLVED).unwrap();
        for frame in 0..poses.frames() {
            for place in 0..6 {
                let (a, b) = (found.frame(frame)[place], poses.frame(frame)[place]);
                assert!((a - b).abs() < 1e-4, "{a} {b}");
            }
        }
        assert!(outputs.get(&RESIDUAL).unwrap().values().iter().all(|rms| *rms < 1e-2));
        assert!(matches!(Bench::default().cancelled_after(0).compute(&node, &inputs), Err(NodeError::Cancelled)));
    }
}
