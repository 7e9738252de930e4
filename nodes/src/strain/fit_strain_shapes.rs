//! `fit_strain_shapes`: what each strain does to the skin, and strains refined to say more (section A.3 of Animatomy).

use face_math::data::{Curves, Meshes, Muscles, Rig};
use face_math::strain::{StrainReach, StrainShapeOptions, train_strain_rig};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a head with joints and pose shapes (`fit_pose_shapes`)");
const MESHES: Port<Meshes> =
    Port::new("meshes", "its meshes unposed, pose shapes taken off (`unpose_meshes`), in metres");
const STRAINS: Port<Curves> = Port::new("strains", "strains of the muscles in the same frames (`measure_strains`)");
const MUSCLES: Port<Muscles> = Port::new("muscles", "the muscles, for their distances from the skin");
const TRAINED: Port<Rig> = Port::new("rig", "the strain rig: a channel and a shape for each muscle fibre");
const REFINED: Port<Curves> = Port::new("strains", "the strains as refined");

/// Finds expression shapes and refined strains in turns, each exactly; the loss falls with every turn.
///
/// A shape is the displacement of the skin a unit of strain. The distance penalty keeps a strain from moving skin far from its
/// muscle. A face at rest stays exactly at rest.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FitStrainShapes {
    /// How often strains and shapes are found in turns. 0 finds shapes once, for the strains as they were measured.
    #[schemars(range(max = 1000))]
    rounds: usize,
    /// How strongly refined strains are drawn to the measured ones: the distance in millimetres that the whole face (the root
    /// of the sum of squares over its vertices) may be off for a strain that differs by 1.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    prior_mm: f64,
    /// How strongly a strain is kept from skin far from its muscle (the paper's mu).
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    distance_penalty: f64,
    /// The distance from a muscle at which the penalty is 1; it grows with the square.
    #[schemars(range(min = 0.01, max = 10_000.0))]
    falloff_mm: f64,
    /// Beyond this distance a strain moves nothing at all. No bound where not given.
    #[schemars(range(min = 0.01, max = 10_000.0))]
    reach_mm: Option<f64>,
}

impl Default for FitStrainShapes {
    fn default() -> Self {
        Self { rounds: 10, prior_mm: 0.1, distance_penalty: 1e-11, falloff_mm: 20.0, reach_mm: None }
    }
}

graph_core::register!(FitStrainShapes);

#[typetag::serde(name = "fit_strain_shapes")]
impl Node for FitStrainShapes {
    fn card(&self) -> Card {
        Card::new("strain")
            .version(2)
            .takes(&RIG)
            .takes(&MESHES)
            .takes(&STRAINS)
            .takes(&MUSCLES)
            .gives(&TRAINED)
            .gives(&REFINED)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (rig, meshes) = (inputs.get(&RIG)?, inputs.get(&MESHES)?);
        let (strains, muscles) = (inputs.get(&STRAINS)?, inputs.get(&MUSCLES)?);
        let (rows, count) = (3 * meshes.vertices(), muscles.curves().len());
        context.claim("rounds", 8 * rows * (2 * meshes.frames() + 4 * count))?;
        let reach = StrainReach {
            falloff_m: self.falloff_mm / 1000.0,
            reach_m: self.reach_mm.map_or(f64::INFINITY, |reach| reach / 1000.0),
        };
        let options = StrainShapeOptions {
            rounds: self.rounds,
            prior_m2: (self.prior_mm / 1000.0).powi(2),
            distance_penalty: self.distance_penalty,
        };
        let scale = (meshes.vertices() * meshes.frames()).max(1) as f64;
        let trained = train_strain_rig(rig, meshes, strains, muscles, (reach, &options), |round, loss| {
            let share = (round + 1) as f64 / (self.rounds + 1) as f64;
            context.progress(share, &[("root of the loss, mm a vertex", 1000.0 * (loss / scale).sqrt())]);
            context.go_on().map_err(Stopped::By)
        });
        let trained = trained.map_err(|stopped| match stopped {
            Stopped::By(error) => error,
            Stopped::Fault(error) => super::fault(error),
        })?;
        Ok(Outputs::default().with(&TRAINED, trained.rig).with(&REFINED, trained.strains))
    }
}

/// Why the turns ended early.
enum Stopped {
    By(NodeError),
    Fault(face_math::strain::StrainError),
}

impl From<face_math::strain::StrainError> for Stopped {
    fn from(error: face_math::strain::StrainError) -> Self {
        Self::Fault(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{Bench, made};
    use face_math::data::{MuscleCurve, RidingPoint};
    use face_math::strain::{Keep, measure_poses, measure_strains, unpose_meshes};
    use serde_json::json;

    fn inputs() -> Inputs {
        let meshes = toy::evaluated(&toy::ACTOR, &toy::motion(15));
        let poses = measure_poses(&toy::BASE, &meshes).unwrap();
        let unposed = unpose_meshes(&toy::BASE, &meshes, &poses, Keep::Strains).unwrap();
        let face = &toy::BASE.parts[0].triangles;
        let fibre = |at: usize| {
            let point = |triangle: &[u32; 3]| RidingPoint { vertices: *triangle, weights: [0.3, 0.3, 0.4] };
            let points =
                vec![point(&face[at * face.len() / 24]), point(&face[(at * face.len() / 24 + 61) % face.len()])];
            let mut curve = MuscleCurve { name: format!("m{at}"), points, rest_length_m: 1.0 };
            curve.rest_length_m = curve.length_m(&toy::BASE.neutral);
            curve
        };
        let muscles = Muscles::new((0..24).map(fibre).collect(), toy::BASE.neutral.len()).unwrap();
        let strains = measure_strains(&muscles, &meshes).unwrap();
        Inputs::default()
            .with(&RIG, toy::BASE.clone())
            .with(&MESHES, unposed)
            .with(&STRAINS, strains)
            .with(&MUSCLES, muscles)
    }

    #[test]
    fn rounds_bring_the_rig_nearer_to_its_meshes() {
        let inputs = inputs();
        let meshes = inputs.get(&MESHES).unwrap();
        let off = |rounds: usize| {
            let node: FitStrainShapes = made(json!({ "rounds": rounds }));
            let outputs = Bench::default().compute(&node, &inputs).unwrap();
            let rig = outputs.get(&TRAINED).unwrap();
            assert_eq!(rig.channels.len(), 12 + 24);
            let own = toy::evaluated(rig, outputs.get(&REFINED).unwrap());
            own.positions().iter().zip(meshes.positions()).map(|(a, b)| f64::from(a.distance_squared(*b))).sum::<f64>()
        };
        let (plain, refined) = (off(0), off(2));
        assert!(refined < 0.3 * plain, "{refined} {plain}");
    }

    #[test]
    fn it_stops_when_told_to() {
        let node: FitStrainShapes = made(json!({}));
        let bench = Bench::default().cancelled_after(2);
        assert!(matches!(bench.compute(&node, &inputs()), Err(NodeError::Cancelled)));
        assert_eq!(bench.fractions().len(), 2);
    }
}
