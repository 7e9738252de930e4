//! `register_markers`: one frame of a capture in the space of a rig; the neutral face of an actor of whom there is nothing but
//! takes. Before `attach_markers` and `stabilize_head`.

use crate::rig::frame_number;
use face_math::data::{Markers, Rig, nearest_name};
use face_math::rig::register;
use glam::{DVec3, Vec3};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::FrameAxis;

const MARKERS: Port<Markers> = Port::new("markers", "a take, in metres, wherever the capture put it");
const RIG: Port<Rig> = Port::new("rig", "the actor's rig");
const NEUTRAL: Port<Markers> =
    Port::new("neutral", "the markers of the chosen frame, rigidly moved onto the rig's surface, in metres");

/// Moves one frame of a take onto the rig, as a rigid whole: what `attach_markers` and `stabilize_head` take for the face at
/// rest.
///
/// A few markers whose vertices are roughly known say where it lies; then the markers are drawn to the surface. The frame
/// should show the face at rest, or nearly.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RegisterMarkers {
    /// Number of the frame, as the take counts it. The first one where not given.
    frame: Option<i64>,
    /// The part of the rig that carries the markers.
    part: String,
    /// Vertices of that part near which certain markers sit, as many as are known, at least three: `{"chin": 966}`.
    known: BTreeMap<String, u32>,
}

impl Default for RegisterMarkers {
    fn default() -> Self {
        Self { frame: None, part: "face".to_owned(), known: BTreeMap::new() }
    }
}

graph_core::register!(RegisterMarkers);

#[typetag::serde(name = "register_markers")]
impl Node for RegisterMarkers {
    fn card(&self) -> Card {
        Card::new("rig").takes(&MARKERS).takes(&RIG).gives(&NEUTRAL)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let (take, rig) = (inputs.get(&MARKERS)?, inputs.get(&RIG)?);
        let place = self.place(take)?;
        let seen: Vec<(&String, DVec3)> = take
            .names()
            .iter()
            .zip(take.frame(place))
            .filter(|(_, point)| point.is_finite())
            .map(|(name, point)| (name, point.as_dvec3()))
            .collect();
        let part = rig.parts.iter().position(|part| part.name == self.part).ok_or_else(|| {
            let near = nearest_name(&self.part, rig.parts.iter().map(|part| part.name.as_str()));
            let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            NodeError::parameter("part", format!("rig `{}` has no part `{}`{near}", rig.name, self.part))
        })?;
        let vertices = &rig.parts[part].vertices;
        let mut known = Vec::new();
        for (name, vertex) in &self.known {
            let Some(point) = seen.iter().position(|(own, _)| *own == name) else {
                let near = nearest_name(name, seen.iter().map(|(own, _)| own.as_str()));
                let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
                return Err(NodeError::parameter("known", format!("the frame shows no marker `{name}`{near}")));
            };
            if *vertex >= vertices.end - vertices.start {
                let count = vertices.end - vertices.start;
                let problem = format!("`{name}`: part `{}` has {count} vertices, and no vertex {vertex}", self.part);
                return Err(NodeError::parameter("known", problem));
            }
            known.push((point, vertices.start + vertex));
        }
        let points: Vec<DVec3> = seen.iter().map(|(_, point)| *point).collect();
        let found = register(rig, part, &points, &known).map_err(|error| NodeError::parameter("known", error))?;
        context.progress(1.0, &[("off the surface mm", found.off_m * 1000.0)]);
        let moved: Vec<Vec3> = points.iter().map(|point| found.motion.apply(*point).as_vec3()).collect();
        let names = seen.iter().map(|(name, _)| (*name).clone()).collect();
        let neutral = Markers::new(FrameAxis::new(1, 1.0), names, moved).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&NEUTRAL, neutral))
    }
}

impl RegisterMarkers {
    /// Position of the chosen frame.
    fn place(&self, take: &Markers) -> Result<usize, NodeError> {
        let axis = take.frame_axis();
        let place = usize::try_from(self.frame.unwrap_or(axis.first) - axis.first).ok();
        place.filter(|place| *place < axis.count).ok_or_else(|| {
            let last = frame_number(axis, axis.count) - 1;
            let problem = format!("the take holds the frames {} to {last}", axis.first);
            NodeError::parameter("frame", problem)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use glam::Quat;
    use serde_json::json;

    fn neutral(parameters: serde_json::Value) -> Result<Markers, String> {
        let rig = toy::rig();
        let names = (0..25).map(|vertex| format!("v{vertex}")).collect();
        let away = |point: &Vec3| Quat::from_rotation_y(0.4) * *point + Vec3::new(0.2, 1.0, 0.1);
        // The second frame is elsewhere.
        let positions = rig.neutral.iter().map(away).chain(rig.neutral.iter().map(|point| *point * 2.0));
        let take = Markers::new(FrameAxis::new(2, 60.0), names, positions.collect()).unwrap();
        let outputs =
            compute(&made::<RegisterMarkers>(parameters), &Inputs::default().with(&MARKERS, take).with(&RIG, rig));
        outputs.map(|outputs| outputs.get(&NEUTRAL).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn the_frame_comes_to_lie_on_the_rig() {
        let found = neutral(json!({"part": "face", "known": {"v0": 0, "v4": 4, "v20": 20, "v12": 12}})).unwrap();
        assert_eq!(found.frames(), 1);
        for (own, rest) in found.positions().iter().zip(&toy::rig().neutral) {
            assert!(own.abs_diff_eq(*rest, 1e-5), "{own} {rest}");
        }
    }

    #[test]
    fn mistakes_are_named() {
        let fault = |parameters| neutral(parameters).unwrap_err();
        assert!(fault(json!({"part": "fase"})).contains("did you mean `face`?"));
        assert!(fault(json!({"known": {"v99": 0}})).contains("no marker `v99`"));
        assert!(fault(json!({"known": {"v1": 99}})).contains("no vertex 99"));
        assert!(fault(json!({"known": {"v0": 0, "v4": 4}})).contains("`known`"));
        assert!(fault(json!({"frame": 7})).contains("the frames 0 to 1"));
    }
}
