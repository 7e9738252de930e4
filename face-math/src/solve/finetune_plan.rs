//! Fine-tuning, one frame at a time: what all frames share, and the objective that [`super::finetune`](super::finetune())
//! describes.

use super::finetune::{FinetuneError, FinetuneOptions};
use super::minimise::{Metric, MinimiseError, MinimiseOptions, Stop, minimise};
use crate::data::{Curves, DataError, Markers, nearest_name};
use crate::rig::{MarkerPose, MarkerRig};
use glam::DVec3;

/// What all frames share.
pub(super) struct Plan<'a> {
    puppet: &'a MarkerRig,
    /// Columns of the puppet's channels in the raw curves.
    columns: Vec<usize>,
    /// The channels to move.
    moved: Vec<usize>,
    /// Per marker of the puppet that counts: its place, its column among the captured ones, 1 / σ² (a square metre).
    matched: Vec<(usize, usize, f64)>,
    /// 1 / ρ² of the channels to move.
    holds: Vec<f64>,
    bounds: Vec<(f64, f64)>,
}

/// Buffers used again from frame to frame.
#[derive(Default)]
pub(super) struct Scratch {
    pose: MarkerPose,
    jacobian: Vec<DVec3>,
    forces: Vec<DVec3>,
    gradient: Vec<f64>,
}

/// One frame solved.
pub(super) struct Solved {
    pub(super) values: Vec<f32>,
    /// Markers seen.
    pub(super) seen: usize,
    pub(super) steps: usize,
    pub(super) stop: Stop,
}

/// What can be wrong with a frame.
pub(super) enum Fault {
    Weight { channel: String, value: f32 },
    Minimise(MinimiseError),
}

impl Fault {
    pub(super) fn at(self, frame: i64) -> FinetuneError {
        match self {
            Self::Weight { channel, value } => FinetuneError::Weight { channel, frame, value },
            Self::Minimise(source) => FinetuneError::Frame { frame, source },
        }
    }
}

/// Metres a millimetre.
const MM: f64 = 1e-3;

impl<'a> Plan<'a> {
    pub(super) fn new(
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
        let positive = |what: &str, value: f64| match value {
            value if value > 0.0 && value.is_finite() => Ok(()),
            value => refuse(what, value, "give a positive number"),
        };
        positive("the noise of the markers", options.default_noise_mm)?;
        positive("the error of the raw solve", options.default_raw_error)?;
        if options.low.is_nan() || options.high.is_nan() || options.low > options.high {
            refuse("the least weight", options.low, "keep it below the largest weight")?;
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
        for (name, error) in &options.raw_error {
            find("channel", name, channels)?;
            positive(&format!("the raw error of channel `{name}`"), *error)?;
        }
        let holds = moved
            .iter()
            .map(|channel| options.raw_error.get(&channels[*channel]).unwrap_or(&options.default_raw_error).powi(-2));
        for (name, noise) in &options.noise_mm {
            positive(&format!("the noise of marker `{name}`"), *noise)?;
        }
        for name in &options.markers {
            find("marker on the puppet", name, puppet.names())?;
            find("captured marker", name, captured.names())?;
        }
        let mut matched = Vec::new();
        for (place, name) in puppet.names().iter().enumerate() {
            let chosen = options.markers.is_empty() || options.markers.contains(name);
            if let (Some(column), true) = (captured.index(name), chosen) {
                let noise = MM * options.noise_mm.get(name).unwrap_or(&options.default_noise_mm);
                matched.push((place, column, noise.powi(-2)));
            }
        }
        if matched.is_empty() {
            return Err(FinetuneError::NoMarker);
        }
        let bounds = vec![(options.low, options.high); moved.len()];
        let holds = holds.collect();
        Ok(Self { puppet, columns, moved, matched, holds, bounds })
    }

    pub(super) fn solve(
        &self,
        raw: &Curves,
        captured: &Markers,
        frame: usize,
        scratch: &mut Scratch,
    ) -> Result<Solved, Fault> {
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
                    value += weight * apart.length_squared();
                    scratch.forces[*place] = 2.0 * *weight * apart;
                }
                scratch.gradient.resize(weights.len(), 0.0);
                self.puppet.pull_back(&mut scratch.pose, &scratch.forces, &mut scratch.gradient);
                for (i, channel) in self.moved.iter().enumerate() {
                    let shift = x[i] - start[i];
                    value += self.holds[i] * shift * shift;
                    gradient[i] = scratch.gradient[*channel] + 2.0 * self.holds[i] * shift;
                }
                value
            },
            &start,
            &self.bounds,
            &metric,
            &MinimiseOptions { gradient_tolerance: 1e-4, max_steps: 200, memory: 8 },
        )
        .map_err(Fault::Minimise)?;
        let mut values = own.to_vec();
        for (channel, x) in self.moved.iter().zip(&found.x) {
            values[self.columns[*channel]] = *x as f32;
        }
        Ok(Solved { values, seen: targets.len(), steps: found.steps, stop: found.stop })
    }

    /// 2 Jᵀ diag(1/σ²) J + 2 diag(1/ρ²) over the moved channels.
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
                targets.iter().map(|(place, _, weight)| weight.sqrt() * column[*place]).collect()
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
        for (i, hold) in self.holds.iter().enumerate() {
            matrix[i * size + i] += 2.0 * hold;
        }
        Metric::Dense(matrix)
    }
}
