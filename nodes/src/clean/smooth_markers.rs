//! `smooth_markers`: calms the jitter of captured markers; after gaps are filled, before anything is solved from them.

use face_math::data::Markers;
use glam::{DVec3, Vec3};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const MARKERS: Port<Markers> = Port::new("markers", "captured markers, in metres; missing points are NaN");
const CALM: Port<Markers> = Port::new("markers", "the same markers and frames, calmer; missing points stay missing");

/// Averages each marker with itself in the frames around, by a Gaussian: jitter goes, and nothing lags.
///
/// A Gaussian of `sigma_frames` σ passes slow motion and halves the power of what moves at √(ln 2) / 2π σ periods a
/// frame: with the default at 60 Hz that is 5.3 Hz, near the fastest that lips move in speech. Frames in which a marker
/// is missing take no part.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SmoothMarkers {
    /// Standard deviation of the Gaussian, in frames. More is calmer and rounds off quick motion; 0 changes nothing.
    #[schemars(range(min = 0.0, max = 100.0))]
    sigma_frames: f64,
}

impl Default for SmoothMarkers {
    fn default() -> Self {
        Self { sigma_frames: 1.5 }
    }
}

graph_core::register!(SmoothMarkers);

impl SmoothMarkers {
    /// Frames on either side that the Gaussian reaches: four standard deviations, beyond which its weight is below 0.0004.
    fn reach(&self) -> usize {
        (4.0 * self.sigma_frames).ceil() as usize
    }
}

#[typetag::serde(name = "smooth_markers")]
impl Node for SmoothMarkers {
    fn card(&self) -> Card {
        Card::new("clean").takes(&MARKERS).gives(&CALM).per_frame(self.reach())
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let markers = inputs.get(&MARKERS)?;
        let reach = self.reach();
        // wₖ = exp(−k² / 2 σ²) for the frame k frames away.
        let weights: Vec<f64> = (0..=reach)
            .map(|k| if k == 0 { 1.0 } else { (-0.5 * (k as f64 / self.sigma_frames).powi(2)).exp() })
            .collect();
        let width = markers.names().len();
        let mut positions = Vec::with_capacity(markers.positions().len());
        for frame in 0..markers.frames() {
            context.go_on()?;
            let window = frame.saturating_sub(reach)..(frame + reach + 1).min(markers.frames());
            for marker in 0..width {
                if markers.frame(frame)[marker].is_nan() {
                    positions.push(Vec3::NAN);
                    continue;
                }
                let (mut sum, mut total) = (DVec3::ZERO, 0.0);
                for other in window.clone() {
                    let point = markers.frame(other)[marker];
                    if !point.is_nan() {
                        let weight = weights[other.abs_diff(frame)];
                        sum += weight * point.as_dvec3();
                        total += weight;
                    }
                }
                positions.push((sum / total).as_vec3());
            }
        }
        let calm = markers.with_positions(positions).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&CALM, calm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::compute;
    use wire::FrameAxis;

    fn line(points: Vec<Vec3>) -> Markers {
        Markers::new(FrameAxis::new(points.len(), 60.0), vec!["chin".into()], points).unwrap()
    }

    fn smoothed(markers: Markers, sigma_frames: f64) -> Markers {
        let outputs = compute(&SmoothMarkers { sigma_frames }, &Inputs::default().with(&MARKERS, markers)).unwrap();
        outputs.get(&CALM).unwrap().clone()
    }

    #[test]
    fn even_motion_stays_and_gaps_stay() {
        let mut points: Vec<Vec3> = (0..40).map(|t| Vec3::new(t as f32 * 0.001, 0.1, 0.0)).collect();
        points[20] = Vec3::NAN;
        let calm = smoothed(line(points.clone()), 1.5);
        for (frame, point) in points.iter().enumerate().take(14).skip(6) {
            assert!((calm.frame(frame)[0] - *point).length() < 1e-6, "frame {frame}");
        }
        assert!(calm.frame(20)[0].is_nan());
        assert_eq!(smoothed(line(points[..20].to_vec()), 0.0).positions(), &points[..20]);
    }

    #[test]
    fn white_noise_falls_by_the_norm_of_the_kernel() {
        // The variance of a weighted mean of white noise is Σw² / (Σw)², for a Gaussian about 1 / 2 σ √π.
        let mut random = crate::random::Random::new(1, 0);
        let points: Vec<Vec3> = (0..4000).map(|_| Vec3::new(random.unit() as f32 - 0.5, 0.0, 0.0)).collect();
        let power =
            |markers: &Markers| markers.positions().iter().map(|p| f64::from(p.x).powi(2)).sum::<f64>() / 4000.0;
        let raw = line(points);
        let ratio = power(&smoothed(raw.clone(), 1.5)) / power(&raw);
        assert!((ratio - 1.0 / (3.0 * std::f64::consts::PI.sqrt())).abs() < 0.02, "{ratio}");
    }
}
