//! Raw curves until the puppet's markers meet the captured ones: fine-tuning (section 4.5 of FDLS).
//!
//! For each frame alone, from the raw solve w⁰, over the chosen channels k, in the box lo ≤ wₖ ≤ hi:
//!
//! ```text
//! E(w) = Σₘ cₘ ‖gₘ(w) − xₘ‖² + λ Σₖ (wₖ − wₖ⁰)²
//! ```
//!
//! gₘ(w), xₘ the puppet's and the captured position of marker m (millimetres), cₘ its weight (unitless), λ the hold (square
//! millimetres). The first sum is the face matching of Eq. 2 of FDLS, with the whole nonlinear puppet in place of its
//! linear part. The second is ours: markers carry noise and do not fix every channel, so where they say little the raw solve
//! keeps its say. λ is the squared marker distance, summed over the markers, that is worth moving a channel by a whole unit;
//! as an estimate it is the markers' noise variance over the raw solve's error variance, a coordinate and a channel.
//!
//! [`minimise`](super::minimise()) (L-BFGS in a box, as the paper's) does it, started with what the puppet's Jacobian J at
//! w⁰ says of the Hessian, 2 Jᵀ C J + 2 λ I: a few steps a frame.

use super::minimise::{Metric, MinimiseError, MinimiseOptions, Stop, minimise};
use crate::data::{Curves, DataError, Markers, nearest_name};
use crate::rig::{MarkerPose, MarkerRig};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;
use wire::AxisError;

/// How to fine-tune.
#[derive(Debug, Clone, PartialEq)]
pub struct FinetuneOptions {
    /// Channels to move; all of the puppet's where empty.
    pub channels: Vec<String>,
    /// Channels that stay as they are, whatever `channels` says: the jaw, once it is settled.
    pub frozen: Vec<String>,
    /// Markers to match and their weights cₘ, for example 1 over the squared noise of each; all alike where empty.
    pub markers: BTreeMap<String, f64>,
    /// λ, the hold on the raw solve, in square millimetres.
    pub hold_mm2: f64,
    /// The least weight of a moved channel.
    pub low: f64,
    /// The largest weight of a moved channel.
    pub high: f64,
}

impl Default for FinetuneOptions {
    fn default() -> Self {
        Self { channels: Vec::new(), frozen: Vec::new(), markers: BTreeMap::new(), hold_mm2: 30.0, low: 0.0, high: 1.0 }
    }
}

/// The outcome of [`finetune`].
#[derive(Debug, Clone, PartialEq)]
pub struct Finetuned {
    /// The raw curves with the moved channels' new values; channels that are not the puppet's pass through.
    pub curves: Curves,
    /// Frames (as the source counts them) that show none of the markers: they keep the raw solve, moved into the box.
    pub blind_frames: Vec<i64>,
    /// Frames that the minimiser left before it had converged.
    pub unfinished_frames: Vec<i64>,
    /// Steps of the minimiser over all frames.
    pub steps: usize,
}

