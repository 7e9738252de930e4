//! `add_jitter`: training markers several times over, with the noise that captured ones have (section 4.1 of FDLS).

use crate::patterns::Patterns;
use crate::random::Random;
use face_math::data::{Curves, MarkerNoise, Markers};
use glam::{DQuat, DVec3, Vec3};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::FrameAxis;

const MARKERS: Port<Markers> = Port::new("markers", "exact markers, in metres");
const CURVES: Port<Curves> = Port::new("curves", "the weights that made them, to be repeated beside the copies");
const NOISE: Port<MarkerNoise> = Port::new(
    "noise",
    "measured noise of the markers (`measure_jitter`); `by_marker` goes before it, `sigma_mm` after it",
);
const JITTERED: Port<Markers> = Port::new("markers", "the noisy copies, one behind the other, in metres");
const REPEATED: Port<Curves> =
    Port::new("curves", "the weights of the same frames; no channels where no curves came in");

/// Oversamples training data: gives noisy copies of the markers, x + N(0, Σ), and the same weights beside each.
///
/// Networks that saw noise in training do not lean on differences that noise can make. The noise is Gaussian, alike in
/// x, y and z, and of its own size for each marker: captured markers shake the least at brow and nose bridge and the most
/// around mouth and chin. Measure it (`measure_jitter`) and connect it to `noise` rather than guess.
///
/// With `slip_deg` and `slip_mm`, each copy is also moved as a whole, as the mask or the head camera slips.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AddJitter {
    /// Number of noisy copies.
    #[schemars(range(min = 1, max = 1000))]
    copies: usize,
    /// Whether the exact markers stand before the copies.
    keep_exact: bool,
    /// Noise of markers that neither `by_marker` nor what is connected to `noise` names: standard deviation of each
    /// coordinate in millimetres.
    #[schemars(range(min = 0.0, max = 100.0))]
    sigma_mm: f64,
    /// Noise of certain markers, by name or pattern: `{"brow_*": 0.05, "jawline_*": 0.2}`. A name goes before a pattern, a
    /// longer pattern before a shorter one.
    by_marker: BTreeMap<String, f64>,
    /// Turns all markers about their middle by this many degrees, about a random axis.
    #[schemars(range(min = 0.0, max = 180.0))]
    slip_deg: f64,
    /// Moves all markers by this many millimetres, in a random direction.
    #[schemars(range(min = 0.0, max = 1000.0))]
    slip_mm: f64,
    /// How the slip goes on.
    slip: Slip,
    /// Where the random numbers come from; each copy has its own.
    #[schemars(range(max = 1_000_000_000))]
    seed: u64,
}

/// How a slip goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Slip {
    /// The same in all frames of a copy, by exactly `slip_deg` and `slip_mm`.
    Constant,
    /// Another in every frame: `slip_deg` and `slip_mm` are then standard deviations.
    PerFrame,
}

impl Default for AddJitter {
    fn default() -> Self {
        Self {
            copies: 1,
            keep_exact: false,
            sigma_mm: 0.1,
            by_marker: BTreeMap::new(),
            slip_deg: 0.0,
            slip_mm: 0.0,
            slip: Slip::Constant,
            seed: 0,
        }
    }
}

graph_core::register!(AddJitter);

