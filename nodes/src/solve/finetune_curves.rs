//! `finetune_curves`: moves raw weights until the puppet's markers meet the captured ones (section 4.5 of FDLS); the last
//! step of a solve.

use super::frames::Frames;
use crate::patterns::Patterns;
use crate::rig::frame_number;
use face_math::data::{Attachment, Curves, Driver, MarkerNoise, Markers, Rig};
use face_math::rig::MarkerRig;
use face_math::solve::{FinetuneError, FinetuneOptions, finetune};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
use wire::{Data, Value};

const RAW: Port<Curves> =
    Port::new("curves", "the raw solve: weights of every channel of the rig; other channels pass through");
const MARKERS: Port<Markers> = Port::new("markers", "the captured markers, in metres; missing ones are passed over");
const RIG: Port<Rig> = Port::new("rig", "the puppet");
const ATTACHMENT: Port<Attachment> = Port::new("attachment", "where the markers sit on it");
const NOISE: Port<MarkerNoise> = Port::new(
    "noise",
    "measured noise of the markers as captured (`measure_jitter`); `by_marker` goes before it, `sigma_mm` after it",
);
const TUNED: Port<Curves> = Port::new("curves", "the same channels and frames, fine-tuned");

/// Fine-tunes a raw solve, frame by frame: looks for the weights that are most probable by the captured markers and the raw
/// solve together.
///
/// How far each side is trusted is said in its own terms: markers by their noise (`noise`, or `by_marker`), the raw solve
/// by its error (`raw_error`, `error_by_channel`). Where markers say little of a channel, the raw solve keeps its say. An
/// artist may leave it to certain channels, markers and frames.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FinetuneCurves {
    /// Channels to move, as patterns: `mouth*`. All channels of the rig where empty.
    channels: Vec<String>,
    /// Markers to match, as patterns: `lip_*`. All that are both captured and on the rig where empty.
    markers: Vec<String>,
    /// Frames to fine-tune, as the take numbers them: `1001-1100x2,1200`. All where empty; others keep the raw solve.
    frames: Frames,
    /// Over how many frames beyond each end of a range fine-tuning fades into the raw solve (half a cosine), so that
    /// curves do not jump there.
    #[schemars(range(min = 0, max = 10_000))]
    falloff_frames: u32,
    /// Whether the jaw stays as it is, once it is settled.
    hold_jaw: bool,
    /// The channels that `hold_jaw` holds, as patterns. Where empty, those that move the rig's jaw (see `skin_jaw`).
    jaw_channels: Vec<String>,
    /// Noise of markers that neither `by_marker` nor what is connected to `noise` names: standard deviation of each
    /// coordinate in millimetres.
    #[schemars(range(min = 0.000_001, max = 1000.0))]
    sigma_mm: f64,
    /// Noise of certain markers, by name or pattern, in millimetres: `{"brow_*": 0.05, "jawline_*": 0.2}`. A name goes
    /// before a pattern, a longer pattern before a shorter one.
    by_marker: BTreeMap<String, f64>,
    /// Measured noise below this counts as this, in millimetres: however quiet a marker is, the puppet meets it no better.
    #[schemars(range(min = 0.000_001, max = 1000.0))]
    least_noise_mm: f64,
    /// What is left of that noise, as a share: markers that `smooth_markers` calmed over s frames keep about 0.53 / √s of
    /// it.
    #[schemars(range(min = 0.000_001, max = 1000.0))]
    noise_scale: f64,
    /// Error of the raw solve in channels that `error_by_channel` does not name: root mean square, in weights. Smaller
    /// holds the raw solve, larger follows the markers.
    #[schemars(range(min = 0.000_001, max = 1000.0))]
    raw_error: f64,
    /// Error of the raw solve in certain channels, by name or pattern: `{"eye*": 0.03}`.
    error_by_channel: BTreeMap<String, f64>,
    /// The least weight of a moved channel.
    #[schemars(range(min = -100.0, max = 100.0))]
    low: f64,
    /// The largest weight of a moved channel.
    #[schemars(range(min = -100.0, max = 100.0))]
    high: f64,
}

