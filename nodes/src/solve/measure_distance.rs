//! `measure_distance`: how far two markers are apart in each frame; a measure of a face that needs no solve.

use face_math::data::{Curves, Markers, nearest_name};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "a take, in metres");
const DISTANCE: Port<Curves> =
    Port::new("distance", "`distance_mm` in each frame; NaN where one of the two is missing");

/// Measures the distance between two markers in each frame: from chin to nose, it tells how far the mouth is open.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeasureDistance {
    /// One marker.
    from: String,
    /// The other one.
    to: String,
}

graph_core::register!(MeasureDistance);

#[typetag::serde(name = "measure_distance")]
impl Node for MeasureDistance {
    fn card(&self) -> Card {
        Card::new("solve").takes(&MARKERS).gives(&DISTANCE).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let take = inputs.get(&MARKERS)?;
        let column = |parameter, name: &str| {
            take.index(name).ok_or_else(|| {
                let near = nearest_name(name, take.names().iter().map(String::as_str));
                let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
                NodeError::parameter(parameter, format!("the take has no marker `{name}`{near}"))
            })
        };
        let (from, to) = (column("from", &self.from)?, column("to", &self.to)?);
        let apart = |frame: usize| {
            let points = take.frame(frame);
            (points[from].as_dvec3().distance(points[to].as_dvec3()) * 1000.0) as f32
        };
        let values = (0..take.frames()).map(apart).collect();
        let distance = Curves::new(take.frame_axis(), vec!["distance_mm".to_owned()], values);
        Ok(Outputs::default().with(&DISTANCE, distance.map_err(NodeError::failed)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{compute, made};
    use glam::Vec3;
    use serde_json::json;
    use wire::FrameAxis;

    fn measure(parameters: serde_json::Value) -> Result<Curves, String> {
        let points = vec![Vec3::ZERO, Vec3::new(0.003, 0.0, 0.004), Vec3::NAN, Vec3::X];
        let take = Markers::new(FrameAxis::new(2, 60.0), vec!["chin".into(), "nose".into()], points).unwrap();
        let outputs = compute(&made::<MeasureDistance>(parameters), &Inputs::default().with(&MARKERS, take));
        outputs.map(|outputs| outputs.get(&DISTANCE).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn distances_are_in_millimetres_and_missing_ones_missing() {
        let distance = measure(json!({"from": "chin", "to": "nose"})).unwrap();
        assert!((distance.frame(0)[0] - 5.0).abs() < 1e-5 && distance.frame(1)[0].is_nan());
        assert!(measure(json!({"from": "chinn", "to": "nose"})).unwrap_err().contains("did you mean `chin`?"));
    }
}
