//! `attach_markers`: neutral markers onto the rig's surface, so that the rig can carry them along.

use crate::patterns::Patterns;
use face_math::data::{Attachment, Markers, Rig};
use face_math::rig::{AttachOptions, FarMarker, attach_markers, snap_to_vertices};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const RIG: Port<Rig> = Port::new("rig", "the head that shall carry the markers, in metres");
const NEUTRAL: Port<Markers> =
    Port::new("neutral", "the markers of the face at rest; its first frame is used, in metres");
const ATTACHMENT: Port<Attachment> =
    Port::new("attachment", "each marker's place on the surface, and its distance from it in metres");

/// Attaches neutral markers to the rig at rest: each to the nearest point of its surface.
///
/// Most markers lie on the skin, so a marker stays on the part that most markers are nearest to, unless another part is
/// nearer by `skin_margin_mm`. Pupils sit on the eyeballs for that reason, and markers at the edge of a lid do not.
/// The summary of the result tells the mean and the worst distance.
///
/// A mask is often laid out on vertices of the mesh. Where at least half of the markers lie within `snap_mm` of a vertex,
/// those markers sit on theirs, which takes the noise of the neutral markers out.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AttachMarkers {
    /// A marker farther from the surface than this does not belong to this rig, or the neutral pose is not neutral; then
    /// see `far`. In millimetres.
    #[schemars(range(min = 0.01, max = 1000.0))]
    max_distance_mm: f64,
    /// What to do where markers are farther away than `max_distance_mm`.
    far: Far,
    /// Parts of the rig on which markers may sit, as patterns: `face`, `eyeball_*`. All parts where empty.
    parts: Vec<String>,
    /// Markers to leave out, as patterns: `head_*`.
    exclude: Vec<String>,
    /// By how much another part must be nearer than the skin for a marker to leave the skin, in millimetres.
    #[schemars(range(min = 0.0, max = 100.0))]
    skin_margin_mm: f64,
    /// Where most markers lie this near to vertices of the rig, in millimetres, the mask was laid out on vertices, and the
    /// markers are put onto theirs: what is left of the distance is the noise of the measurement. 0 never does it.
    #[schemars(range(min = 0.0, max = 100.0))]
    snap_mm: f64,
}

/// What to do with far markers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Far {
    /// Stop, and name them with their distances.
    Error,
    /// Attach them all the same; the summary tells the worst.
    Report,
    /// Leave them out.
    LeaveOut,
}

impl Default for AttachMarkers {
    fn default() -> Self {
        Self {
            max_distance_mm: 10.0,
            far: Far::Error,
            parts: Vec::new(),
            exclude: Vec::new(),
            skin_margin_mm: 2.0,
            snap_mm: 0.2,
        }
    }
}

graph_core::register!(AttachMarkers);

#[typetag::serde(name = "attach_markers")]
impl Node for AttachMarkers {
    fn card(&self) -> Card {
        Card::new("rig").takes(&RIG).takes(&NEUTRAL).gives(&ATTACHMENT)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let rig = inputs.get(&RIG)?;
        let neutral = self.kept(inputs.get(&NEUTRAL)?)?;
        let limit_m = self.max_distance_mm / 1000.0;
        let part_names: Vec<String> = rig.parts.iter().map(|part| part.name.clone()).collect();
        let parts = Patterns { parameter: "parts", what: "part", names: &part_names }.chosen(&self.parts)?;
        let options = AttachOptions {
            parts,
            skin_margin_m: self.skin_margin_mm / 1000.0,
            max_distance_m: if self.far == Far::Report { f64::INFINITY } else { limit_m },
        };
        let attached =
            attach_markers(rig, &neutral, &options).map_err(|error| NodeError::input(NEUTRAL.name(), error))?;
        if self.far == Far::Error && !attached.far.is_empty() {
            return Err(NodeError::input(NEUTRAL.name(), self.too_far(rig, &attached.far)));
        }
        if attached.attachment.points.is_empty() {
            return Err(NodeError::input(NEUTRAL.name(), "no marker is left to attach"));
        }
        let snap_m = self.snap_mm / 1000.0;
        let snapped = snap_to_vertices(rig, &attached.attachment, snap_m)
            .map_err(|error| NodeError::parameter("snap_mm", error))?;
        Ok(Outputs::default().with(&ATTACHMENT, snapped.attachment))
    }
}