impl Default for FinetuneCurves {
    fn default() -> Self {
        let usual = FinetuneOptions::default();
        Self {
            channels: Vec::new(),
            markers: Vec::new(),
            frames: Frames::default(),
            falloff_frames: 0,
            hold_jaw: false,
            jaw_channels: Vec::new(),
            sigma_mm: usual.default_noise_mm,
            by_marker: BTreeMap::new(),
            least_noise_mm: 0.02,
            noise_scale: 1.0,
            raw_error: usual.default_raw_error,
            error_by_channel: BTreeMap::new(),
            low: usual.low,
            high: usual.high,
        }
    }
}

graph_core::register!(FinetuneCurves);

#[typetag::serde(name = "finetune_curves")]
impl Node for FinetuneCurves {
    fn card(&self) -> Card {
        let card = Card::new("solve").takes(&RAW).takes(&MARKERS).takes(&RIG).takes(&ATTACHMENT).may_take(&NOISE);
        card.gives(&TUNED).per_frame(0)
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let (raw, captured, rig) = (inputs.get(&RAW)?, inputs.get(&MARKERS)?, inputs.get(&RIG)?);
        let axis = raw.frame_axis();
        axis.matches(&captured.frame_axis()).map_err(|error| NodeError::input(MARKERS.name(), error))?;
        let puppet = MarkerRig::attached(rig, inputs.get(&ATTACHMENT)?)
            .map_err(|error| NodeError::input(ATTACHMENT.name(), error))?;
        let options = self.options(rig, &puppet, captured, inputs.may_get(&NOISE)?)?;
        let mut values = raw.values().to_vec();
        let width = raw.channels().len();
        let (mut blind, mut unfinished) = (0, 0);
        for run in self.runs(raw) {
            context.go_on()?;
            let tuned = finetune(&puppet, &cut(raw, &run)?, &cut(captured, &run)?, &options).map_err(named)?;
            for place in run.clone() {
                let share = self.share(raw, place);
                let tuned = tuned.curves.frame(place - run.start);
                for (own, tuned) in values[place * width..(place + 1) * width].iter_mut().zip(tuned) {
                    // Channels that are not fine-tuned keep their bits: their difference is 0.
                    *own = if share < 1.0 { *own + share * (*tuned - *own) } else { *tuned };
                }
            }
            blind += tuned.blind_frames.len();
            unfinished += tuned.unfinished_frames.len();
            context.progress(
                run.end as f64 / axis.count as f64,
                &[("frames without markers", blind as f64), ("unfinished frames", unfinished as f64)],
            );
        }
        let tuned = Curves::new(axis, raw.channels().to_vec(), values).map_err(NodeError::failed)?;
        Ok(Outputs::default().with(&TUNED, tuned))
    }
}

/// Frames solved between two looks at whether the cook was cancelled.
const FRAMES_A_TURN: usize = 32;

impl FinetuneCurves {
    fn options(
        &self,
        rig: &Rig,
        puppet: &MarkerRig,
        captured: &Markers,
        measured: Option<&MarkerNoise>,
    ) -> Result<FinetuneOptions, NodeError> {
        let channels = |parameter| Patterns { parameter, what: "channel", names: puppet.channels() };
        let markers = |parameter| Patterns { parameter, what: "marker", names: puppet.names() };
        let numbers = |names: &[String], found: Vec<Option<f64>>| {
            names.iter().cloned().zip(found).filter_map(|(name, number)| Some((name, number?))).collect()
        };
        let mut matched = markers("markers").chosen(&self.markers)?;
        matched.retain(|marker| captured.index(marker).is_some());
        if matched.is_empty() {
            let problem = "the take and the rig share no marker; attach the take's own neutral markers";
            return Err(NodeError::input(MARKERS.name(), problem));
        }
        let measured = |name: &String| Some(measured?.sigma_mm(name)?.max(self.least_noise_mm));
        let own = markers("by_marker").numbers(&self.by_marker)?;
        let noise = puppet.names().iter().zip(own).map(|(name, own)| own.or_else(|| measured(name)));
        let noise = noise.map(|sigma_mm| Some(sigma_mm? * self.noise_scale)).collect();
        Ok(FinetuneOptions {
            channels: channels("channels").chosen(&self.channels)?,
            frozen: if self.hold_jaw { self.jaw(rig)? } else { Vec::new() },
            noise_mm: numbers(puppet.names(), noise),
            default_noise_mm: self.sigma_mm * self.noise_scale,
            raw_error: numbers(puppet.channels(), channels("error_by_channel").numbers(&self.error_by_channel)?),
            default_raw_error: self.raw_error,
            markers: matched,
            low: self.low,
            high: self.high,
        })
    }

