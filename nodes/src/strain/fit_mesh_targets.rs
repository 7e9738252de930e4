//! `fit_mesh_targets`: whole meshes from a few markers, in the space of meshes that a face takes (B.1 of Animatomy).

use crate::patterns::Patterns;
use face_math::data::{Attachment, Curves, Markers, MeshSpace, Meshes, Rig};
use face_math::strain::MeshFitter;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> =
    Port::new("markers", "a take, the head held still, in metres; missing markers are left out");
const SPACE: Port<MeshSpace> = Port::new("space", "the meshes that the face takes (`learn_mesh_space`)");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where markers sit on the rig");
const RIG: Port<Rig> = Port::new("rig", "the rig whose parts the meshes are of");
const MESHES: Port<Meshes> = Port::new("meshes", "the likeliest mesh of each frame, in metres");
const RESIDUAL: Port<Curves> =
    Port::new("residual", "`rms_mm`: how far its markers are from the captured ones, in each frame");

/// Finds the mesh of each frame that lies best under its markers: likely by the training meshes, and near by the markers.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FitMeshTargets {
    /// Markers to use, as patterns; those of the take that are attached where empty.
    only: Vec<String>,
    /// How far markers are off. Less follows them closely (towards 0: the pseudo-inverse of the paper), more keeps to faces
    /// that were seen in training.
    #[schemars(range(min = 0.000_001, max = 100.0))]
    noise_mm: f64,
}

impl Default for FitMeshTargets {
    fn default() -> Self {
        Self { only: Vec::new(), noise_mm: 0.1 }
    }
}

graph_core::register!(FitMeshTargets);

#[typetag::serde(name = "fit_mesh_targets")]
impl Node for FitMeshTargets {
    fn card(&self) -> Card {
        let card = Card::new("strain").takes(&MARKERS).takes(&SPACE).takes(&ATTACHMENT).takes(&RIG);
        card.gives(&MESHES).gives(&RESIDUAL).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (take, space, attachment) = (inputs.get(&MARKERS)?, inputs.get(&SPACE)?, inputs.get(&ATTACHMENT)?);
        let attached = attachment.names();
        let names: Vec<String> = take.names().iter().filter(|name| attached.contains(name)).cloned().collect();
        let names = Patterns { parameter: "only", what: "marker", names: &names }.chosen(&self.only)?;
        let fitter = MeshFitter::new(space, attachment, &names, self.noise_mm / 1000.0);
        let fitter = fitter.map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let parts = &inputs.get(&RIG)?.parts;
        let fitted = fitter.fit(take, parts).map_err(|error| NodeError::input(MARKERS.name(), error))?;
        let residual = super::millimetres(&fitted.meshes, "rms_mm", &fitted.residual_m)?;
        Ok(Outputs::default().with(&MESHES, fitted.meshes).with(&RESIDUAL, residual))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{HEAD, compute, made};
    use face_math::rig::{AttachOptions, MarkerRig, attach_markers};
    use face_math::strain::learn_mesh_space;
    use serde_json::json;

    #[test]
    fn markers_of_a_known_mesh_give_it_back() {
        let motion = toy::motion(6);
        let meshes = toy::evaluated(&toy::ACTOR, &motion);
        let face = HEAD.neutral_markers.pick(&["chin"].map(str::to_owned)).err().map(|_| ()).is_some();
        assert!(face);
        let names: Vec<String> = HEAD
            .neutral_markers
            .names()
            .iter()
            .filter(|name| name.starts_with("lip") || name.starts_with("jaw"))
            .cloned()
            .collect();
        let neutral = HEAD.neutral_markers.pick(&names).unwrap();
        let attachment = attach_markers(&toy::ACTOR, &neutral, &AttachOptions::default()).unwrap().attachment;
        let take = MarkerRig::attached(&toy::ACTOR, &attachment).unwrap().drive(&motion).unwrap();
        let space = learn_mesh_space(&meshes, 60, 600).unwrap();
        let inputs = Inputs::default().with(&MARKERS, take).with(&SPACE, space).with(&ATTACHMENT, attachment);
        let inputs = inputs.with(&RIG, toy::ACTOR.clone());
        let node: FitMeshTargets = made(json!({"noise_mm": 0.01}));
        let outputs = compute(&node, &inputs).unwrap();
        let found = outputs.get(&MESHES).unwrap();
        let chin = HEAD.landmarks[8] as usize;
        for frame in 0..found.frames() {
            let far = found.frame(frame)[chin].distance(meshes.frame(frame)[chin]);
            assert!(far < 2e-3, "{far}");
        }
        assert!(outputs.get(&RESIDUAL).unwrap().values().iter().all(|rms| *rms < 0.3));
        let wrong: FitMeshTargets = made(json!({"only": ["nose_9"]}));
        assert!(compute(&wrong, &inputs).unwrap_err().to_string().contains("no marker fits `nose_9`"));
    }
}
