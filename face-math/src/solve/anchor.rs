//! Finds the first anchor of a take by itself: what separates the captured markers from the puppet's on that day, told by
//! the whole take at once. [`align_anchors`](super::align_anchors) moves the take by it (section 4.4.2 of FDLS).
//!
//! One neutral-looking frame does not say how neutral it is: what of it is expression and what is the mask that sits off
//! cannot be told apart there. Over many frames it can: the offsets stay, expressions come and go, and weights are never
//! below 0. So, over some frames f of the take, with markers m and channels k,
//!
//! ```text
//! E(w, d) = Σ_f Σ_m ρ_fm ‖x_fm − g_m(w_f) − d_m‖² / σ_m² + Σ_m ‖d_m‖² / τ² + 2 Σ_f Σ_k w_fk / s,   0 ≤ w ≤ 1
//! ```
//!
//! x, g(w) the captured and the puppet's markers, d the offsets (metres), σ of a marker what remains of it (metres, standard
//! deviation of a coordinate), τ how large offsets are (the same), s the mean of a weight (unitless). E is −2 log of the
//! probability where offsets and noise are Gaussian and weights fall off exponentially, so d is what the take makes most
//! probable. Given w, d follows in closed form; over w, E is minimised by [`minimise`](super::minimise()):
//!
//! ```text
//! d_m = Σ_f (ρ_fm / σ_m²) (x_fm − g_m(w_f)) / (Σ_f ρ_fm / σ_m² + 1 / τ²)
//! ```
//!
//! σ and τ are not given but told by the take (empirical Bayes, by expectation and maximisation; Dempster, Laird and Rubin
//! 1977). τ begins small: where the markers sit on the puppet as they are, it stays small, and nothing is moved. Markers
//! beyond 3 σ count less, ρ = 3 √3 σ / ‖r‖ (Huber 1964), and σ is told by their median.
//!
//! The anchor frame is the one, of those looked at, whose pose is nearest to the face at rest.

use super::minimise::{Metric, MinimiseError, MinimiseOptions, minimise};
use crate::data::{DataError, Markers};
use crate::rig::{MarkerPose, MarkerRig};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// How to look for an anchor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FindAnchorOptions {
    /// Frames to look at, spread evenly over the take.
    pub samples: usize,
    /// s: what weights are on the average, unitless.
    pub usual_weight: f64,
    /// The largest weight; the least is 0.
    pub high: f64,
    /// Offsets below this (root mean square length over the markers, millimetres) are taken for none: they are within what
    /// this can tell, and moving a take by them would bring in more than it takes out. The anchor is then the face at rest.
    pub least_offset_mm: f64,
}

impl Default for FindAnchorOptions {
    fn default() -> Self {
        Self { samples: 32, usual_weight: 0.1, high: 1.0, least_offset_mm: 0.3 }
    }
}

/// The outcome of [`find_anchor`].
#[derive(Debug, Clone, PartialEq)]
pub struct FoundAnchor {
    /// Position of the anchor's frame in the take.
    pub frame: usize,
    /// Weights of the puppet's channels there.
    pub weights: Vec<f64>,
    /// The puppet's markers there, in metres.
    pub posed: Vec<Vec3>,
    /// d: offsets of the puppet's markers, in metres; none where the take shows a marker in no frame.
    pub offsets: Vec<Option<Vec3>>,
    /// τ: how large offsets are, in millimetres (standard deviation of a coordinate).
    pub spread_mm: f64,
    /// σ of the puppet's markers, in millimetres (standard deviation of a coordinate): what remains of them over the frames
    /// looked at, noise and what the puppet cannot follow.
    pub remaining_mm: Vec<f64>,
}

