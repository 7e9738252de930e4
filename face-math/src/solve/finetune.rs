//! Raw curves until the puppet's markers meet the captured ones: fine-tuning (section 4.5 of FDLS).
//!
//! For each frame alone, from the raw solve w⁰, over the chosen channels k, in the box lo ≤ wₖ ≤ hi:
//!
//! ```text
//! E(w) = Σₘ ‖gₘ(w) − xₘ‖² / σₘ² + Σₖ (wₖ − wₖ⁰)² / ρₖ²
//! ```
//!
//! gₘ(w), xₘ the puppet's and the captured position of marker m (millimetres), σₘ the noise of that marker (millimetres, one
//! standard deviation of a coordinate), ρₖ how far the raw solve is off in channel k (unitless, root mean square). The first
//! sum is the face matching of Eq. 2 of FDLS, with the whole nonlinear puppet in place of its linear part. The second is ours:
//! markers carry noise and do not fix every channel, so where they say little the raw solve keeps its say. Under Gaussian
//! errors E is what the most probable weights minimise, so both numbers can be measured instead of tuned: σ by the jitter of
//! the tracks, ρ by solving frames whose weights are known.
//!
//! [`minimise`](super::minimise()) (L-BFGS in a box, as the paper's) does it, started with what the puppet's Jacobian J at
//! w⁰ says of the Hessian, 2 Jᵀ diag(1/σ²) J + 2 diag(1/ρ²): a few steps a frame.

use super::finetune_plan::{Plan, Scratch};
use super::minimise::{MinimiseError, Stop};
use crate::data::{Curves, DataError, Markers};
use crate::rig::MarkerRig;
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
    /// Markers to match; all that are both captured and on the puppet where empty.
    pub markers: Vec<String>,
    /// σ of the markers whose noise is known, in millimetres.
    pub noise_mm: BTreeMap<String, f64>,
    /// σ of all others, in millimetres.
    pub default_noise_mm: f64,
    /// ρ of the channels whose error is known, unitless.
    pub raw_error: BTreeMap<String, f64>,
    /// ρ of all others, unitless. Smaller holds the raw solve, larger follows the markers.
    pub default_raw_error: f64,
    /// The least weight of a moved channel.
    pub low: f64,
    /// The largest weight of a moved channel.
    pub high: f64,
}

impl Default for FinetuneOptions {
    fn default() -> Self {
        Self {
            channels: Vec::new(),
            frozen: Vec::new(),
            markers: Vec::new(),
            noise_mm: BTreeMap::new(),
            default_noise_mm: 0.1,
            raw_error: BTreeMap::new(),
            default_raw_error: 0.02,
            low: 0.0,
            high: 1.0,
        }
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
        FinetuneOptions { default_raw_error: 100.0, ..FinetuneOptions::default() }
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
        let moved = |default_raw_error| {
            let options = FinetuneOptions { default_raw_error, ..free() };
            let tuned = finetune(&puppet, &raw, &captured, &options).unwrap();
            worst(&tuned.curves, &raw)
        };
        let (strong, medium, weak) = (moved(1e-6), moved(3e-3), moved(0.1));
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
        assert!(
            fault(&FinetuneOptions { markers: names("nose"), ..free() }).contains("no marker on the puppet `nose`")
        );
        let noise_mm = BTreeMap::from([("3".to_owned(), -1.0)]);
        assert!(fault(&FinetuneOptions { noise_mm, ..free() }).contains("noise of marker `3` is -1"));
        let raw_error = BTreeMap::from([("c1".to_owned(), 0.0)]);
        assert!(fault(&FinetuneOptions { raw_error, ..free() }).contains("raw error of channel `c1` is 0"));
        assert!(fault(&FinetuneOptions { default_noise_mm: 0.0, ..free() }).contains("noise of the markers is 0"));
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
