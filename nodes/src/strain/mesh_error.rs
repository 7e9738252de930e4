//! `mesh_error`: how far meshes are from the true ones, in millimetres; for tests of a set-up.

use crate::patterns::Patterns;
use crate::values::Scores;
use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::mesh_error;
use glam::Vec3;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const TRUTH: Port<Meshes> = Port::new("truth", "the meshes as they should be, in metres");
const MESHES: Port<Meshes> = Port::new("meshes", "the meshes that are measured, of the same parts and frames");
const RIG: Port<Rig> =
    Port::new("rig", "in place of meshes: a rig whose neutral face is measured, as if nothing moved");
const ERROR: Port<Curves> =
    Port::new("error", "`mean_mm`, `rms_mm` and `max_mm` over the vertices, in each frame, in millimetres");
const SCORES: Port<Scores> = Port::new(
    "scores",
    "mean distance over all frames and vertices in millimetres, with `rms_mm`, `max_mm` and `jitter_mm`",
);

/// Measures the distances between the vertices of meshes and those of the true meshes.
///
/// `jitter_mm` is the root mean square of what the offsets do from frame to frame (their second differences over time): an offset
/// that stays is no jitter.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeshError {
    /// Parts that count, as patterns. All where empty.
    parts: Vec<String>,
}

graph_core::register!(MeshError);

/// The positions of a frame.
type FrameOf<'a> = Box<dyn Fn(usize) -> &'a [Vec3] + 'a>;

#[typetag::serde(name = "mesh_error")]
impl Node for MeshError {
    fn card(&self) -> Card {
        Card::new("strain").takes(&TRUTH).may_take(&MESHES).may_take(&RIG).gives(&ERROR).gives(&SCORES)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let truth = inputs.get(&TRUTH)?;
        let names: Vec<String> = truth.parts().iter().map(|part| part.name.clone()).collect();
        let chosen = Patterns { parameter: "parts", what: "part", names: &names }.chosen(&self.parts)?;
        let parts = truth.parts().iter().filter(|part| chosen.contains(&part.name));
        let vertices: Vec<usize> =
            parts.flat_map(|part| part.vertices.start as usize..part.vertices.end as usize).collect();
        let misfit = |port: &str, found: usize, what: &str, needed: usize| {
            Err(NodeError::input(port, format!("{found} {what} beside {needed} of the truth")))
        };
        let frame_of: FrameOf<'_> = match (inputs.may_get(&MESHES)?, inputs.may_get(&RIG)?) {
            (Some(meshes), None) if meshes.frames() != truth.frames() => {
                return misfit(MESHES.name(), meshes.frames(), "frames", truth.frames());
            }
            (Some(meshes), None) if meshes.vertices() != truth.vertices() => {
                return misfit(MESHES.name(), meshes.vertices(), "vertices", truth.vertices());
            }
            (None, Some(rig)) if rig.neutral.len() != truth.vertices() => {
                return misfit(RIG.name(), rig.neutral.len(), "vertices", truth.vertices());
            }
            (Some(meshes), None) => Box::new(|frame| meshes.frame(frame)),
            (None, Some(rig)) => Box::new(|_| &rig.neutral),
            _ => return Err(NodeError::input(MESHES.name(), "connect either meshes or a rig")),
        };
        let error = mesh_error(truth, &vertices, frame_of).map_err(|error| NodeError::input(MESHES.name(), error))?;
        let frames = truth.frames().max(1) as f64;
        let mm = |metres: f64| 1000.0 * metres;
        let mean = error.mean_m.iter().sum::<f64>() / frames;
        let rms = (error.rms_m.iter().map(|rms| rms * rms).sum::<f64>() / frames).sqrt();
        let most = error.max_m.iter().copied().fold(0.0, f64::max);
        let rows = error.mean_m.iter().zip(&error.rms_m).zip(&error.max_m);
        let values = rows.flat_map(|((mean, rms), most)| [*mean, *rms, *most].map(|metres| mm(metres) as f32));
        let names = ["mean_mm", "rms_mm", "max_mm"].map(str::to_owned).to_vec();
        let curves = Curves::new(truth.frame_axis(), names, values.collect()).map_err(NodeError::failed)?;
        let scores = Scores {
            what: "mean distance of vertices in mm".to_owned(),
            overall: mm(mean),
            by_name: vec![
                ("rms_mm".to_owned(), mm(rms)),
                ("max_mm".to_owned(), mm(most)),
                ("jitter_mm".to_owned(), mm(error.jitter_m)),
            ],
        };
        Ok(Outputs::default().with(&ERROR, curves).with(&SCORES, scores))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    #[test]
    fn distances_are_millimetres_of_the_chosen_parts() {
        let truth = toy::evaluated(&toy::ACTOR, &toy::motion(200));
        let moved = truth.positions().iter().map(|point| *point + Vec3::new(0.0, 3e-3, 4e-3)).collect();
        let moved = Meshes::new(truth.frame_axis(), truth.parts().to_vec(), truth.vertices(), moved).unwrap();
        let node: MeshError = made(json!({"parts": ["face"]}));
        let inputs = Inputs::default().with(&TRUTH, truth.clone());
        let outputs = compute(&node, &inputs.clone().with(&MESHES, moved)).unwrap();
        let scores = outputs.get(&SCORES).unwrap();
        assert!((scores.overall - 5.0).abs() < 1e-4 && (scores.by_name[1].1 - 5.0).abs() < 1e-3);
        let rest = compute(&node, &inputs.clone().with(&RIG, toy::BASE.clone())).unwrap();
        assert!(rest.get(&SCORES).unwrap().overall > 0.1);
        assert!(compute(&node, &inputs).unwrap_err().to_string().contains("either meshes or a rig"));
    }
}