/// Why no anchor is found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FindAnchorError {
    /// The take and the puppet share no marker.
    #[error("the take and the puppet share no marker; attach the take's own neutral markers")]
    NoMarker,
    /// No frame of those looked at shows enough markers.
    #[error("none of {frames} frames shows half of the {markers} markers; fill gaps first")]
    Blind {
        /// Frames looked at.
        frames: usize,
        /// Markers shared.
        markers: usize,
    },
    /// An option is not usable.
    #[error("{what} is {value}; give a positive number")]
    Option {
        /// The option.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The minimiser refuses.
    #[error(transparent)]
    Minimise(#[from] MinimiseError),
    /// The results do not fit together.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// Metres a millimetre.
const MM: f64 = 1e-3;

/// τ at the beginning, in metres: marks painted where they belong are off by less.
const FIRST_SPREAD_M: f64 = 0.1 * MM;

/// σ at the beginning and at the least, in metres.
const FIRST_REMAINDER_M: f64 = 0.2 * MM;
const LEAST_REMAINDER_M: f64 = 0.02 * MM;

/// The median length of a vector whose three coordinates are standard normal.
const MEDIAN_LENGTH: f64 = 1.538_172;

/// Times that σ, τ and ρ are told anew, and steps of the minimiser each time.
const ROUNDS: usize = 12;
const STEPS_A_ROUND: usize = 60;

/// Finds the first anchor of `take` (metres, the head held still) for `puppet`.
///
/// # Errors
/// Where they share no marker, no frame shows half of those shared, or an option is not positive.
pub fn find_anchor(
    puppet: &MarkerRig,
    take: &Markers,
    options: &FindAnchorOptions,
) -> Result<FoundAnchor, FindAnchorError> {
    let given = [
        ("the number of frames", options.samples as f64),
        ("the usual weight", options.usual_weight),
        ("the largest weight", options.high),
    ];
    if let Some((what, value)) = given.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
        return Err(FindAnchorError::Option { what, value });
    }
    let mut fit = Fit::new(puppet, take, options)?;
    let mut weights = vec![0.0; fit.frames.len() * fit.channels()];
    let bounds = vec![(0.0, options.high); weights.len()];
    for _ in 0..ROUNDS {
        let metric = Metric::Diagonal(fit.curvature());
        let found = minimise(
            |weights, gradient| fit.evaluate(weights, gradient),
            &weights,
            &bounds,
            &metric,
            &MinimiseOptions { gradient_tolerance: 1e-3, max_steps: STEPS_A_ROUND, memory: 20 },
        )?;
        weights = found.x;
        fit.learn(&weights);
    }
    let found = fit.outcome(&weights);
    let squares: Vec<f64> = found.offsets.iter().flatten().map(|offset| f64::from(offset.length_squared())).collect();
    if squares.iter().sum::<f64>() < squares.len() as f64 * (options.least_offset_mm * MM).powi(2) {
        return Ok(fit.unmoved(found));
    }
    Ok(found)
}

/// Positions of `wanted` frames spread evenly over a take of `frames`: the middle one of each of so many equal parts. All of
/// them where the take is shorter.
pub fn spread_frames(frames: usize, wanted: usize) -> Vec<usize> {
    let count = wanted.min(frames);
    (0..count).map(|part| (2 * part + 1) * frames / (2 * count)).collect()
}

/// What is known so far.
struct Fit<'a> {
    puppet: &'a MarkerRig,
    /// Positions of the frames looked at, and in each the captured place of every marker of the puppet (NaN where there is none).
    frames: Vec<(usize, Vec<DVec3>)>,
    /// ρ, frame after frame.
    trust: Vec<f64>,
    /// σ of each marker, in metres.
    remainder_m: Vec<f64>,
    /// τ in metres.
    spread_m: f64,
    usual_weight: f64,
}

impl<'a> Fit<'a> {
    fn new(puppet: &'a MarkerRig, take: &Markers, options: &FindAnchorOptions) -> Result<Self, FindAnchorError> {
        let columns: Vec<_> = puppet.names().iter().map(|name| take.index(name)).collect();
        let shared = columns.iter().flatten().count();
        if shared == 0 {
            return Err(FindAnchorError::NoMarker);
        }
        let places = spread_frames(take.frames(), options.samples);
        let count = places.len();
        let points = |frame: usize| {
            let own = take.frame(frame);
            columns.iter().map(|column| column.map_or(DVec3::NAN, |column| own[column].as_dvec3())).collect::<Vec<_>>()
        };
        let enough = |points: &[DVec3]| 2 * points.iter().filter(|point| point.is_finite()).count() >= shared;
        let frames: Vec<_> =
            places.into_iter().map(|frame| (frame, points(frame))).filter(|(_, points)| enough(points)).collect();
        if frames.is_empty() {
            return Err(FindAnchorError::Blind { frames: count, markers: shared });
        }
        let markers = columns.len();
        Ok(Self {
            puppet,
            trust: vec![1.0; frames.len() * markers],
            frames,
            remainder_m: vec![FIRST_REMAINDER_M; markers],
            spread_m: FIRST_SPREAD_M,
            usual_weight: options.usual_weight,
        })
    }