#[typetag::serde(name = "add_jitter")]
impl Node for AddJitter {
    fn card(&self) -> Card {
        Card::new("solve").takes(&MARKERS).may_take(&CURVES).may_take(&NOISE).gives(&JITTERED).gives(&REPEATED)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let exact = inputs.get(&MARKERS)?;
        let curves = inputs.may_get(&CURVES)?;
        if let Some(curves) = curves {
            exact.frame_axis().matches(&curves.frame_axis()).map_err(|error| NodeError::input(CURVES.name(), error))?;
        }
        let sigmas_m = self.sigmas_m(exact, inputs.may_get(&NOISE)?)?;
        let rounds = self.copies + usize::from(self.keep_exact);
        let channels = curves.map_or(0, |curves| curves.channels().len());
        let frame_bytes = size_of_val(exact.positions()) / exact.frames().max(1) + channels * size_of::<f32>();
        context.claim("copies", (rounds * exact.frames()).saturating_mul(frame_bytes))?;
        let mut positions = Vec::with_capacity(rounds * exact.positions().len());
        if self.keep_exact {
            positions.extend_from_slice(exact.positions());
        }
        for copy in 0..self.copies {
            self.copy(context, exact, &sigmas_m, copy, &mut positions)?;
        }
        let axis = FrameAxis { count: rounds * exact.frames(), ..exact.frame_axis() };
        let jittered = Markers::new(axis, exact.names().to_vec(), positions).map_err(NodeError::failed)?;
        let channels = curves.map_or(Vec::new(), |curves| curves.channels().to_vec());
        let values = curves.map_or(Vec::new(), |curves| curves.values().repeat(rounds));
        let repeated = Curves::new(axis, channels, values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&JITTERED, jittered).with(&REPEATED, repeated))
    }
}

/// What a slip does to a frame: x ↦ R (x − c) + c + t, about the markers' middle c.
struct Motion {
    turn: DQuat,
    middle: DVec3,
    shift: DVec3,
}

impl AddJitter {
    fn sigmas_m(&self, markers: &Markers, noise: Option<&MarkerNoise>) -> Result<Vec<f64>, NodeError> {
        for (pattern, sigma) in &self.by_marker {
            if !(*sigma >= 0.0 && sigma.is_finite()) {
                let problem = format!("the noise of `{pattern}` is {sigma} mm; give 0 or more");
                return Err(NodeError::parameter("by_marker", problem));
            }
        }
        let patterns = Patterns { parameter: "by_marker", what: "marker", names: markers.names() };
        let own = patterns.numbers(&self.by_marker)?;
        let measured = |name: &String| noise.and_then(|noise| noise.sigma_mm(name));
        let sigmas = markers.names().iter().zip(own);
        Ok(sigmas.map(|(name, own)| own.or_else(|| measured(name)).unwrap_or(self.sigma_mm) / 1000.0).collect())
    }

    fn copy(
        &self,
        context: &Context<'_>,
        exact: &Markers,
        sigmas_m: &[f64],
        copy: usize,
        positions: &mut Vec<Vec3>,
    ) -> Result<(), NodeError> {
        let mut noise = Random::new(self.seed, 2 * copy as u64);
        let mut slips = Random::new(self.seed, 2 * copy as u64 + 1);
        let middle = middle(exact.positions());
        let mut motion = self.motion(&mut slips, middle, (1.0, 1.0));
        for frame in 0..exact.frames() {
            if frame % 64 == 0 {
                context.go_on()?;
                let done = (copy * exact.frames() + frame) as f64 / (self.copies * exact.frames()) as f64;
                context.progress(done, &[]);
            }
            if self.slip == Slip::PerFrame {
                let by = (slips.normal(), slips.normal());
                motion = self.motion(&mut slips, middle, by);
            }
            for (point, sigma_m) in exact.frame(frame).iter().zip(sigmas_m) {
                let shaken = motion.apply(point.as_dvec3()) + *sigma_m * noise.vector();
                positions.push(if point.is_nan() { Vec3::NAN } else { shaken.as_vec3() });
            }
        }
        Ok(())
    }

    fn motion(&self, slips: &mut Random, middle: DVec3, (turned, moved): (f64, f64)) -> Motion {
        let turn = slips.turn(turned * self.slip_deg.to_radians());
        Motion { turn, middle, shift: moved * self.slip_mm / 1000.0 * slips.direction() }
    }
}

impl Motion {
    fn apply(&self, point: DVec3) -> DVec3 {
        if self.turn == DQuat::IDENTITY {
            return point + self.shift;
        }
        self.turn * (point - self.middle) + self.middle + self.shift
    }
}

