//! Face matching: the weights whose puppet markers are nearest to the captured ones, frame by frame. The method that FDLS
//! is compared with, and what there is before any network is trained.
//!
//! Eq. 2 of FDLS: w = argmin ‖b₀ + B w − x‖², 0 ≤ w ≤ 1, with x the captured markers, b₀ the puppet's at rest (metres) and
//! the columns of B the puppet's markers with one channel at 1, minus b₀ (Eq. 1): the rig taken as linear, its correctives
//! and in-betweens left out. Each frame is solved exactly ([`BoundedQuadratic`]), from where the one before left off.
//! Markers that are missing in a frame are left out of it.

use super::bounded::{BoundedError, BoundedQuadratic, WarmStart};
use crate::data::{Curves, DataError, Markers};
use crate::rig::{MarkerPose, MarkerRig};
use glam::DVec3;

/// How to match.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchOptions {
    /// The least weight.
    pub low: f64,
    /// The largest weight.
    pub high: f64,
    /// λ: how strongly weights are drawn to 0, as a share of the mean square of B's columns. 0 is Eq. 2 itself.
    pub rest: f64,
}

impl Default for MatchOptions {
    fn default() -> Self {
        Self { low: 0.0, high: 1.0, rest: 0.0 }
    }
}

/// Why markers cannot be matched.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MatchError {
    /// The take and the puppet share no marker.
    #[error("the take and the puppet share no marker; attach the take's own neutral markers")]
    NoMarker,
    /// A frame shows none of the markers.
    #[error("frame {frame} shows none of the puppet's markers; fill gaps first")]
    Blind {
        /// The number of the frame, as the take counts.
        frame: i64,
    },
    /// An option is not usable.
    #[error("{what} is {value}; {cure}")]
    Option {
        /// The option.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What to give instead.
        cure: &'static str,
    },
    /// A frame has no answer.
    #[error("frame {frame}: {source}")]
    Frame {
        /// The number of the frame.
        frame: i64,
        /// Why.
        source: BoundedError,
    },
    /// The results do not fit together.
    #[error(transparent)]
    Data(#[from] DataError),
}

/// The linear puppet of a take: what all frames share.
#[derive(Debug, Clone)]
pub struct LinearPuppet {
    channels: Vec<String>,
    /// Columns of the take's markers, in the order of the rows.
    columns: Vec<usize>,
    /// b₀, in metres.
    rest: Vec<DVec3>,
    /// B: three rows a marker (x, y, z), a column a channel, row after row, in metres.
    basis: Vec<f64>,
    options: MatchOptions,
}

/// The programme of the markers that a frame shows, kept from frame to frame.
struct Shown {
    rows: Vec<bool>,
    quadratic: BoundedQuadratic,
    start: WarmStart,
}

impl LinearPuppet {
    /// The linear puppet of those markers of `puppet` that `take` has.
    ///
    /// # Errors
    /// Where they share none, or an option is not usable.
    pub fn new(puppet: &MarkerRig, take: &Markers, options: MatchOptions) -> Result<Self, MatchError> {
        let refuse = |what, value, cure| Err(MatchError::Option { what, value, cure });
        if !(options.low <= options.high && options.low.is_finite() && options.high.is_finite()) {
            return refuse("the least weight", options.low, "keep it below the largest one");
        }
        if !(options.rest >= 0.0 && options.rest.is_finite()) {
            return refuse("the pull to rest", options.rest, "give 0 or more");
        }
        let shared: Vec<(usize, usize)> =
            puppet.names().iter().enumerate().filter_map(|(place, name)| Some((place, take.index(name)?))).collect();
        if shared.is_empty() {
            return Err(MatchError::NoMarker);
        }
        let (mut pose, mut weights) = (MarkerPose::default(), vec![0.0; puppet.channels().len()]);
        puppet.pose(&weights, &mut pose);
        let rest: Vec<DVec3> = shared.iter().map(|(place, _)| pose.positions()[*place]).collect();
        let width = weights.len();
        let mut basis = vec![0.0; 3 * shared.len() * width];
        for channel in 0..width {
            weights.fill(0.0);
            weights[channel] = 1.0;
            puppet.pose(&weights, &mut pose);
            for (row, (place, _)) in shared.iter().enumerate() {
                let delta = pose.positions()[*place] - rest[row];
                for axis in 0..3 {
                    basis[(3 * row + axis) * width + channel] = delta[axis];
                }
            }
        }
        let columns = shared.iter().map(|(_, column)| *column).collect();
        Ok(Self { channels: puppet.channels().to_vec(), columns, rest, basis, options })
    }