    fn channels(&self) -> usize {
        self.puppet.channels().len()
    }

    fn markers(&self) -> usize {
        self.remainder_m.len()
    }

    /// ρ / σ² of a marker in a frame; 0 where it is missing.
    fn trust(&self, frame: usize, marker: usize) -> f64 {
        if self.frames[frame].1[marker].is_finite() {
            self.trust[frame * self.markers() + marker] / self.remainder_m[marker].powi(2)
        } else {
            0.0
        }
    }

    /// The puppet at `weights`: a pose for each frame.
    fn pose(&self, weights: &[f64]) -> Vec<MarkerPose> {
        let pose = |weights: &[f64]| {
            let mut pose = MarkerPose::default();
            self.puppet.pose(weights, &mut pose);
            pose
        };
        weights.par_chunks(self.channels()).map(pose).collect()
    }

    /// d of each marker, and what it is divided by (the sum of ρ / σ² over the frames, and 1 / τ²).
    fn offsets(&self, poses: &[MarkerPose]) -> Vec<(DVec3, f64)> {
        let mut sums = vec![(DVec3::ZERO, self.spread_m.powi(-2)); self.markers()];
        for (frame, pose) in poses.iter().enumerate() {
            for (marker, sum) in sums.iter_mut().enumerate() {
                let trust = self.trust(frame, marker);
                if trust > 0.0 {
                    sum.0 += trust * (self.frames[frame].1[marker] - pose.positions()[marker]);
                    sum.1 += trust;
                }
            }
        }
        for (sum, total) in &mut sums {
            *sum /= *total;
        }
        sums
    }

    /// E over w, with the best d for each w, and its gradient (that of E at that d).
    fn evaluate(&self, weights: &[f64], gradient: &mut [f64]) -> f64 {
        let width = self.channels();
        let mut poses = self.pose(weights);
        let offsets = self.offsets(&poses);
        let pull = 2.0 / self.usual_weight;
        let values: Vec<f64> = poses
            .par_iter_mut()
            .zip(gradient.par_chunks_mut(width))
            .zip(weights.par_chunks(width))
            .enumerate()
            .map(|(frame, ((pose, gradient), weights))| {
                let mut value = pull * weights.iter().sum::<f64>();
                let mut forces = vec![DVec3::ZERO; self.markers()];
                for (marker, force) in forces.iter_mut().enumerate() {
                    let trust = self.trust(frame, marker);
                    if trust > 0.0 {
                        let apart = self.frames[frame].1[marker] - pose.positions()[marker] - offsets[marker].0;
                        value += trust * apart.length_squared();
                        *force = -2.0 * trust * apart;
                    }
                }
                self.puppet.pull_back(pose, &forces, gradient);
                for entry in gradient {
                    *entry += pull;
                }
                value
            })
            .collect();
        // Summed in order, so that the result does not depend on the threads.
        let held: f64 = offsets.iter().map(|(offset, _)| offset.length_squared() * self.spread_m.powi(-2)).sum();
        values.iter().sum::<f64>() + held
    }

    /// The diagonal of E's Hessian at rest.
    fn curvature(&self) -> Vec<f64> {
        let (mut pose, mut jacobian) = (MarkerPose::default(), Vec::new());
        self.puppet.pose(&vec![0.0; self.channels()], &mut pose);
        self.puppet.jacobian(&pose, &mut jacobian);
        let of_frame = |frame: usize| {
            let column = |column: &[DVec3]| {
                let each = column.iter().enumerate();
                2.0 * each.map(|(marker, step)| self.trust(frame, marker) * step.length_squared()).sum::<f64>()
            };
            jacobian.chunks(self.markers()).map(column).collect::<Vec<_>>()
        };
        let mut diagonal: Vec<f64> = (0..self.frames.len()).flat_map(of_frame).collect();
        // Channels that no marker sees have no curvature of their own.
        let least = 1e-6 * diagonal.iter().copied().fold(1.0, f64::max);
        for entry in &mut diagonal {
            *entry = entry.max(least);
        }
        diagonal
    }