/// Why curves cannot be fine-tuned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FinetuneError {
    /// A channel or marker is not there, or values do not fit together.
    #[error(transparent)]
    Data(#[from] DataError),
    /// Curves and markers do not hold the same frames.
    #[error("curves beside markers: {0}")]
    Axis(#[from] AxisError),
    /// No marker is both captured and on the puppet.
    #[error("the take and the puppet share no marker; attach the take's own neutral markers")]
    NoMarker,
    /// All channels are frozen.
    #[error("no channel is left to move; freeze fewer")]
    NoChannel,
    /// A raw weight is NaN or infinite.
    #[error("raw channel `{channel}` is {value} in frame {frame}; mend the raw solve first")]
    Weight {
        /// The channel.
        channel: String,
        /// Number of the frame, as its source counts.
        frame: i64,
        /// The weight.
        value: f32,
    },
    /// An option out of range.
    #[error("{what} is {value}; {cure}")]
    Option {
        /// Which option.
        what: String,
        /// Its value.
        value: f64,
        /// What it should be.
        cure: &'static str,
    },
    /// The minimiser refuses frame `frame`.
    #[error("frame {frame}: {source}")]
    Frame {
        /// Number of the frame, as its source counts.
        frame: i64,
        /// What the minimiser says.
        source: MinimiseError,
    },
}

/// Fine-tunes `raw` until the markers of `puppet` meet `captured` (metres). Missing markers are passed over, frame by frame.
///
/// # Errors
/// Where the frames differ, names are not there, a raw weight is not a number, or an option is out of range.
pub fn finetune(
    puppet: &MarkerRig,
    raw: &Curves,
    captured: &Markers,
    options: &FinetuneOptions,
) -> Result<Finetuned, FinetuneError> {
    raw.frame_axis().matches(&captured.frame_axis())?;
    let plan = Plan::new(puppet, raw, captured, options)?;
    let frames: Vec<_> = (0..raw.frames())
        .into_par_iter()
        .map_init(Scratch::default, |scratch, frame| plan.solve(raw, captured, frame, scratch))
        .collect();
    let axis = raw.frame_axis();
    let (mut blind_frames, mut unfinished_frames, mut steps) = (Vec::new(), Vec::new(), 0);
    let mut values = Vec::with_capacity(raw.values().len());
    // Frames come in order, so that of several errors the first is told.
    for (position, solved) in frames.into_iter().enumerate() {
        let frame = axis.slice(&(position..position + 1)).first;
        let solved = solved.map_err(|fault| fault.at(frame))?;
        if solved.seen == 0 {
            blind_frames.push(frame);
        }
        if solved.stop == Stop::StepsSpent {
            unfinished_frames.push(frame);
        }
        steps += solved.steps;
        values.extend(solved.values);
    }
    let curves = Curves::new(axis, raw.channels().to_vec(), values)?;
    Ok(Finetuned { curves, blind_frames, unfinished_frames, steps })
}

/// What all frames share.
struct Plan<'a> {
    puppet: &'a MarkerRig,
    /// Columns of the puppet's channels in the raw curves.
    columns: Vec<usize>,
    /// The channels to move.
    moved: Vec<usize>,
    /// Per marker of the puppet that counts: its place, its column among the captured ones, its weight.
    matched: Vec<(usize, usize, f64)>,
    hold: f64,
    bounds: Vec<(f64, f64)>,
}

#[derive(Default)]
struct Scratch {
    pose: MarkerPose,
    jacobian: Vec<DVec3>,
    forces: Vec<DVec3>,
    gradient: Vec<f64>,
}

struct Solved {
    values: Vec<f32>,
    seen: usize,
    steps: usize,
    stop: Stop,
}

enum Fault {
    Weight { channel: String, value: f32 },
    Minimise(MinimiseError),
}

impl Fault {
    fn at(self, frame: i64) -> FinetuneError {
        match self {
            Self::Weight { channel, value } => FinetuneError::Weight { channel, frame, value },
            Self::Minimise(source) => FinetuneError::Frame { frame, source },
        }
    }
}

/// Millimetres a metre: the objective is in square millimetres.
const MM: f64 = 1000.0;

