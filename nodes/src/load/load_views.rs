//! `load_views`: 2D markers that cameras saw, from a table; what `triangulate_markers` and `project_eye_markers` take.

use crate::selection::{Mapping, Selection};
use face_io::view_csv;
use face_math::data::Views;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const VIEWS: Port<Views> = Port::new(
    "views",
    "2D markers of each camera over frames, in pixels from the top left; those not seen are missing",
);

/// Loads 2D markers from a table (CSV): one row for each marker that a camera saw.
///
/// The columns are `camera`, `marker`, `u_px`, `v_px`, and `frame` where there is more than one frame. Views that were not
/// seen have no row, or empty cells. Coordinates are those of the pictures as the cameras took them, lens distortion
/// included.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadViews {
    /// The file, or a pattern of files, which gives one item for each file that it fits.
    path: String,
    /// Frames a second, in place of what the file states (`# rate_hz: 60`). A table with frames that states none needs it.
    #[schemars(range(min = 0.001, max = 100_000.0))]
    rate_hz: Option<f64>,
    /// Names of markers to keep, as patterns: `pupil_*`. Keeps all where empty.
    only: Vec<String>,
    /// Names of markers to leave out, as patterns: `head_*`.
    without: Vec<String>,
    /// New names of markers by old ones.
    rename: BTreeMap<String, String>,
}

graph_core::register!(LoadViews);

#[typetag::serde(name = "load_views")]
impl Node for LoadViews {
    fn card(&self) -> Card {
        Card::new("load").reads("path").gives(&VIEWS)
    }

    fn compute(&self, context: &Context<'_>, _: &Inputs) -> Result<Outputs, NodeError> {
        let source = context.source()?;
        let wrong = |error: &dyn std::fmt::Display| NodeError::file(&source.name, error);
        let mut table = view_csv::open(&source.bytes).map_err(|error| wrong(&error))?;
        table.rate_hz = self.rate_hz.or(table.rate_hz);
        let all = table.into_views(None).map_err(|error| wrong(&error))?;
        let Self { only, without, rename, .. } = self;
        let selection = Selection { what: "marker", only, without, rename, mapping: Mapping::default() };
        let kept = selection.apply(&source.name, all.markers())?.kept;
        let mut points = Vec::with_capacity(all.frames() * all.cameras().len() * kept.len());
        for frame in 0..all.frames() {
            for camera in 0..all.cameras().len() {
                points.extend(kept.iter().map(|(marker, _)| all.at(frame, camera, *marker).unwrap_or(glam::Vec2::NAN)));
            }
        }
        let names = kept.into_iter().map(|(_, name)| name).collect();
        let views = Views::new(all.frame_axis(), all.cameras().to_vec(), names, points);
        Ok(Outputs::default().with(&VIEWS, views.map_err(|error| wrong(&error))?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Bench, made, test_data};
    use glam::Vec2;
    use serde_json::json;

    fn load(parameters: serde_json::Value, bytes: &[u8]) -> Result<Views, String> {
        let node: LoadViews = made(parameters);
        let outputs = Bench::default().with_source("views.csv", bytes).compute(&node, &Inputs::default());
        outputs.map(|outputs| outputs.get(&VIEWS).unwrap().clone()).map_err(|error| error.to_string())
    }

    #[test]
    fn markers_are_chosen_and_renamed_and_the_rate_is_asked_for() {
        let text = b"frame,camera,marker,u_px,v_px\n1,a,chin,1,2\n1,a,pupil_L,3,4\n2,a,pupil_L,5,6\n";
        let views = load(json!({"rate_hz": 60.0, "only": ["pupil_*"], "rename": {"pupil_L": "eye"}}), text).unwrap();
        assert_eq!((views.markers(), views.frame_axis().rate_hz.to_bits()), (&["eye".to_owned()][..], 60f64.to_bits()));
        assert_eq!((views.at(0, 0, 0), views.at(1, 0, 0)), (Some(Vec2::new(3.0, 4.0)), Some(Vec2::new(5.0, 6.0))));
        assert!(load(json!({}), text).unwrap_err().starts_with("views.csv: CSV: "));
        assert!(load(json!({"rate_hz": 60.0, "only": ["lip"]}), text).unwrap_err().contains("`only`"));
    }

    #[test]
    fn real_views_are_read() {
        let Some(path) = test_data("actors/ict_actor_a/neutral_views.csv") else { return };
        let views = load(json!({}), &std::fs::read(path).unwrap()).unwrap();
        assert_eq!((views.cameras().len(), views.frames(), views.points_px().len() - views.missing()), (5, 1, 469));
    }
}