impl AttachMarkers {
    fn kept(&self, neutral: &Markers) -> Result<Markers, NodeError> {
        let out = Patterns { parameter: "exclude", what: "marker", names: neutral.names() }.fits(&self.exclude)?;
        let kept: Vec<String> =
            neutral.names().iter().zip(out).filter(|(_, out)| !out).map(|(name, _)| name.clone()).collect();
        neutral.pick(&kept).map_err(|error| NodeError::input(NEUTRAL.name(), error))
    }

    fn too_far(&self, rig: &Rig, far: &[FarMarker]) -> String {
        let each = |marker: &FarMarker| {
            format!("`{}` {:.2} mm from `{}`", marker.name, marker.distance_m * 1000.0, marker.part)
        };
        format!(
            "markers lie farther than {} mm from rig `{}`: {}; check that the two are one actor in one pose and unit, raise \
             `max_distance_mm`, or set `far` to `report` or `leave_out`",
            self.max_distance_mm,
            rig.name,
            far.iter().map(each).collect::<Vec<_>>().join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made};
    use glam::Vec3;
    use serde_json::json;

    fn attach(parameters: serde_json::Value, neutral: Markers) -> Result<Attachment, String> {
        let node: AttachMarkers = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&RIG, toy::rig()).with(&NEUTRAL, neutral));
        outputs.map(|outputs| outputs.get(&ATTACHMENT).unwrap().clone()).map_err(|error| error.to_string())
    }

    /// The toy's markers, the second and third moved off the surface.
    fn lifted() -> Markers {
        let neutral = toy::neutral();
        let mut positions = neutral.positions().to_vec();
        positions[1] += Vec3::Z * 0.02;
        positions[2] += Vec3::Z * 0.03;
        neutral.with_positions(positions).unwrap()
    }

    #[test]
    fn markers_on_the_surface_are_attached_in_their_order() {
        let attachment = attach(json!({}), toy::neutral()).unwrap();
        assert_eq!(attachment.names(), toy::neutral().names());
        assert!(attachment.points.iter().all(|point| point.distance_m < 1e-7));
        let some = attach(json!({"exclude": ["m1*"]}), toy::neutral()).unwrap();
        assert_eq!(some.names().len(), 12 - 3);
    }

    #[test]
    fn far_markers_are_named_with_their_distances_or_kept_or_left_out() {
        let error = attach(json!({}), lifted()).unwrap_err();
        assert!(error.contains("`m1` 19.") || error.contains("`m1` 20."), "{error}");
        assert!(error.contains("`m2`") && !error.contains("`m3`"), "{error}");
        assert_eq!(attach(json!({"far": "report"}), lifted()).unwrap().points.len(), 12);
        let left = attach(json!({"far": "leave_out"}), lifted()).unwrap();
        assert!(left.points.len() == 10 && !left.names().contains(&"m1".to_owned()));
        assert_eq!(attach(json!({"max_distance_mm": 50.0}), lifted()).unwrap().points.len(), 12);
    }

    #[test]
    fn a_mask_laid_out_on_vertices_sits_on_them() {
        let (rig, mut dice) = (toy::rig(), toy::Dice(3));
        let positions: Vec<Vec3> = (0..10).map(|vertex| rig.neutral[vertex] + dice.point() * 1e-4).collect();
        let names = (0..10).map(|vertex| format!("v{vertex}")).collect();
        let neutral = Markers::new(wire::FrameAxis::new(1, 1.0), names, positions).unwrap();
        let on_vertex = |point: &face_math::data::SurfacePoint| point.weights.iter().any(|weight| *weight >= 1.0);
        assert!(attach(json!({}), neutral.clone()).unwrap().points.iter().all(on_vertex));
        assert!(!attach(json!({"snap_mm": 0.0}), neutral).unwrap().points.iter().all(on_vertex));
    }

    #[test]
    fn unknown_parts_and_markers_are_named() {
        assert!(attach(json!({"parts": ["fase"]}), toy::neutral()).unwrap_err().contains("did you mean `face`?"));
        assert!(attach(json!({"exclude": ["head_*"]}), toy::neutral()).unwrap_err().contains("`exclude`"));
        assert!(attach(json!({"exclude": ["*"]}), toy::neutral()).unwrap_err().contains("no marker is left"));
    }
}