impl<'a> Plan<'a> {
    fn new(
        puppet: &'a MarkerRig,
        raw: &Curves,
        captured: &Markers,
        options: &FinetuneOptions,
    ) -> Result<Self, FinetuneError> {
        let find = |what: &'static str, name: &String, names: &[String]| {
            names.iter().position(|own| own == name).ok_or_else(|| {
                let near = nearest_name(name, names.iter().map(String::as_str));
                FinetuneError::Data(DataError::Missing { what, name: name.clone(), near })
            })
        };
        let refuse = |what: &str, value: f64, cure| Err(FinetuneError::Option { what: what.to_owned(), value, cure });
        if !(options.hold_mm2 >= 0.0 && options.hold_mm2.is_finite()) {
            return refuse("the hold", options.hold_mm2, "give 0 or more square millimetres");
        }
        if options.low.is_nan() || options.high.is_nan() || options.low > options.high {
            return refuse("the least weight", options.low, "keep it below the largest weight");
        }
        let channels = puppet.channels();
        let columns =
            channels.iter().map(|name| find("raw channel", name, raw.channels())).collect::<Result<Vec<_>, _>>()?;
        let mut chosen = vec![options.channels.is_empty(); channels.len()];
        for name in &options.channels {
            chosen[find("channel", name, channels)?] = true;
        }
        for name in &options.frozen {
            chosen[find("channel", name, channels)?] = false;
        }
        let moved: Vec<usize> = (0..channels.len()).filter(|channel| chosen[*channel]).collect();
        if moved.is_empty() {
            return Err(FinetuneError::NoChannel);
        }
        let mut matched = Vec::new();
        for (name, weight) in &options.markers {
            if !(*weight >= 0.0 && weight.is_finite()) {
                return refuse(&format!("the weight of marker `{name}`"), *weight, "give 0 or more");
            }
            find("marker on the puppet", name, puppet.names())?;
            find("captured marker", name, captured.names())?;
        }
        for (place, name) in puppet.names().iter().enumerate() {
            let weight = options.markers.get(name).copied();
            let weight = weight.unwrap_or(if options.markers.is_empty() { 1.0 } else { 0.0 });
            if let (Some(column), true) = (captured.index(name), weight > 0.0) {
                matched.push((place, column, weight));
            }
        }
        if matched.is_empty() {
            return Err(FinetuneError::NoMarker);
        }
        let bounds = vec![(options.low, options.high); moved.len()];
        Ok(Self { puppet, columns, moved, matched, hold: options.hold_mm2, bounds })
    }

    fn solve(&self, raw: &Curves, captured: &Markers, frame: usize, scratch: &mut Scratch) -> Result<Solved, Fault> {
        let own = raw.frame(frame);
        let mut weights: Vec<f64> = self.columns.iter().map(|column| f64::from(own[*column])).collect();
        if let Some(channel) = weights.iter().position(|weight| !weight.is_finite()) {
            let value = own[self.columns[channel]];
            return Err(Fault::Weight { channel: self.puppet.channels()[channel].clone(), value });
        }
        let start: Vec<f64> = self.moved.iter().map(|channel| weights[*channel]).collect();
        let points = captured.frame(frame);
        let targets: Vec<_> = self
            .matched
            .iter()
            .map(|(place, column, weight)| (*place, points[*column].as_dvec3(), *weight))
            .filter(|(_, target, _)| target.is_finite())
            .collect();
        // The first sum is in square metres until it is scaled here.
        let scale = MM * MM;
        for (channel, (low, high)) in self.moved.iter().zip(&self.bounds) {
            weights[*channel] = weights[*channel].clamp(*low, *high);
        }
        let metric = self.metric(&weights, &targets, scratch);
        let found = minimise(
            |x, gradient| {
                for (channel, x) in self.moved.iter().zip(x) {
                    weights[*channel] = *x;
                }
                self.puppet.pose(&weights, &mut scratch.pose);
                scratch.forces.clear();
                scratch.forces.resize(self.puppet.names().len(), DVec3::ZERO);
                let mut value = 0.0;
                for (place, target, weight) in &targets {
                    let apart = scratch.pose.positions()[*place] - *target;
                    value += scale * weight * apart.length_squared();
                    scratch.forces[*place] = 2.0 * scale * *weight * apart;
                }
                scratch.gradient.resize(weights.len(), 0.0);
                self.puppet.pull_back(&mut scratch.pose, &scratch.forces, &mut scratch.gradient);
                for (((g, channel), x), start) in gradient.iter_mut().zip(&self.moved).zip(x).zip(&start) {
                    value += self.hold * (x - start).powi(2);
                    *g = scratch.gradient[*channel] + 2.0 * self.hold * (x - start);
                }
                value
            },
            &start,
            &self.bounds,
            &metric,
            &MinimiseOptions { gradient_tolerance: 1e-6, max_steps: 200, memory: 8 },
        )
        .map_err(Fault::Minimise)?;
        let mut values = own.to_vec();
        for (channel, x) in self.moved.iter().zip(&found.x) {
            values[self.columns[*channel]] = *x as f32;
        }
        Ok(Solved { values, seen: targets.len(), steps: found.steps, stop: found.stop })
    }

    /// 2 Jᵀ C J + 2 λ I over the moved channels, in square millimetres. A channel that no marker sees and no hold keeps
    /// gets a little of the largest entry, so that the matrix can be factored.
    fn metric(&self, weights: &[f64], targets: &[(usize, DVec3, f64)], scratch: &mut Scratch) -> Metric {
        let markers = self.puppet.names().len();
        self.puppet.pose(weights, &mut scratch.pose);
        self.puppet.jacobian(&scratch.pose, &mut scratch.jacobian);
        let size = self.moved.len();
        let columns: Vec<Vec<DVec3>> = self
            .moved
            .iter()
            .map(|channel| {
                let column = &scratch.jacobian[channel * markers..(channel + 1) * markers];
                targets.iter().map(|(place, _, weight)| MM * weight.sqrt() * column[*place]).collect()
            })
            .collect();
        let mut matrix = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..=i {
                let product: f64 = columns[i].iter().zip(&columns[j]).map(|(a, b)| a.dot(*b)).sum();
                matrix[i * size + j] = 2.0 * product;
                matrix[j * size + i] = 2.0 * product;
            }
        }
        let largest = (0..size).map(|i| matrix[i * size + i]).fold(0.0, f64::max);
        for i in 0..size {
            matrix[i * size + i] += 2.0 * self.hold + 1e-9 * largest.max(1.0);
        }
        Metric::Dense(matrix)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::toy;
    use glam::Vec3;
    use wire::{FrameAxis, Value};

    fn puppet() -> MarkerRig {
        MarkerRig::of_vertices(&toy::jawed(6, 5), &(0..36).collect::<Vec<_>>()).unwrap()
    }

    fn curves(puppet: &MarkerRig, frames: usize, seed: u64) -> Curves {
        let mut dice = toy::Dice(seed);
        let values = (0..frames * puppet.channels().len()).map(|_| 0.5 + 0.45 * dice.roll()).collect();
        Curves::new(FrameAxis { first: 11, count: frames, rate_hz: 60.0 }, puppet.channels().to_vec(), values).unwrap()
    }

    fn shaken(curves: &Curves, by: f32) -> Curves {
        let mut dice = toy::Dice(77);
        let values = curves.values().iter().map(|value| value + by * dice.roll()).collect();
        Curves::new(curves.frame_axis(), curves.channels().to_vec(), values).unwrap()
    }

    fn worst(a: &Curves, b: &Curves) -> f32 {
        a.values().iter().zip(b.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    fn free() -> FinetuneOptions {
        FinetuneOptions { hold_mm2: 0.0, ..FinetuneOptions::default() }
    }

    #[test]
    fn without_noise_and_hold_the_truth_is_found() {
        let puppet = puppet();
        let truth = curves(&puppet, 12, 1);
        let captured = puppet.drive(&truth).unwrap();
        let raw = shaken(&truth, 0.04);
        let tuned = finetune(&puppet, &raw, &captured, &free()).unwrap();
        assert!(worst(&tuned.curves, &truth) < 1e-4, "{}", worst(&tuned.curves, &truth));
        assert!(tuned.blind_frames.is_empty() && tuned.unfinished_frames.is_empty());
    }

    #[test]
    fn a_strong_hold_keeps_the_raw_solve_and_a_weaker_one_moves_more() {
        let puppet = puppet();
        let truth = curves(&puppet, 6, 2);
        let (captured, raw) = (puppet.drive(&truth).unwrap(), shaken(&truth, 0.04));
        let moved = |hold_mm2| {
            let tuned = finetune(&puppet, &raw, &captured, &FinetuneOptions { hold_mm2, ..free() }).unwrap();
            worst(&tuned.curves, &raw)
        };
        let (strong, medium, weak) = (moved(1e9), moved(1e3), moved(1.0));
        assert!(strong < 1e-5 && strong < medium && medium < weak, "{strong} {medium} {weak}");
    }

    #[test]
    fn only_chosen_channels_move_and_others_pass_through() {
        let puppet = puppet();
        let truth = curves(&puppet, 4, 3);
        let captured = puppet.drive(&truth).unwrap();
        let raw = shaken(&truth, 0.04);
        let names: Vec<String> = raw.channels().iter().cloned().chain(["headYaw".to_owned()]).collect();
        let values = (0..4).flat_map(|t| raw.frame(t).iter().copied().chain([7.0])).collect();
        let raw = Curves::new(raw.frame_axis(), names, values).unwrap();
        let options = FinetuneOptions { channels: vec!["c2".into(), "c0".into()], frozen: vec!["c0".into()], ..free() };
        let tuned = finetune(&puppet, &raw, &captured, &options).unwrap().curves;
        for frame in 0..4 {
            for (channel, (a, b)) in tuned.frame(frame).iter().zip(raw.frame(frame)).enumerate() {
                assert_eq!(channel != 2, a.to_bits() == b.to_bits());
            }
        }
    }

    #[test]
    fn results_stay_in_the_box_even_from_outside() {
        let puppet = puppet();
        let truth = curves(&puppet, 4, 4);
        let captured = puppet.drive(&truth).unwrap();
        let options = FinetuneOptions { low: 0.3, high: 0.6, ..free() };
        let tuned = finetune(&puppet, &shaken(&truth, 0.5), &captured, &options).unwrap();
        assert!(tuned.curves.values().iter().all(|weight| (0.3..=0.6).contains(weight)));
    }

    #[test]
    fn missing_markers_are_passed_over() {
        let puppet = puppet();
        let truth = curves(&puppet, 3, 5);
        let captured = puppet.drive(&truth).unwrap();
        let mut positions = captured.positions().to_vec();
        positions[..4].fill(Vec3::NAN);
        positions[36..72].fill(Vec3::NAN);
        let captured = captured.with_positions(positions).unwrap();
        let raw = shaken(&truth, 0.04);
        let tuned = finetune(&puppet, &raw, &captured, &free()).unwrap();
        assert_eq!(tuned.blind_frames, [12]);
        assert_eq!(tuned.curves.frame(1), raw.frame(1));
        for (a, b) in tuned.curves.frame(0).iter().zip(truth.frame(0)) {
            assert!((a - b).abs() < 1e-4);
        }
    }

    #[test]
    fn blocks_equal_the_whole() {
        let puppet = puppet();
        let truth = curves(&puppet, 9, 6);
        let (captured, raw) = (puppet.drive(&truth).unwrap(), shaken(&truth, 0.05));
        let whole = finetune(&puppet, &raw, &captured, &FinetuneOptions::default()).unwrap().curves;
        let (raw, captured) = (raw.slice(3..7).unwrap(), captured.slice(3..7).unwrap());
        let (raw, captured) = (raw.downcast_ref().unwrap(), captured.downcast_ref().unwrap());
        let block = finetune(&puppet, raw, captured, &FinetuneOptions::default()).unwrap().curves;
        assert_eq!(whole.slice(3..7).unwrap().encoded(), (&block as &dyn Value).encoded());
    }

    #[test]
    fn bad_input_is_named() {
        let puppet = puppet();
        let truth = curves(&puppet, 2, 7);
        let captured = puppet.drive(&truth).unwrap();
        let fault = |options: &FinetuneOptions| finetune(&puppet, &truth, &captured, options).unwrap_err().to_string();
        let names = |name: &str| vec![name.to_owned()];
        assert!(fault(&FinetuneOptions { channels: names("c9"), ..free() }).contains("no channel `c9`"));
        assert!(
            fault(&FinetuneOptions { frozen: puppet.channels().to_vec(), ..free() }).contains("no channel is left")
        );
        let wrong = BTreeMap::from([("nose".to_owned(), 1.0)]);
        assert!(fault(&FinetuneOptions { markers: wrong, ..free() }).contains("no marker on the puppet `nose`"));
        let negative = BTreeMap::from([("3".to_owned(), -1.0)]);
        assert!(fault(&FinetuneOptions { markers: negative, ..free() }).contains("weight of marker `3` is -1"));
        assert!(fault(&FinetuneOptions { hold_mm2: -1.0, ..free() }).contains("the hold is -1"));
        assert!(fault(&FinetuneOptions { low: 2.0, ..free() }).contains("the least weight is 2"));
        let mut values = truth.values().to_vec();
        values[6] = f32::NAN;
        let broken = Curves::new(truth.frame_axis(), truth.channels().to_vec(), values).unwrap();
        let error = finetune(&puppet, &broken, &captured, &free()).unwrap_err();
        assert!(matches!(error, FinetuneError::Weight { frame: 12, channel, .. } if channel == "c1"));
        let other = curves(&puppet, 3, 7);
        assert!(matches!(finetune(&puppet, &other, &captured, &free()), Err(FinetuneError::Axis(_))));
        let strangers = Markers::new(truth.frame_axis(), names("nose"), vec![Vec3::ZERO; 2]).unwrap();
        assert_eq!(finetune(&puppet, &truth, &strangers, &free()).unwrap_err(), FinetuneError::NoMarker);
    }
}
