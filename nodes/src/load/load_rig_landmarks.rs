//! `load_rig_landmarks`: where the 68 landmarks of a face sit on a rig; what muscles are traced by.

use face_math::data::{Attachment, Rig};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "the head that the landmarks are on");
const LANDMARKS: Port<Attachment> =
    Port::new("landmarks", "the 68 landmarks of Multi-PIE on the head, as `landmark_00` to `landmark_67`");

/// Loads the landmarks of a rig: the vertex of each of the 68 landmarks of Multi-PIE, from JSON.
///
/// The file is a list of 68 vertices, or an object with such a list called `landmarks68`. Vertices are counted from 0 within
/// one part.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadRigLandmarks {
    /// The file, such as `landmarks.json`.
    path: String,
    /// The part whose vertices are counted.
    part: String,
}

impl Default for LoadRigLandmarks {
    fn default() -> Self {
        Self { path: String::new(), part: "face".to_owned() }
    }
}

graph_core::register!(LoadRigLandmarks);

/// What a file may be.
#[derive(Deserialize)]
#[serde(untagged)]
enum Landmarks {
    List(Vec<u32>),
    Named { landmarks68: Vec<u32> },
}

#[typetag::serde(name = "load_rig_landmarks")]
impl Node for LoadRigLandmarks {
    fn card(&self) -> Card {
        Card::new("load").takes(&RIG).gives(&LANDMARKS).reads("path")
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (rig, source) = (inputs.get(&RIG)?, context.source()?);
        let wrong = |problem: String| NodeError::file(&source.name, problem);
        let part = crate::patterns::part(rig, "part", &self.part)?;
        let read = serde_json::from_slice(&source.bytes);
        let (Landmarks::List(own) | Landmarks::Named { landmarks68: own }) = read.map_err(|error| {
            wrong(format!("{error}; write a list of 68 vertices, or an object with such a list as `landmarks68`"))
        })?;
        if own.len() != 68 {
            return Err(wrong(format!("{} landmarks where 68 are needed", own.len())));
        }
        let count = part.vertices.len();
        if let Some(number) = own.iter().position(|vertex| *vertex as usize >= count) {
            let problem = format!("landmark {number} is vertex {}; part `{}` has {count}", own[number], self.part);
            return Err(wrong(problem));
        }
        let own: Vec<u32> = own.iter().map(|vertex| vertex + part.vertices.start).collect();
        Ok(Outputs::default().with(&LANDMARKS, super::landmarks_on(rig, &own)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, HEAD, made};
    use serde_json::json;

    fn load(text: &str, parameters: serde_json::Value) -> Result<Attachment, String> {
        let node: LoadRigLandmarks = made(parameters);
        let bench = Bench::default().with_source("landmarks.json", text);
        let outputs = bench.compute(&node, &Inputs::default().with(&RIG, HEAD.rig.clone()));
        outputs.map(|outputs| outputs.get(&LANDMARKS).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn landmarks_sit_at_their_vertices() {
        let list = json!(HEAD.landmarks.to_vec());
        let found = load(&json!({ "landmarks68": list, "note": "" }).to_string(), json!({})).unwrap();
        assert_eq!(found, load(&list.to_string(), json!({})).unwrap());
        for (point, vertex) in found.points.iter().zip(HEAD.landmarks) {
            let own = point.weights.iter().position(|weight| *weight > 0.5).unwrap();
            assert_eq!(point.vertices[own], vertex, "{}", point.name);
        }
    }

    #[test]
    fn what_does_not_fit_is_named() {
        assert!(load("[1, 2]", json!({})).unwrap_err().contains("2 landmarks where 68 are needed"));
        assert!(load("{}", json!({})).unwrap_err().contains("`landmarks68`"));
        let far = json!(vec![99_999_999; 68]).to_string();
        assert!(load(&far, json!({})).unwrap_err().contains("landmark 0 is vertex 99999999"));
        assert!(load("[]", json!({"part": "fase"})).unwrap_err().contains("did you mean `face`?"));
    }
}
