//! Markers of several cameras to markers in space, frame by frame: what a capture begins with.
//!
//! Each marker of each frame stands alone ([`locate`]), so that takes are triangulated block by block.

use super::point::{Sight, TriangulateOptions, Unfound, locate};
use crate::data::{CalibratedCamera, Cameras, Curves, DataError, Markers, Views, nearest_name};
use glam::Vec3;

/// The outcome of [`triangulate`].
#[derive(Debug, Clone, PartialEq)]
pub struct Triangulated {
    /// The markers, in metres; those without a place are missing (NaN).
    pub markers: Markers,
    /// For each marker, the root mean square distance in pixels at which the views that were used see it; NaN where it is
    /// missing.
    pub residual_px: Curves,
    /// For each marker, the distance from its true place that noise leads one to expect, root mean square, in
    /// millimetres; NaN where it is missing.
    pub uncertainty_mm: Curves,
    /// For each marker, how many views were used; 0 where it is missing.
    pub used_views: Curves,
    /// Views that were seen and counted as bad, over all markers and frames.
    pub bad_views: usize,
    /// Markers that some cameras saw, but too few that agree.
    pub disagreeing: usize,
    /// Markers with two places that are explained equally well.
    pub ambiguous: usize,
}

/// Why views cannot be triangulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TriangulateError {
    /// The views name a camera that is not calibrated.
    #[error("the views name camera `{camera}`, which is not among the calibrated ones{}", near.as_ref().map(|near| format!("; did you mean `{near}`?")).unwrap_or_default())]
    NoCamera {
        /// The camera.
        camera: String,
        /// The nearest name there is.
        near: Option<String>,
    },
    /// An option is no positive number.
    #[error("{what} is {value} px; give a positive number")]
    Option {
        /// The option.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The results do not fit together.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// Triangulates all markers of all frames of `views`.
///
/// # Errors
/// Where the views name a camera that `cameras` lack, or an option is not positive.
pub fn triangulate(
    views: &Views,
    cameras: &Cameras,
    options: &TriangulateOptions,
) -> Result<Triangulated, TriangulateError> {
    let numbers = [("the noise of a view", options.noise_px), ("the largest residual", options.max_residual_px)];
    if let Some((what, value)) = numbers.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
        return Err(TriangulateError::Option { what, value });
    }
    let calibrated = views.cameras().iter().map(|name| {
        cameras.camera(name).ok_or_else(|| {
            let names = cameras.names();
            let near = nearest_name(name, names.iter().map(String::as_str));
            TriangulateError::NoCamera { camera: name.clone(), near }
        })
    });
    let calibrated: Vec<&CalibratedCamera> = calibrated.collect::<Result<_, _>>()?;
    let count = views.frames() * views.markers().len();
    let mut positions = Vec::with_capacity(count);
    let (mut residuals, mut uncertainties, mut used_views) = (Vec::new(), Vec::new(), Vec::new());
    let (mut bad_views, mut disagreeing, mut ambiguous) = (0, 0, 0);
    for frame in 0..views.frames() {
        for marker in 0..views.markers().len() {
            let seen = calibrated.iter().enumerate().filter_map(|(index, camera)| {
                Some(Sight { camera, point_px: views.at(frame, index, marker)?.as_dvec2() })
            });
            let sights: Vec<_> = seen.collect();
            match locate(&sights, options) {
                Ok(found) => {
                    let used = found.used.iter().filter(|used| **used).count();
                    positions.push(found.place_m.as_vec3());
                    residuals.push(found.residual_px as f32);
                    uncertainties.push(found.uncertainty_mm as f32);
                    used_views.push(used as f32);
                    bad_views += sights.len() - used;
                }
                Err(reason) => {
                    positions.push(Vec3::NAN);
                    residuals.push(f32::NAN);
                    uncertainties.push(f32::NAN);
                    used_views.push(0.0);
                    disagreeing += usize::from(reason == Unfound::Disagree);
                    ambiguous += usize::from(reason == Unfound::Ambiguous);
                }
            }
        }
    }
    let (axis, names) = (views.frame_axis(), views.markers().to_vec());
    Ok(Triangulated {
        markers: Markers::new(axis, names.clone(), positions)?,
        residual_px: Curves::new(axis, names.clone(), residuals)?,
        uncertainty_mm: Curves::new(axis, names.clone(), uncertainties)?,
        used_views: Curves::new(axis, names, used_views)?,
        bad_views,
        disagreeing,
        ambiguous,
    })
}

#[cfg(test)]
mod tests {
    use super::super::lens::{project, tests::camera};
    use super::*;
    use glam::{DVec3, Vec2};
    use wire::FrameAxis;

    fn seen(cameras: &Cameras, places: &[DVec3]) -> Views {
        let names = (0..places.len()).map(|index| format!("m{index}")).collect();
        let points = cameras
            .cameras()
            .iter()
            .flat_map(|camera| places.iter().map(move |place| project(camera, *place).unwrap().point_px.as_vec2()));
        Views::new(FrameAxis::new(1, 60.0), cameras.names(), names, points.collect()).unwrap()
    }

    #[test]
    fn markers_come_back_with_their_views_and_missing_ones_stay_missing() {
        let cameras = Cameras::new(vec![camera("a", -0.5), camera("b", 0.0), camera("c", 0.5)]).unwrap();
        let places = [DVec3::new(0.01, 0.02, 0.05), DVec3::new(-0.03, 0.0, 0.04), DVec3::ZERO];
        let views = seen(&cameras, &places);
        let mut points = views.points_px().to_vec();
        points[2] = Vec2::NAN;
        points[5] = Vec2::NAN;
        points[1] += Vec2::new(0.0, 40.0);
        let views = views.with_points(points).unwrap();
        let found = triangulate(&views, &cameras, &TriangulateOptions::default()).unwrap();
        assert!(found.markers.frame(0)[0].distance(places[0].as_vec3()) < 1e-6);
        assert!(found.markers.frame(0)[1].distance(places[1].as_vec3()) < 1e-6);
        assert!(found.markers.frame(0)[2].is_nan() && found.residual_px.frame(0)[2].is_nan());
        assert_eq!(found.used_views.frame(0).iter().map(|used| *used as u32).collect::<Vec<_>>(), [3, 2, 0]);
        assert_eq!((found.bad_views, found.disagreeing, found.ambiguous), (1, 0, 0));
    }

    #[test]
    fn unknown_cameras_and_bad_options_are_named() {
        let cameras = Cameras::new(vec![camera("head_left", 0.0), camera("head_right", 0.5)]).unwrap();
        let other = Cameras::new(vec![camera("head_left", 0.0), camera("head_rigth", 0.5)]).unwrap();
        let views = seen(&cameras, &[DVec3::ZERO]);
        let error = triangulate(&views, &other, &TriangulateOptions::default()).unwrap_err().to_string();
        assert!(error.contains("`head_right`") && error.contains("did you mean `head_rigth`?"), "{error}");
        let options = TriangulateOptions { noise_px: 0.0, ..Default::default() };
        assert!(triangulate(&views, &cameras, &options).is_err());
    }
}
