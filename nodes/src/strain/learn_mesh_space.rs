//! `learn_mesh_space`: the meshes that a face takes, as principal components; what markers become whole meshes by.

use face_math::data::{MeshSpace, Meshes};
use face_math::strain::learn_mesh_space;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MESHES: Port<Meshes> = Port::new("meshes", "training meshes that show all that the face does, in metres");
const SPACE: Port<MeshSpace> = Port::new("space", "the mean mesh and its principal components");

/// Learns the principal components of training meshes (section B.1 of Animatomy).
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LearnMeshSpace {
    /// Number of components at most.
    #[schemars(range(min = 1, max = 100_000))]
    components: usize,
    /// Up to so many frames, all components are found and the greatest kept; beyond, the greatest alone by a randomised
    /// decomposition, which is quicker and as good.
    #[schemars(range(min = 2, max = 100_000))]
    exact_frames: usize,
}

impl Default for LearnMeshSpace {
    fn default() -> Self {
        Self { components: 300, exact_frames: 600 }
    }
}

graph_core::register!(LearnMeshSpace);

#[typetag::serde(name = "learn_mesh_space")]
impl Node for LearnMeshSpace {
    fn card(&self) -> Card {
        Card::new("strain").takes(&MESHES).gives(&SPACE)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let meshes = inputs.get(&MESHES)?;
        context
            .claim("components", 24 * meshes.vertices() * (meshes.frames() + self.components.min(meshes.frames())))?;
        let space = learn_mesh_space(meshes, self.components, self.exact_frames);
        Ok(Outputs::default().with(&SPACE, space.map_err(|error| NodeError::input(MESHES.name(), error))?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{compute, made};
    use serde_json::json;

    #[test]
    fn components_are_as_many_as_asked_for() {
        let meshes = toy::evaluated(&toy::ACTOR, &toy::motion(15));
        let node: LearnMeshSpace = made(json!({"components": 8}));
        let outputs = compute(&node, &Inputs::default().with(&MESHES, meshes)).unwrap();
        let space = outputs.get(&SPACE).unwrap();
        assert_eq!(space.spreads_m().len(), 8);
        assert!(space.spreads_m().windows(2).all(|pair| pair[0] >= pair[1]));
        let one = toy::evaluated(&toy::ACTOR, &toy::motion(600));
        assert!(
            compute(&node, &Inputs::default().with(&MESHES, one)).unwrap_err().to_string().contains("2 are needed")
        );
    }
}