    /// B: three rows a shared marker (x, y, z), a column a channel, row after row, in metres.
    pub fn basis(&self) -> &[f64] {
        &self.basis
    }

    /// x − b₀ of a frame: three numbers a shared marker, in metres; 0 for missing markers.
    pub fn offsets(&self, take: &Markers, frame: usize) -> Vec<f64> {
        let mut offsets = Vec::new();
        self.offsets_into(take, frame, &mut offsets, &mut Vec::new());
        offsets
    }

    fn offsets_into(&self, take: &Markers, frame: usize, offsets: &mut Vec<f64>, rows: &mut Vec<bool>) {
        offsets.clear();
        rows.clear();
        for (column, rest) in self.columns.iter().zip(&self.rest) {
            let point = take.frame(frame)[*column].as_dvec3();
            let seen = point.is_finite();
            rows.push(seen);
            offsets.extend(if seen { (point - *rest).to_array() } else { [0.0; 3] });
        }
    }

    /// H = Bᵀ B over the markers in `rows`, and what keeps weights at rest.
    fn shown(&self, rows: &[bool]) -> Result<Shown, BoundedError> {
        let width = self.channels.len();
        let mut matrix = vec![0.0; width * width];
        for (marker, _) in rows.iter().enumerate().filter(|(_, seen)| **seen) {
            for row in self.basis[3 * marker * width..3 * (marker + 1) * width].chunks_exact(width) {
                for (i, factor) in row.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                    for (entry, other) in matrix[i * width..(i + 1) * width].iter_mut().zip(row) {
                        *entry += factor * other;
                    }
                }
            }
        }
        let mean = (0..width).map(|i| matrix[i * width + i]).sum::<f64>() / width.max(1) as f64;
        for i in 0..width {
            matrix[i * width + i] += self.options.rest * mean;
        }
        let bounds = |value: f64| vec![value; width];
        let quadratic = BoundedQuadratic::new(matrix, bounds(self.options.low), bounds(self.options.high))?;
        let start = quadratic.cold();
        Ok(Shown { rows: rows.to_vec(), quadratic, start })
    }

    /// Bᵀ(x − b₀).
    fn project(&self, offsets: &[f64], right: &mut Vec<f64>) {
        let width = self.channels.len();
        right.clear();
        right.resize(width, 0.0);
        for (row, offset) in self.basis.chunks_exact(width.max(1)).zip(offsets) {
            if *offset != 0.0 {
                for (sum, entry) in right.iter_mut().zip(row) {
                    *sum += offset * entry;
                }
            }
        }
    }

    /// The weights of all frames of `take`, which has the markers that this puppet was made for.
    ///
    /// # Errors
    /// Where a frame shows no marker, or has no answer.
    pub fn solve(&self, take: &Markers) -> Result<Curves, MatchError> {
        let axis = take.frame_axis();
        let number = |frame: usize| axis.slice(&(frame..frame + 1)).first;
        let mut values = Vec::with_capacity(axis.count * self.channels.len());
        let (mut offsets, mut right, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        let mut shown: Option<Shown> = None;
        for frame in 0..axis.count {
            self.offsets_into(take, frame, &mut offsets, &mut rows);
            if !rows.contains(&true) {
                return Err(MatchError::Blind { frame: number(frame) });
            }
            self.project(&offsets, &mut right);
            let failed = |source| MatchError::Frame { frame: number(frame), source };
            let kept = shown.take().filter(|shown| shown.rows == rows);
            let own = shown.insert(kept.map_or_else(|| self.shown(&rows), Ok).map_err(failed)?);
            let weights = own.quadratic.solve(&right, &mut own.start).map_err(failed)?;
            values.extend(weights.iter().map(|weight| *weight as f32));
        }
        Ok(Curves::new(axis, self.channels.clone(), values)?)
    }
}