    /// The channels that `hold_jaw` holds.
    fn jaw(&self, rig: &Rig) -> Result<Vec<String>, NodeError> {
        if !self.jaw_channels.is_empty() {
            return Patterns { parameter: "jaw_channels", what: "channel", names: &rig.channels }
                .chosen(&self.jaw_channels);
        }
        let motions = rig.jaw.iter().flat_map(|jaw| &jaw.motions);
        let moved = motions.filter_map(|motion| match rig.shapes.get(motion.shape as usize)?.driver {
            Driver::Channel(channel) => rig.channels.get(channel as usize).cloned(),
            _ => None,
        });
        let moved: Vec<String> = moved.collect();
        if moved.is_empty() {
            let problem =
                "the rig has no jaw joint to tell its channels by; put `skin_jaw` before, or list `jaw_channels`";
            return Err(NodeError::parameter("hold_jaw", problem));
        }
        Ok(moved)
    }

    /// How much of the fine-tuned weights a frame takes: 1 in the chosen frames, F frames away from them
    /// ½ (1 + cos(π F / (falloff + 1))).
    fn share(&self, raw: &Curves, place: usize) -> f32 {
        let away = self.frames.distance(frame_number(raw.frame_axis(), place));
        let part = away as f64 / (f64::from(self.falloff_frames) + 1.0);
        if part >= 1.0 { 0.0 } else { (0.5 * (1.0 + (std::f64::consts::PI * part).cos())) as f32 }
    }

    /// The frames to fine-tune, chosen or fading, in runs of consecutive positions, none too long.
    fn runs(&self, raw: &Curves) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        let chosen = |place: &usize| self.share(raw, *place) > 0.0;
        for place in (0..raw.frames()).filter(chosen) {
            match runs.last_mut() {
                Some(run) if run.end == place && run.len() < FRAMES_A_TURN => run.end += 1,
                _ => runs.push(place..place + 1),
            }
        }
        runs
    }
}

/// The frames at `run`.
fn cut<T: Data + Clone>(value: &T, run: &Range<usize>) -> Result<T, NodeError> {
    let slice = value.slice(run.clone());
    let slice = slice.as_deref().and_then(<dyn Value>::downcast_ref::<T>).cloned();
    slice.ok_or_else(|| NodeError::failed(format!("{} cannot be cut into frames", T::NAME)))
}

