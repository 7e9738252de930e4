//! How far a solve is off: in millimetres at the markers, and in weights where the truth is known.

use crate::data::{Curves, DataError, Markers};
use wire::AxisError;

/// How far two sets of markers are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerError {
    /// Root mean square distance over all markers and frames seen in both, in millimetres.
    pub rms_mm: f64,
    /// The same for each marker, in the order of the first set; none for a marker that no frame shows in both.
    pub by_marker_mm: Vec<(String, Option<f64>)>,
    /// The same for each frame; none for a frame without a marker seen in both.
    pub by_frame_mm: Vec<Option<f64>>,
    /// The largest distance: marker, number of the frame, millimetres.
    pub worst: (String, i64, f64),
}

/// How far two sets of curves are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct WeightError {
    /// Root mean square difference over all frames and channels of the truth, unitless.
    pub rms: f64,
    /// The same for each channel of the truth.
    pub by_channel: Vec<(String, f64)>,
}

/// Why two values cannot be measured against each other.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// They do not hold the same frames.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// A name is not there.
    #[error(transparent)]
    Data(#[from] DataError),
    /// No name and frame hold a value on both sides.
    #[error("nothing to measure: no name and frame hold a value on both sides")]
    NothingShared,
    /// A weight is not a number.
    #[error("channel `{channel}` is {value} in frame {frame}; mend the curve first")]
    Weight {
        /// The channel.
        channel: String,
        /// Number of the frame, as its source counts.
        frame: i64,
        /// The weight.
        value: f32,
    },
}

/// Distances between the markers of the same name in `one` and `other` (metres), frame by frame, for example the puppet's
/// and the captured ones. Missing markers are passed over.
///
/// A distance is that of two points in space, √(Δx² + Δy² + Δz²).
///
/// # Errors
/// Where the frames differ, or no marker is seen in both.
pub fn marker_error(one: &Markers, other: &Markers) -> Result<MarkerError, MeasureError> {
    one.frame_axis().matches(&other.frame_axis())?;
    let columns: Vec<_> = one.names().iter().map(|name| other.index(name)).collect();
    let mut by_marker = vec![Sum::default(); columns.len()];
    let mut by_frame = vec![Sum::default(); one.frames()];
    let (mut all, mut worst) = (Sum::default(), None);
    for (frame, frame_sum) in by_frame.iter_mut().enumerate() {
        for (marker, (column, marker_sum)) in columns.iter().zip(&mut by_marker).enumerate() {
            let Some(column) = column else { continue };
            let apart = one.frame(frame)[marker].as_dvec3() - other.frame(frame)[*column].as_dvec3();
            let square = apart.length_squared() * 1e6;
            if !square.is_finite() {
                continue;
            }
            for sum in [&mut all, marker_sum, &mut *frame_sum] {
                sum.add(square);
            }
            if worst.is_none_or(|(_, _, most)| square > most) {
                worst = Some((marker, frame, square));
            }
        }
    }
    let (Some(rms_mm), Some((marker, frame, square))) = (all.root_mean(), worst) else {
        return Err(MeasureError::NothingShared);
    };
    let roots = |sums: Vec<Sum>| sums.iter().map(Sum::root_mean).collect::<Vec<_>>();
    Ok(MarkerError {
        rms_mm,
        by_marker_mm: one.names().iter().cloned().zip(roots(by_marker)).collect(),
        by_frame_mm: roots(by_frame),
        worst: (one.names()[marker].clone(), one.frame_axis().slice(&(frame..frame + 1)).first, square.sqrt()),
    })
}