/// Matches the markers of every frame of `take` (metres) with those of `puppet`, taken as linear.
///
/// # Errors
/// See [`MatchError`].
pub fn match_markers(puppet: &MarkerRig, take: &Markers, options: MatchOptions) -> Result<Curves, MatchError> {
    LinearPuppet::new(puppet, take, options)?.solve(take)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Attachment, Driver, Rig, SurfacePoint};
    use crate::rig::toy;
    use glam::Vec3;
    use wire::FrameAxis;

    /// The toy head without what is not linear.
    fn linear() -> Rig {
        let mut rig = toy::rig(6, 5);
        rig.shapes.retain(|shape| matches!(shape.driver, Driver::Channel(_)));
        rig
    }

    fn puppet(rig: &Rig) -> MarkerRig {
        let points = rig.parts[0].triangles.iter().step_by(4).enumerate().map(|(index, triangle)| {
            let name = format!("m{index}");
            SurfacePoint { name, vertices: *triangle, weights: [0.4, 0.3, 0.3], distance_m: 0.0 }
        });
        MarkerRig::attached(rig, &Attachment { points: points.collect() }).unwrap()
    }

    fn curves(rig: &Rig, frames: usize) -> Curves {
        let mut dice = toy::Dice(9);
        // Some weights lie at their bounds, as most do in takes.
        let values = (0..frames * rig.channels.len()).map(|_| (1.5 * dice.roll()).clamp(0.0, 1.0)).collect();
        let axis = FrameAxis { first: 101, count: frames, rate_hz: 60.0 };
        Curves::new(axis, rig.channels.clone(), values).unwrap()
    }

    #[test]
    fn the_weights_of_a_linear_puppet_come_back() {
        let rig = linear();
        let (puppet, truth) = (puppet(&rig), curves(&rig, 50));
        let found = match_markers(&puppet, &puppet.drive(&truth).unwrap(), MatchOptions::default()).unwrap();
        assert_eq!(found.channels(), truth.channels());
        for (found, known) in found.values().iter().zip(truth.values()) {
            assert!((found - known).abs() < 1e-4, "{found} {known}");
        }
    }

    #[test]
    fn missing_markers_are_left_out_and_a_blind_frame_is_named() {
        let rig = linear();
        let (puppet, truth) = (puppet(&rig), curves(&rig, 20));
        let take = puppet.drive(&truth).unwrap();
        let width = take.names().len();
        let mut positions = take.positions().to_vec();
        for frame in 0..20 {
            positions[frame * width + (frame / 4) % width] = Vec3::NAN;
        }
        let gappy = take.with_positions(positions.clone()).unwrap();
        let found = match_markers(&puppet, &gappy, MatchOptions::default()).unwrap();
        for (found, known) in found.values().iter().zip(truth.values()) {
            assert!((found - known).abs() < 1e-4, "{found} {known}");
        }
        positions[7 * width..8 * width].fill(Vec3::NAN);
        let blind = match_markers(&puppet, &take.with_positions(positions).unwrap(), MatchOptions::default());
        assert_eq!(blind.unwrap_err(), MatchError::Blind { frame: 108 });
    }

    #[test]
    fn the_pull_to_rest_and_the_bounds_do_what_they_say() {
        let rig = linear();
        let (puppet, truth) = (puppet(&rig), curves(&rig, 5));
        let take = puppet.drive(&truth).unwrap();
        let total = |options| match_markers(&puppet, &take, options).unwrap().values().iter().sum::<f32>();
        let usual = MatchOptions::default();
        assert!(total(MatchOptions { rest: 10.0, ..usual }) < 0.3 * total(usual));
        let half = match_markers(&puppet, &take, MatchOptions { high: 0.5, ..usual }).unwrap();
        assert!(half.values().iter().all(|weight| (0.0..=0.5).contains(weight)));
        assert!(match_markers(&puppet, &take, MatchOptions { low: 2.0, ..usual }).is_err());
        assert!(match_markers(&puppet, &take, MatchOptions { rest: -1.0, ..usual }).is_err());
        let other = Markers::new(take.frame_axis(), vec!["x".into()], vec![Vec3::ZERO; 5]).unwrap();
        assert_eq!(match_markers(&puppet, &other, usual).unwrap_err(), MatchError::NoMarker);
    }
}
