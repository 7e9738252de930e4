//! `fit_skinning`: who follows which joint, learned from animated meshes (section A.1 of Animatomy).

use face_math::data::{Curves, Meshes, Rig};
use face_math::strain::fit_skinning;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "a head with joints, whose weights are the start (`add_joints`)");
const MESHES: Port<Meshes> = Port::new("meshes", "its animated meshes, in metres");
const POSES: Port<Curves> = Port::new("poses", "the poses of the joints in the same frames (`measure_poses`)");
const SKINNED: Port<Rig> = Port::new("rig", "the same head with fitted weights");

/// Fits the skinning weights of all joints to animated meshes: bounded least squares in every vertex, exactly.
///
/// Each weight lies between 0 and 1 and is drawn to where it started, so that vertices far from a joint do not take it up.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FitSkinning {
    /// How strongly weights are drawn to their start: the distance in millimetres that a vertex may be off, on average over
    /// the frames, for a weight that differs by 1 (the root of the paper's lambda).
    #[schemars(range(min = 0.000_001, max = 1000.0))]
    prior_mm: f64,
}

impl Default for FitSkinning {
    fn default() -> Self {
        Self { prior_mm: 0.3 }
    }
}

graph_core::register!(FitSkinning);

#[typetag::serde(name = "fit_skinning")]
impl Node for FitSkinning {
    fn card(&self) -> Card {
        Card::new("strain").takes(&RIG).takes(&MESHES).takes(&POSES).gives(&SKINNED)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (rig, meshes, poses) = (inputs.get(&RIG)?, inputs.get(&MESHES)?, inputs.get(&POSES)?);
        let fitted = fit_skinning(rig, meshes, poses, (self.prior_mm / 1000.0).powi(2)).map_err(super::fault)?;
        let count = (meshes.frames() * meshes.vertices()).max(1) as f64;
        let rms_mm = fitted.squares_m2.map(|squares| 1000.0 * (squares / count).sqrt());
        context.progress(1.0, &[("rms before mm", rms_mm[0]), ("rms after mm", rms_mm[1])]);
        Ok(Outputs::default().with(&SKINNED, fitted.rig))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{compute, made};
    use face_math::strain::measure_poses;
    use serde_json::json;

    #[test]
    fn fitted_weights_lie_in_the_box_and_fit_better() {
        let curves = toy::motion(10);
        let meshes = toy::evaluated(&toy::ACTOR, &curves);
        let poses = measure_poses(&toy::BASE, &meshes).unwrap();
        let node: FitSkinning = made(json!({}));
        let mut blind = toy::BASE.clone();
        let face = blind.parts[0].vertices.end as usize;
        blind.jaw.as_mut().unwrap().weights[..face].fill(0.0);
        let inputs =
            Inputs::default().with(&RIG, blind.clone()).with(&MESHES, meshes.clone()).with(&POSES, poses.clone());
        let outputs = compute(&node, &inputs).unwrap();
        let fitted = outputs.get(&SKINNED).unwrap();
        assert!(fitted.all_joints().all(|joint| joint.weights.iter().all(|weight| (0.0..=1.0).contains(weight))));
        let off = |rig: &Rig| {
            let own = toy::evaluated(rig, &poses);
            own.positions().iter().zip(meshes.positions()).map(|(a, b)| f64::from(a.distance_squared(*b))).sum::<f64>()
        };
        assert!(off(fitted) < 0.5 * off(&blind), "{} {}", off(fitted), off(&blind));
        let error = compute(&node, &inputs.with(&POSES, curves)).unwrap_err().to_string();
        assert!(error.contains("no channel `jaw_turn_x_rad`"), "{error}");
    }
}
