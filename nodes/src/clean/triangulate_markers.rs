//! `triangulate_markers`: markers in space from where several cameras saw them; before gaps are filled.

use face_math::data::{Cameras, Curves, Markers, Views};
use face_math::views::{TriangulateError, TriangulateOptions, triangulate};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const VIEWS: Port<Views> = Port::new("views", "where each camera saw each marker, in pixels of the distorted picture");
const CAMERAS: Port<Cameras> = Port::new("cameras", "the calibrated cameras that the views name");
const MARKERS: Port<Markers> =
    Port::new("markers", "the markers in space, in metres; those without a place are missing");
const RESIDUAL: Port<Curves> = Port::new(
    "residual_px",
    "a channel a marker: how far its place is from where the used cameras saw it, root mean square in pixels; NaN where \
     it is missing",
);
const UNCERTAINTY: Port<Curves> = Port::new(
    "uncertainty_mm",
    "a channel a marker: distance from the true place that noise leads one to expect, root mean square in millimetres; \
     NaN where it is missing",
);
const USED: Port<Curves> =
    Port::new("used_views", "a channel a marker: how many views its place rests on; 0 where it is missing");

/// Finds markers in space from the views of calibrated cameras.
///
/// Each marker of each frame is the place of least distance, in pixels, from where the cameras saw it, lens distortion
/// included. Views that contradict the others are left out: every pair of views is tried, so that two good ones suffice
/// beside bad ones. A marker that too few cameras saw, that no two agree on, or that two places explain equally well, is
/// missing rather than guessed; progress counts these.
///
/// `uncertainty_mm` follows from `noise_px`, or from the residuals where these are larger.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TriangulateMarkers {
    /// Noise of the tracking: standard deviation of a coordinate, in pixels.
    #[schemars(range(min = 0.000_001, max = 100.0))]
    noise_px: f64,
    /// A view farther than this from where the marker must appear is bad, in pixels.
    #[schemars(range(min = 0.000_001, max = 1000.0))]
    max_residual_px: f64,
    /// Fewer agreeing views than this give no place.
    #[schemars(range(min = 2, max = 100))]
    least_views: usize,
}

impl Default for TriangulateMarkers {
    fn default() -> Self {
        let TriangulateOptions { noise_px, max_residual_px, least_views } = TriangulateOptions::default();
        Self { noise_px, max_residual_px, least_views }
    }
}

graph_core::register!(TriangulateMarkers);

#[typetag::serde(name = "triangulate_markers")]
impl Node for TriangulateMarkers {
    fn card(&self) -> Card {
        let card = Card::new("clean").takes(&VIEWS).takes(&CAMERAS);
        card.gives(&MARKERS).gives(&RESIDUAL).gives(&UNCERTAINTY).gives(&USED).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let Self { noise_px, max_residual_px, least_views } = *self;
        let options = TriangulateOptions { noise_px, max_residual_px, least_views };
        let found = triangulate(inputs.get(&VIEWS)?, inputs.get(&CAMERAS)?, &options).map_err(told)?;
        let numbers = [
            ("bad views", found.bad_views as f64),
            ("markers that views disagree on", found.disagreeing as f64),
            ("ambiguous markers", found.ambiguous as f64),
        ];
        context.progress(1.0, &numbers);
        Ok(Outputs::default()
            .with(&MARKERS, found.markers)
            .with(&RESIDUAL, found.residual_px)
            .with(&UNCERTAINTY, found.uncertainty_mm)
            .with(&USED, found.used_views))
    }
}

