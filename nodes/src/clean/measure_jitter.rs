//! `measure_jitter`: how noisy each marker is, told from takes; what `add_jitter` and `finetune_curves` are given.

use crate::patterns::Patterns;
use face_math::data::{MarkerNoise, Markers, NoiseOfMarker};
use face_math::solve::{NEEDED_RUNS, measure_jitter};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const TAKES: Port<Markers> =
    Port::new("markers", "one take or several, in metres, as tracked: neither smoothed nor filled");
const NOISE: Port<MarkerNoise> =
    Port::new("noise", "standard deviation of a coordinate of each marker, in millimetres");

/// Measures the noise of tracked markers, from the takes themselves.
///
/// Faces move smoothly, noise is new in every frame: what is left of each coordinate after all motion up to a cubic is
/// taken out is noise. Its middle size over all frames counts, so that blinks and a few bad frames do not. Head motion
/// does not matter. Several takes are measured together.
///
/// Markers that are seen too briefly (in fewer than `needed_runs` runs of five frames) are left out; nodes that are given
/// the noise then go by their own `sigma_mm`.
///
/// Sizes are rounded by `rounding`, so that an edit of a frame, or one more take, mostly leaves them as they are, and
/// nothing that rests on them is computed again.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeasureJitter {
    /// Markers to measure, as patterns: `lip_*`. All where empty.
    only: Vec<String>,
    /// Step of the sizes that are told apart, as a share: 0.1 has 0.1 mm followed by 0.11 mm. 0 does not round.
    #[schemars(range(min = 0.0, max = 1.0))]
    rounding: f64,
    /// Least number of runs of five seen frames to tell the noise of a marker from; 50 are good to about a sixth.
    #[schemars(range(min = 1, max = 1_000_000))]
    needed_runs: usize,
}

impl Default for MeasureJitter {
    fn default() -> Self {
        Self { only: Vec::new(), rounding: 0.2, needed_runs: NEEDED_RUNS }
    }
}

graph_core::register!(MeasureJitter);

#[typetag::serde(name = "measure_jitter")]
impl Node for MeasureJitter {
    fn card(&self) -> Card {
        Card::new("clean").gathers(&TAKES).gives(&NOISE)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        context.go_on()?;
        let takes: Vec<&Markers> = inputs.items(&TAKES)?.into_iter().map(|(_, take)| take).collect();
        let mut measured = measure_jitter(&takes, self.needed_runs);
        if !self.only.is_empty() {
            let mut names: Vec<String> = takes.iter().flat_map(|take| take.names()).cloned().collect();
            names.sort_unstable();
            names.dedup();
            let kept = Patterns { parameter: "only", what: "marker", names: &names }.chosen(&self.only)?;
            measured.retain(|one| kept.contains(&one.marker));
        }
        let noise = measured
            .into_iter()
            .map(|one| NoiseOfMarker { marker: one.marker, sigma_mm: self.rounded(one.sigma_mm) })
            .collect();
        let noise = MarkerNoise::new(noise).map_err(|error| NodeError::input(TAKES.name(), error))?;
        Ok(Outputs::default().with(&NOISE, noise))
    }
}

/// Below this, in millimetres, there is no noise but the rounding of files.
const STILL_MM: f64 = 1e-4;

impl MeasureJitter {
    /// The nearest power of 1 + rounding, to six digits.
    fn rounded(&self, sigma_mm: f64) -> f64 {
        if sigma_mm < STILL_MM {
            return 0.0;
        }
        if self.rounding <= 0.0 {
            return sigma_mm;
        }
        let step = (1.0 + self.rounding).ln();
        let near = ((sigma_mm.ln() / step).round() * step).exp();
        (near * 1e6).round() / 1e6
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::testing::{compute, made, test_data};
    use face_io::c3d;
    use glam::Vec3;
    use serde_json::json;
    use std::fs;
    use wire::FrameAxis;

    fn measure(parameters: serde_json::Value, takes: &[&Markers]) -> Result<MarkerNoise, String> {
        let node: MeasureJitter = made(parameters);
        let items = takes.iter().enumerate().map(|(index, take)| (format!("take{index}"), (*take).clone()));
        let outputs = compute(&node, &Inputs::default().with_list(&TAKES, items));
        outputs.map(|outputs| outputs.get(&NOISE).unwrap().clone()).map_err(|error| error.to_string())
    }

    fn take(frames: usize, seed: u64) -> Markers {
        let mut random = Random::new(seed, 0);
        let mut positions = Vec::new();
        for frame in 0..frames {
            let path = Vec3::new(0.01 * (frame as f32 * 0.05).sin(), 0.2, 0.0);
            positions.extend([0.05, 0.2].map(|sigma_mm| path + (random.vector() * sigma_mm * 1e-3).as_vec3()));
        }
        Markers::new(FrameAxis::new(frames, 60.0), vec!["brow".into(), "chin".into()], positions).unwrap()
    }

    #[test]
    fn noise_is_measured_over_all_takes() {
        let (first, second) = (take(40, 1), take(40, 2));
        assert!(measure(json!({}), &[&first]).unwrap().markers().is_empty(), "36 runs are too few");
        let noise = measure(json!({"rounding": 0.0}), &[&first, &second, &take(2000, 3)]).unwrap();
        assert!((noise.sigma_mm("brow").unwrap() - 0.05).abs() < 0.005, "{noise:?}");
        assert!((noise.sigma_mm("chin").unwrap() - 0.2).abs() < 0.02, "{noise:?}");
        let some = measure(json!({"only": ["ch*"]}), &[&take(2000, 3)]).unwrap();
        assert_eq!(some.markers().len(), 1);
        assert!(measure(json!({"only": ["lip"]}), &[&first]).unwrap_err().contains("`only`"));
    }

    #[test]
    fn rounding_keeps_what_an_edited_frame_hardly_changes() {
        let node: MeasureJitter = made(json!({"rounding": 0.1}));
        assert!((node.rounded(0.2) / 0.2 - 1.0).abs() <= 0.05);
        assert_eq!(node.rounded(0.1).to_bits(), node.rounded(0.1001).to_bits());
        assert_eq!(node.rounded(1e-7).to_bits(), 0.0_f64.to_bits());
        let exact: MeasureJitter = made(json!({"rounding": 0.0}));
        assert_eq!(exact.rounded(0.123_456_789).to_bits(), 0.123_456_789_f64.to_bits());
    }

    #[test]
    fn an_edited_frame_of_a_real_take_leaves_the_noise_as_it_is() {
        let Some(path) = test_data("actors/ict_actor_a/takes/day1_161.c3d") else { return };
        let take = c3d::read(&fs::read(path).unwrap()).unwrap();
        let noise = measure(json!({}), &[&take]).unwrap();
        let (brow, chin) = (noise.sigma_mm("brow_L_2").unwrap(), noise.sigma_mm("jawline_08").unwrap());
        assert!((0.04..0.06).contains(&brow) && (0.15..0.25).contains(&chin), "{brow} {chin}");
        let width = take.names().len();
        let (mut kept, mut all) = (0, 0);
        for marker in (0..width).step_by(5) {
            let mut positions = take.positions().to_vec();
            positions[1000 * width + marker].x += 0.001;
            all += 1;
            kept += usize::from(measure(json!({}), &[&take.with_positions(positions).unwrap()]).unwrap() == noise);
        }
        assert!(kept + 1 >= all, "{kept} of {all}");
    }
}