/// An error of the fit, at the input it comes from.
fn named(error: FinetuneError) -> NodeError {
    match error {
        FinetuneError::NoMarker => NodeError::input(MARKERS.name(), error),
        FinetuneError::NoChannel => NodeError::parameter("channels", error),
        FinetuneError::Option { .. } => NodeError::failed(error),
        _ => NodeError::input(RAW.name(), error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use crate::testing::{Bench, compute, made};
    use face_math::data::{JawMotion, JawSkin, NoiseOfMarker};
    use glam::Vec3;
    use serde_json::json;

    fn captured(truth: &Curves) -> Markers {
        MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap().drive(truth).unwrap()
    }

    fn shaken(truth: &Curves) -> Curves {
        let mut dice = toy::Dice(21);
        let values = truth.values().iter().map(|weight| weight + 0.05 * dice.roll()).collect();
        Curves::new(truth.frame_axis(), truth.channels().to_vec(), values).unwrap()
    }

    fn inputs(raw: Curves, markers: Markers) -> Inputs {
        Inputs::default()
            .with(&RAW, raw)
            .with(&MARKERS, markers)
            .with(&RIG, toy::rig())
            .with(&ATTACHMENT, toy::attachment())
    }

    fn tune(parameters: serde_json::Value, raw: &Curves, markers: &Markers) -> Result<Curves, String> {
        let node: FinetuneCurves = made(parameters);
        let outputs = compute(&node, &inputs(raw.clone(), markers.clone()));
        outputs.map(|outputs| outputs.get(&TUNED).unwrap().clone()).map_err(|error| error.to_string())
    }

    fn worst(a: &Curves, b: &Curves) -> f32 {
        a.values().iter().zip(b.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn exact_markers_give_the_truth() {
        let truth = toy::curves(40, 5);
        let (raw, markers) = (shaken(&truth), captured(&truth));
        let tuned = tune(json!({"sigma_mm": 0.001, "raw_error": 1.0}), &raw, &markers).unwrap();
        assert!(worst(&tuned, &truth) < 1e-3, "{}", worst(&tuned, &truth));
        let held = tune(json!({"error_by_channel": {"*": 1e-6}}), &raw, &markers).unwrap();
        let inside = Curves::new(
            raw.frame_axis(),
            raw.channels().to_vec(),
            raw.values().iter().map(|weight| weight.clamp(0.0, 1.0)).collect(),
        );
        assert!(worst(&held, &inside.unwrap()) < 1e-4);
    }

    #[test]
    fn calmer_markers_are_trusted_more() {
        let truth = toy::curves(5, 10);
        let (raw, markers) = (shaken(&truth), captured(&truth));
        let tuned = |with: serde_json::Value| tune(with, &raw, &markers).unwrap();
        let calm = tuned(json!({"sigma_mm": 2.0, "noise_scale": 0.1, "by_marker": {"m0": 1.0}}));
        assert_eq!(calm, tuned(json!({"sigma_mm": 0.2, "by_marker": {"m0": 0.1}})));
        assert!(worst(&calm, &truth) < worst(&tuned(json!({"sigma_mm": 2.0})), &truth));
    }

    #[test]
    fn measured_noise_is_used_like_a_table_of_it() {
        let truth = toy::curves(5, 10);
        let (raw, markers) = (shaken(&truth), captured(&truth));
        let one = |index: usize, sigma_mm| NoiseOfMarker { marker: format!("m{index}"), sigma_mm };
        let noise = MarkerNoise::new(vec![one(0, 0.4), one(1, 0.0), one(2, 0.3)]).unwrap();
        let node: FinetuneCurves = made(json!({"by_marker": {"m2": 1.0}}));
        let outputs = compute(&node, &inputs(raw.clone(), markers.clone()).with(&NOISE, noise)).unwrap();
        let table = json!({"by_marker": {"m0": 0.4, "m1": 0.02, "m2": 1.0}});
        assert_eq!(outputs.get(&TUNED).unwrap(), &tune(table, &raw, &markers).unwrap());
    }

    #[test]
    fn only_the_chosen_frames_and_channels_move() {
        let truth = toy::curves(10, 6);
        let (raw, markers) = (shaken(&truth), captured(&truth));
        let tuned = tune(json!({"frames": "103-105,109", "channels": ["smile_*"]}), &raw, &markers).unwrap();
        for frame in 0..10 {
            let chosen = [2, 3, 4, 8].contains(&frame);
            for channel in 0..4 {
                let same = tuned.frame(frame)[channel].to_bits() == raw.frame(frame)[channel].to_bits();
                assert_eq!(!same, chosen && (1..3).contains(&channel), "frame {frame}, channel {channel}");
            }
        }
    }

    #[test]
    fn ends_of_a_range_fade_into_the_raw_solve() {
        let truth = toy::curves(12, 6);
        let (raw, markers) = (shaken(&truth), captured(&truth));
        let whole = tune(json!({}), &raw, &markers).unwrap();
        let faded = tune(json!({"frames": "105-107", "falloff_frames": 2}), &raw, &markers).unwrap();
        for (frame, share) in [0.0, 0.0, 0.25, 0.75, 1.0, 1.0, 1.0, 0.75, 0.25, 0.0, 0.0, 0.0].into_iter().enumerate() {
            for channel in 0..4 {
                let (own, tuned) = (raw.frame(frame)[channel], whole.frame(frame)[channel]);
                assert!((faded.frame(frame)[channel] - (own + share * (tuned - own))).abs() < 1e-6, "frame {frame}");
            }
        }
        let cut =
            tune(json!({"frames": "105-107", "falloff_frames": 2}), &toy::cut(&raw, 3..9), &toy::cut(&markers, 3..9));
        assert!(toy::same_bits(&faded, 3..9, &cut.unwrap()));
    }

    #[test]
    fn the_jaw_is_held_where_it_is_known() {
        let truth = toy::curves(4, 7);
        let (raw, markers) = (shaken(&truth), captured(&truth));
        let held = tune(json!({"hold_jaw": true, "jaw_channels": ["jaw*"]}), &raw, &markers).unwrap();
        assert!((0..4).all(|frame| held.frame(frame)[0].to_bits() == raw.frame(frame)[0].to_bits()));
        assert!(tune(json!({"hold_jaw": true}), &raw, &markers).unwrap_err().contains("put `skin_jaw` before"));
        let mut rig = toy::rig();
        let motion = JawMotion { shape: 3, euler_rad: Vec3::ZERO, translation_m: Vec3::ZERO };
        rig.jaw = Some(JawSkin { weights: vec![0.0; 25], motions: vec![motion], ..JawSkin::default() });
        assert_eq!(FinetuneCurves::default().jaw(&rig).unwrap(), ["browUp"]);
    }

    #[test]
    fn blocks_equal_the_whole() {
        let truth = toy::curves(50, 8);
        let (raw, markers) = (shaken(&truth), captured(&truth));
        let with = || json!({"frames": "101-140"});
        let block = tune(with(), &toy::cut(&raw, 29..45), &toy::cut(&markers, 29..45)).unwrap();
        assert!(toy::same_bits(&tune(with(), &raw, &markers).unwrap(), 29..45, &block));
    }

    #[test]
    fn missing_markers_are_passed_over_and_mistakes_named() {
        let truth = toy::curves(3, 9);
        let (raw, markers) = (shaken(&truth), captured(&truth));
        let mut positions = markers.positions().to_vec();
        positions[2] = Vec3::NAN;
        let gappy = markers.with_positions(positions).unwrap();
        let with = || json!({"sigma_mm": 0.001, "raw_error": 1.0});
        assert!(worst(&tune(with(), &raw, &gappy).unwrap(), &truth) < 1e-3);
        let fault = |parameters: serde_json::Value| tune(parameters, &raw, &markers).unwrap_err();
        assert!(fault(json!({"channels": ["smle_L"]})).contains("did you mean `smile_L`?"));
        assert!(fault(json!({"markers": ["chin"]})).contains("`markers`"));
        assert!(fault(json!({"by_marker": {"x*": 1.0}})).contains("`by_marker`"));
        assert!(fault(json!({"low": 1.0, "high": 0.0})).contains("least weight"));
        let some = raw.arrange(&raw.channels()[1..], None).unwrap();
        assert!(tune(json!({}), &some, &markers).unwrap_err().contains("jawOpen"));
        let stopped = Bench::default().cancelled_after(0).compute(&FinetuneCurves::default(), &inputs(raw, markers));
        assert!(matches!(stopped, Err(NodeError::Cancelled)));
    }
}