/// The error with the port or parameter that it is about.
fn told(error: TriangulateError) -> NodeError {
    match error {
        TriangulateError::NoCamera { .. } => NodeError::input(CAMERAS.name(), error),
        TriangulateError::Option { .. } => NodeError::parameter("noise_px", error),
        TriangulateError::Data(_) => NodeError::input(VIEWS.name(), error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{compute, made, test_data};
    use face_io::{camera_json, marker_csv, view_csv};
    use glam::Vec2;
    use serde_json::json;
    use std::fs;

    fn real() -> Option<(Cameras, Views, Markers)> {
        let folder = test_data("actors/ict_actor_a")?;
        let read = |name: &str| fs::read(folder.join(name)).unwrap();
        let cameras = camera_json::read(&read("cameras.json")).unwrap();
        let views = view_csv::open(&read("neutral_views.csv")).unwrap().into_views(None).unwrap();
        Some((cameras, views, marker_csv::read(&read("neutral_markers.csv"), Some(1.0)).unwrap()))
    }

    fn run(parameters: serde_json::Value, cameras: &Cameras, views: &Views) -> Result<Outputs, String> {
        let node: TriangulateMarkers = made(parameters);
        let inputs = Inputs::default().with(&VIEWS, views.clone()).with(&CAMERAS, cameras.clone());
        compute(&node, &inputs).map_err(|error| error.to_string())
    }

    /// Distances from the truth in millimetres, the least first, and how many markers are missing.
    fn errors_mm(found: &Outputs, truth: &Markers) -> (Vec<f32>, usize) {
        let markers = found.get(&MARKERS).unwrap();
        let apart =
            |(name, place): (&String, &glam::Vec3)| 1000.0 * place.distance(truth.frame(0)[truth.index(name).unwrap()]);
        let mut errors: Vec<f32> =
            markers.names().iter().zip(markers.frame(0)).map(apart).filter(|error| !error.is_nan()).collect();
        errors.sort_by(f32::total_cmp);
        let missing = markers.missing();
        (errors, missing)
    }

    #[test]
    fn real_views_give_the_neutral_markers() {
        let Some((cameras, views, truth)) = real() else { return };
        let found = run(json!({"noise_px": 0.15}), &cameras, &views).unwrap();
        let (errors, missing) = errors_mm(&found, &truth);
        assert_eq!(missing, 0);
        assert!(errors[errors.len() / 2] <= 0.05, "median {} mm", errors[errors.len() / 2]);
        // The uncertainty is told from the noise, and is what the errors are.
        let rms = |values: &[f32]| {
            (values.iter().map(|value| f64::from(*value).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
        };
        let ratio = rms(found.get(&UNCERTAINTY).unwrap().values()) / rms(&errors);
        assert!((0.8..1.3).contains(&ratio), "{ratio}");
        assert!(rms(found.get(&RESIDUAL).unwrap().values()) < 0.25);
    }

    #[test]
    fn one_view_in_twenty_moved_by_twenty_pixels_changes_little() {
        let Some((cameras, views, truth)) = real() else { return };
        for seed in 0..10 {
            let mut random = crate::random::Random::new(seed, 0);
            let mut points = views.points_px().to_vec();
            for point in points.iter_mut().filter(|point| !point.is_nan()) {
                if random.unit() < 0.05 {
                    *point += Vec2::from_angle(random.unit() as f32 * std::f32::consts::TAU) * 20.0;
                }
            }
            let found = run(json!({}), &cameras, &views.with_points(points).unwrap()).unwrap();
            let (errors, missing) = errors_mm(&found, &truth);
            let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
            assert!(median <= 0.05 && worst < 0.5 && missing <= 1, "{median} {worst} mm, {missing} missing");
        }
    }

    #[test]
    fn blocks_equal_the_whole_and_mistakes_are_named() {
        let Some((cameras, views, _)) = real() else { return };
        let mut points = Vec::new();
        for frame in 0..12 {
            points.extend(views.points_px().iter().map(|point| *point + Vec2::splat(frame as f32 * 0.7)));
        }
        let axis = wire::FrameAxis { first: 101, count: 12, rate_hz: 60.0 };
        let take = Views::new(axis, views.cameras().to_vec(), views.markers().to_vec(), points).unwrap();
        let whole = run(json!({}), &cameras, &take).unwrap();
        let block = run(json!({}), &cameras, &toy::cut(&take, 4..9)).unwrap();
        assert!(toy::same_bits(whole.get(&MARKERS).unwrap(), 4..9, block.get(&MARKERS).unwrap()));
        assert!(toy::same_bits(whole.get(&USED).unwrap(), 4..9, block.get(&USED).unwrap()));
        let fewer = Cameras::new(cameras.cameras()[1..].to_vec()).unwrap();
        let error = run(json!({}), &fewer, &take).unwrap_err();
        assert!(error.starts_with("input `cameras`: ") && error.contains("`cam0`"), "{error}");
    }
}