    /// Tells σ, τ and ρ anew.
    fn learn(&mut self, weights: &[f64]) {
        let (frames, markers) = (self.frames.len(), self.markers());
        let poses = self.pose(weights);
        let offsets = self.offsets(&poses);
        let mut lengths = vec![Vec::with_capacity(frames); markers];
        for (frame, pose) in poses.iter().enumerate() {
            for marker in 0..markers {
                let apart = self.frames[frame].1[marker] - pose.positions()[marker] - offsets[marker].0;
                if apart.is_finite() {
                    lengths[marker].push(apart.length());
                    let far = 3.0 * 3.0_f64.sqrt() * self.remainder_m[marker];
                    self.trust[frame * markers + marker] = (far / apart.length()).min(1.0);
                }
            }
        }
        // Each moved weight and each offset takes a coordinate's worth of the remainder away.
        let seen = 3.0 * lengths.iter().map(Vec::len).sum::<usize>() as f64;
        let moved = weights.iter().filter(|weight| **weight > 1e-4).count() as f64 + 3.0 * markers as f64;
        let lost = seen / (seen - moved).max(0.1 * seen);
        for (remainder, lengths) in self.remainder_m.iter_mut().zip(&mut lengths) {
            if !lengths.is_empty() {
                // The middle one, so that frames in which a marker is lost or mixed up do not make its noise large.
                let middle = lengths.len() / 2;
                let (_, median, _) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
                *remainder = (lost.sqrt() * *median / MEDIAN_LENGTH).max(LEAST_REMAINDER_M);
            }
        }
        let known = offsets.iter().zip(&lengths).filter(|(_, lengths)| !lengths.is_empty());
        let spreads: Vec<f64> = known.map(|((offset, total), _)| offset.length_squared() / 3.0 + 1.0 / total).collect();
        if frames > 1 && !spreads.is_empty() {
            self.spread_m = (spreads.iter().sum::<f64>() / spreads.len() as f64).sqrt();
        }
    }

    /// The puppet at rest.
    fn rest(&self) -> MarkerPose {
        let mut rest = MarkerPose::default();
        self.puppet.pose(&vec![0.0; self.channels()], &mut rest);
        rest
    }

    /// An anchor that moves nothing: the face at rest, at the first frame looked at. The same for every such take, so that a
    /// changed frame of it changes nothing behind.
    fn unmoved(&self, found: FoundAnchor) -> FoundAnchor {
        FoundAnchor {
            frame: self.frames[0].0,
            weights: vec![0.0; self.channels()],
            posed: self.rest().positions().iter().map(|point| point.as_vec3()).collect(),
            offsets: found.offsets.into_iter().map(|offset| offset.map(|_| Vec3::ZERO)).collect(),
            ..found
        }
    }

    fn outcome(&self, weights: &[f64]) -> FoundAnchor {
        let width = self.channels();
        let poses = self.pose(weights);
        let rest = self.rest();
        let from_rest = |pose: &MarkerPose| -> f64 {
            pose.positions().iter().zip(rest.positions()).map(|(a, b)| a.distance_squared(*b)).sum()
        };
        let calmest = (0..poses.len()).min_by(|a, b| from_rest(&poses[*a]).total_cmp(&from_rest(&poses[*b])));
        let anchor = calmest.unwrap_or_default();
        let seen = |marker: usize| self.frames.iter().any(|(_, points)| points[marker].is_finite());
        let offsets = self.offsets(&poses).into_iter().enumerate();
        FoundAnchor {
            frame: self.frames[anchor].0,
            weights: weights[anchor * width..(anchor + 1) * width].to_vec(),
            posed: poses[anchor].positions().iter().map(|point| point.as_vec3()).collect(),
            offsets: offsets.map(|(marker, (offset, _))| seen(marker).then(|| offset.as_vec3())).collect(),
            spread_mm: self.spread_m / MM,
            remaining_mm: self.remainder_m.iter().map(|remainder| remainder / MM).collect(),
        }
    }
}