/// Differences between `solved` and `truth`, over the channels of the truth.
///
/// # Errors
/// Where the frames differ, a channel of the truth is not solved, or a weight is not a number.
pub fn weight_error(truth: &Curves, solved: &Curves) -> Result<WeightError, MeasureError> {
    truth.frame_axis().matches(&solved.frame_axis())?;
    let solved = solved.arrange(truth.channels(), None)?;
    let mut by_channel = vec![Sum::default(); truth.channels().len()];
    let mut all = Sum::default();
    for frame in 0..truth.frames() {
        for (channel, sum) in by_channel.iter_mut().enumerate() {
            let (known, found) = (truth.frame(frame)[channel], solved.frame(frame)[channel]);
            if let Some(value) = [known, found].into_iter().find(|value| !value.is_finite()) {
                let frame = truth.frame_axis().slice(&(frame..frame + 1)).first;
                return Err(MeasureError::Weight { channel: truth.channels()[channel].clone(), frame, value });
            }
            let square = (f64::from(known) - f64::from(found)).powi(2);
            sum.add(square);
            all.add(square);
        }
    }
    let rms = all.root_mean().ok_or(MeasureError::NothingShared)?;
    let by_channel = by_channel.iter().map(|sum| sum.root_mean().unwrap_or_default());
    Ok(WeightError { rms, by_channel: truth.channels().iter().cloned().zip(by_channel).collect() })
}

#[derive(Clone, Copy, Default)]
struct Sum {
    squares: f64,
    count: usize,
}

impl Sum {
    fn add(&mut self, square: f64) {
        self.squares += square;
        self.count += 1;
    }

    fn root_mean(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares / self.count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use wire::FrameAxis;

    fn markers(names: &[&str], positions: Vec<Vec3>) -> Markers {
        let axis = FrameAxis { first: 5, count: positions.len() / names.len(), rate_hz: 60.0 };
        Markers::new(axis, names.iter().map(|name| (*name).to_owned()).collect(), positions).unwrap()
    }

    fn curves(names: &[&str], values: Vec<f32>) -> Curves {
        let axis = FrameAxis::new(values.len() / names.len(), 60.0);
        Curves::new(axis, names.iter().map(|name| (*name).to_owned()).collect(), values).unwrap()
    }

    #[test]
    fn distances_are_those_of_points_in_space() {
        let one = markers(&["a", "b", "own"], vec![Vec3::ZERO, Vec3::X, Vec3::X, Vec3::ZERO, Vec3::NAN, Vec3::X]);
        let near = Vec3::new(0.001, 0.002, 0.002);
        let other = markers(&["b", "a"], vec![Vec3::X, near, Vec3::X, Vec3::ZERO]);
        let error = marker_error(&one, &other).unwrap();
        assert!((error.rms_mm - 3.0_f64.sqrt()).abs() < 1e-6);
        assert_eq!(error.by_marker_mm[1], ("b".to_owned(), Some(0.0)));
        assert_eq!(error.by_marker_mm[2], ("own".to_owned(), None));
        assert_eq!(error.by_frame_mm[1], Some(0.0));
        assert_eq!((error.worst.0.as_str(), error.worst.1), ("a", 5));
        assert!((error.worst.2 - 3.0).abs() < 1e-6);
        let stranger = markers(&["c"], vec![Vec3::ZERO; 2]);
        assert_eq!(marker_error(&one, &stranger).unwrap_err(), MeasureError::NothingShared);
    }

    #[test]
    fn weights_are_compared_over_the_channels_of_the_truth() {
        let truth = curves(&["smile", "frown"], vec![0.0, 1.0, 0.5, 0.5]);
        let solved = curves(&["frown", "extra", "smile"], vec![1.0, 9.0, 0.2, 0.5, 9.0, 0.5]);
        let error = weight_error(&truth, &solved).unwrap();
        assert!((error.rms - 0.1).abs() < 1e-7);
        assert_eq!(error.by_channel[1], ("frown".to_owned(), 0.0));
        let short = curves(&["frown", "smil"], vec![0.0; 4]);
        assert!(weight_error(&truth, &short).unwrap_err().to_string().contains("did you mean `smil`"));
        let broken = curves(&["smile", "frown"], vec![0.0, 1.0, f32::NAN, 0.5]);
        assert!(matches!(weight_error(&truth, &broken), Err(MeasureError::Weight { frame: 1, .. })));
        assert!(matches!(weight_error(&truth, &curves(&["smile"], vec![0.0])), Err(MeasureError::Axis(_))));
    }
}
