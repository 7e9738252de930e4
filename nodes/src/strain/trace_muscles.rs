//! `trace_muscles`: muscle curves on a head, from a file that says where they begin and end.

use crate::patterns::Patterns;
use face_math::data::{Attachment, Muscles, Part, Rig};
use face_math::strain::{spread_muscles, trace_muscles};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "the head that muscles are laid on, in its neutral pose");
const LANDMARKS: Port<Attachment> = Port::new(
    "landmarks",
    "landmarks on the head: `landmark_00` to `landmark_67` (`load_rig_landmarks`, `sample_actor`)",
);
const MUSCLES: Port<Muscles> = Port::new("muscles", "the fibres as curves that ride on the surface");

/// Lays muscles on a head: each fibre is the shortest way on the skin from its origin over its waypoints to its insertion.
///
/// The file is RON: `(muscles: [(name: "risorius", fibres: 2, both_sides: true, origin: [landmark(13)], waypoints: [],
/// insertion: [landmark(54)])])`. Origin, waypoints and insertion are lines of places, over which the fibres are spread. A
/// place is `landmark(54)`, `mix({15: 0.5, 45: 0.5})` (shares of landmarks), `vertex(part: "face", vertex: 12)` or
/// `uv(part: "face", u: 0.4, v: 0.5)`. Muscles of both sides are written for the performer's left.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TraceMuscles {
    /// The file of muscles, such as `muscles.ron`.
    path: String,
    /// Parts that hold the skin, as patterns.
    parts: Vec<String>,
    /// Keeps so many fibres, spread over the face. All where not given.
    #[schemars(range(min = 1, max = 100_000))]
    count: Option<usize>,
}

impl Default for TraceMuscles {
    fn default() -> Self {
        Self { path: String::new(), parts: vec!["face".to_owned()], count: None }
    }
}

graph_core::register!(TraceMuscles);

#[typetag::serde(name = "trace_muscles")]
impl Node for TraceMuscles {
    fn card(&self) -> Card {
        Card::new("strain").takes(&RIG).takes(&LANDMARKS).gives(&MUSCLES).reads("path")
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (rig, landmarks, source) = (inputs.get(&RIG)?, inputs.get(&LANDMARKS)?, context.source()?);
        let wrong = |error: &dyn std::fmt::Display| NodeError::file(&source.name, error);
        let plan = face_io::muscles::read(&source.bytes).map_err(|error| wrong(&error))?;
        let names: Vec<String> = rig.parts.iter().map(|part| part.name.clone()).collect();
        let chosen = Patterns { parameter: "parts", what: "part", names: &names }.chosen(&self.parts)?;
        let parts: Vec<&Part> = rig.parts.iter().filter(|part| chosen.contains(&part.name)).collect();
        let mut muscles = trace_muscles(rig, &parts, landmarks, &plan).map_err(|error| wrong(&error))?;
        if let Some(count) = self.count {
            muscles = spread_muscles(&muscles, &rig.neutral, count).map_err(NodeError::failed)?;
        }
        Ok(Outputs::default().with(&MUSCLES, muscles))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strain::toy;
    use crate::testing::{Bench, made};
    use serde_json::json;

    fn trace(text: &str, parameters: serde_json::Value) -> Result<Muscles, String> {
        let node: TraceMuscles = made(parameters);
        let inputs = Inputs::default().with(&RIG, toy::ACTOR.clone()).with(&LANDMARKS, toy::landmarks());
        let outputs = Bench::default().with_source("muscles.ron", text).compute(&node, &inputs);
        outputs.map(|outputs| outputs.get(&MUSCLES).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn the_shipped_file_lays_178_fibres_on_the_sample_head() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs/strain_train/muscles.ron");
        let text = std::fs::read_to_string(file).unwrap();
        let muscles = trace(&text, json!({})).unwrap();
        assert_eq!(muscles.curves().len(), 178);
        for curve in muscles.curves() {
            assert!((0.004..0.2).contains(&curve.rest_length_m), "{}: {}", curve.name, curve.rest_length_m);
            if let Some(left) = curve.name.strip_suffix("_L") {
                let mirror = muscles.curves().iter().find(|other| other.name.strip_suffix("_R") == Some(left)).unwrap();
                let ratio = curve.rest_length_m / mirror.rest_length_m;
                assert!((0.8..1.25).contains(&ratio), "{}: {ratio}", curve.name);
            }
        }
        assert_eq!(trace(&text, json!({"count": 50})).unwrap().curves().len(), 50);
    }

    #[test]
    fn mistakes_are_named() {
        let error = trace("(muscles: [(name: \"m\", origin: [landmark(99)], insertion: [landmark(1)])])", json!({}));
        assert!(error.unwrap_err().contains("muscles.ron: muscle `m`: asks for `landmark_99`"));
        assert!(trace("(muscles: [", json!({})).unwrap_err().contains("muscles.ron: muscles: 1:"));
    }
}