/// The mean of all points that are there.
fn middle(points: &[Vec3]) -> DVec3 {
    let seen = points.iter().filter(|point| point.is_finite());
    let (sum, count) = seen.fold((DVec3::ZERO, 0_usize), |(sum, count), point| (sum + point.as_dvec3(), count + 1));
    sum / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{Bench, compute, made};
    use face_math::data::NoiseOfMarker;
    use face_math::rig::fit_rigid;
    use serde_json::json;

    fn exact(frames: usize) -> Markers {
        let mut dice = toy::Dice(5);
        let names = ["brow_1", "brow_2", "chin"].map(str::to_owned).to_vec();
        let positions = (0..frames * 3).map(|_| dice.point() * 0.05).collect();
        Markers::new(FrameAxis { first: 11, count: frames, rate_hz: 60.0 }, names, positions).unwrap()
    }

    fn jitter(parameters: serde_json::Value, markers: &Markers) -> Result<Markers, String> {
        let node: AddJitter = made(parameters);
        let outputs = compute(&node, &Inputs::default().with(&MARKERS, markers.clone()));
        outputs.map(|outputs| outputs.get(&JITTERED).unwrap().clone()).map_err(|error| error.to_string())
    }

    /// Standard deviation of the noise of one marker, in millimetres.
    fn spread_mm(noisy: &Markers, exact: &Markers, marker: usize) -> f64 {
        let differences = (0..noisy.frames()).map(|frame| {
            let own = exact.frame(frame % exact.frames())[marker];
            (noisy.frame(frame)[marker] - own).as_dvec3().length_squared()
        });
        (differences.sum::<f64>() / noisy.frames() as f64 / 3.0).sqrt() * 1000.0
    }

    #[test]
    fn each_marker_gets_its_own_noise() {
        let exact = exact(2000);
        let with = json!({"copies": 2, "sigma_mm": 0.1, "by_marker": {"brow_*": 0.05, "brow_2": 0.0}});
        let noisy = jitter(with, &exact).unwrap();
        assert_eq!(noisy.frames(), 4000);
        assert!((spread_mm(&noisy, &exact, 0) - 0.05).abs() < 0.002);
        assert!(spread_mm(&noisy, &exact, 1) < 1e-5);
        assert!((spread_mm(&noisy, &exact, 2) - 0.1).abs() < 0.004);
        assert_ne!(noisy.frame(0), noisy.frame(2000), "copies differ");
    }

    #[test]
    fn measured_noise_stands_between_the_table_and_the_rest() {
        let exact = exact(2000);
        let one = |marker: &str, sigma_mm| NoiseOfMarker { marker: marker.to_owned(), sigma_mm };
        let noise = MarkerNoise::new(vec![one("brow_1", 0.3), one("brow_2", 0.2)]).unwrap();
        let node: AddJitter = made(json!({"sigma_mm": 0.1, "by_marker": {"brow_2": 0.05}}));
        let inputs = Inputs::default().with(&MARKERS, exact.clone()).with(&NOISE, noise);
        let outputs = compute(&node, &inputs).unwrap();
        for (marker, expected) in [0.3, 0.05, 0.1].into_iter().enumerate() {
            let found = spread_mm(outputs.get(&JITTERED).unwrap(), &exact, marker);
            assert!((found / expected - 1.0).abs() < 0.05, "{marker}: {found} mm");
        }
    }

    #[test]
    fn the_seed_decides_and_weights_are_repeated() {
        let exact = exact(20);
        let curves = Curves::new(exact.frame_axis(), vec!["a".into()], (0..20).map(|f| f as f32).collect()).unwrap();
        let node: AddJitter = made(json!({"copies": 2, "keep_exact": true, "seed": 4}));
        let inputs = Inputs::default().with(&MARKERS, exact.clone()).with(&CURVES, curves.clone());
        let outputs = compute(&node, &inputs).unwrap();
        let noisy = outputs.get(&JITTERED).unwrap();
        assert_eq!(noisy.positions()[..60], exact.positions()[..]);
        assert_eq!(outputs.get(&REPEATED).unwrap().values(), curves.values().repeat(3));
        assert_eq!(outputs.get(&REPEATED).unwrap().frame_axis(), noisy.frame_axis());
        let again = compute(&node, &inputs).unwrap();
        assert_eq!(again.get(&JITTERED), Some(noisy));
        let other: AddJitter = made(json!({"copies": 2, "keep_exact": true, "seed": 5}));
        assert_ne!(compute(&other, &inputs).unwrap().get(&JITTERED), Some(noisy));
        let alone = compute(&node, &Inputs::default().with(&MARKERS, exact)).unwrap();
        assert!(alone.get(&REPEATED).unwrap().channels().is_empty());
    }

    #[test]
    fn a_slip_is_rigid_and_of_the_size_asked_for() {
        let exact = exact(10);
        let slipped = jitter(json!({"sigma_mm": 0.0, "slip_deg": 2.0, "slip_mm": 3.0}), &exact).unwrap();
        let middle_before = middle(exact.positions());
        assert!(((middle(slipped.positions()) - middle_before).length() - 0.003).abs() < 1e-6);
        for frame in 0..10 {
            let (a, b) = (exact.frame(frame), slipped.frame(frame));
            assert!((a[0].distance(a[2]) - b[0].distance(b[2])).abs() < 1e-6);
        }
        let turned = jitter(json!({"sigma_mm": 0.0, "slip_deg": 2.0}), &exact).unwrap();
        let points = |markers: &Markers| markers.frame(4).iter().map(|point| point.as_dvec3()).collect::<Vec<_>>();
        let fit = fit_rigid(&points(&exact), &points(&turned), None).unwrap();
        assert!((fit.motion.angle_rad().to_degrees() - 2.0).abs() < 1e-3 && fit.residual_rms_m < 1e-7);
        let per_frame = json!({"sigma_mm": 0.0, "slip_mm": 3.0, "slip": "per_frame"});
        let moving = jitter(per_frame, &exact).unwrap();
        let shift = |frame: usize| moving.frame(frame)[0] - exact.frame(frame)[0];
        assert!(!shift(0).abs_diff_eq(shift(1), 1e-6));
    }

    #[test]
    fn missing_markers_stay_missing_and_do_not_shift_the_noise_of_others() {
        let exact = exact(3);
        let mut positions = exact.positions().to_vec();
        positions[1] = Vec3::NAN;
        let gappy = exact.with_positions(positions).unwrap();
        let (whole, gaps) = (jitter(json!({}), &exact).unwrap(), jitter(json!({}), &gappy).unwrap());
        assert!(gaps.frame(0)[1].is_nan());
        assert_eq!(gaps.frame(1), whole.frame(1));
    }

    #[test]
    fn bad_parameters_and_inputs_are_named_and_cancelling_stops() {
        let exact = exact(3);
        assert!(jitter(json!({"by_marker": {"chn": 1.0}}), &exact).unwrap_err().contains("did you mean `chin`?"));
        assert!(jitter(json!({"by_marker": {"chin": -1.0}}), &exact).unwrap_err().contains("`chin` is -1 mm"));
        let other = Curves::new(FrameAxis::new(2, 60.0), vec!["a".into()], vec![0.0; 2]).unwrap();
        let inputs = Inputs::default().with(&MARKERS, exact).with(&CURVES, other);
        let error = compute(&AddJitter::default(), &inputs).unwrap_err().to_string();
        assert!(error.contains("`curves`") && error.contains("3 frames beside 2 frames"), "{error}");
        let stopped = Bench::default().cancelled_after(0).compute(&AddJitter::default(), &inputs);
        assert!(stopped.is_err());
    }
}
