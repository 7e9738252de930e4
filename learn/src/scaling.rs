//! Standardisation: the shift and scale of every column, found in training and kept with the network.
//!
//! A network learns best when its inputs and targets are of the order of 1. But a column that holds only noise must not be
//! blown up to that size, since the noise of later data would then drown the rest. So scales have floors.

use crate::matrix::Matrix;
use crate::training::TargetScale;
use serde::{Deserialize, Serialize};

/// z = (x - mean) / scale for each column; means and scales have the column's own unit, z has none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    /// The mean of each column over the training samples.
    pub mean: Vec<f32>,
    /// What each column is divided by: positive, and not below the column's floor.
    pub scale: Vec<f32>,
}

/// A column whose standard deviation is below this fraction of its mean's size shows nothing but rounding: a few dozen
/// steps of an `f32`.
const ROUNDING: f64 = 2e-6;

/// Mean and standard deviation (over n, not n - 1) of every column, in double precision, rows in order.
fn spreads(matrix: &Matrix) -> Vec<(f64, f64)> {
    let count = matrix.rows() as f64;
    let mut sums = vec![0.0f64; matrix.columns()];
    for row in matrix.iter_rows() {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += f64::from(*value);
        }
    }
    let means: Vec<f64> = sums.iter().map(|sum| sum / count).collect();
    let mut squares = vec![0.0f64; matrix.columns()];
    for row in matrix.iter_rows() {
        for ((square, value), mean) in squares.iter_mut().zip(row).zip(&means) {
            *square += (f64::from(*value) - mean).powi(2);
        }
    }
    means.into_iter().zip(squares.iter().map(|square| (square / count).sqrt())).collect()
}

/// Root of the mean of the squares; 0 for nothing.
fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

/// A positive scale, or 1 where a column and all its floors are 0: every value is then equal to the mean, and z is 0.
fn positive(scale: f64) -> f32 {
    let scale = scale as f32;
    if scale >= f32::MIN_POSITIVE { scale } else { 1.0 }
}

impl Scaling {
    /// The scaling of features: scale = max(s, f, r * rms(s), rounding), where s is the column's standard deviation, f its
    /// floor from `floors` (in the column's unit), r = `floor` a fraction, rms(s) the root mean square of the standard
    /// deviations of all columns, and rounding [`ROUNDING`] times the size of the mean.
    pub(crate) fn of_features(matrix: &Matrix, floor: f32, floors: Option<&[f32]>) -> Self {
        let spreads = spreads(matrix);
        let common = f64::from(floor) * root_mean_square(spreads.iter().map(|(_, deviation)| *deviation));
        let scale = spreads.iter().enumerate().map(|(column, (mean, deviation))| {
            let own = floors.map_or(0.0, |floors| f64::from(floors[column]));
            positive(deviation.max(own).max(common).max(mean.abs() * ROUNDING))
        });
        Self { scale: scale.collect(), mean: spreads.iter().map(|(mean, _)| *mean as f32).collect() }
    }

    /// The scaling of targets: one scale for all columns (the root mean square of their standard deviations), or each
    /// column's own standard deviation, but at least a hundredth of the common one.
    pub(crate) fn of_targets(matrix: &Matrix, kind: TargetScale) -> Self {
        let spreads = spreads(matrix);
        let common = root_mean_square(spreads.iter().map(|(_, deviation)| *deviation));
        let scale = spreads.iter().map(|(_, deviation)| match kind {
            TargetScale::Common => positive(common),
            TargetScale::PerColumn => positive(deviation.max(common * 0.01)),
        });
        Self { scale: scale.collect(), mean: spreads.iter().map(|(mean, _)| *mean as f32).collect() }
    }

    /// z = (x - mean) / scale of one row.
    pub(crate) fn standardise<'a>(&'a self, row: &'a [f32]) -> impl Iterator<Item = f32> + 'a {
        row.iter().zip(self.mean.iter().zip(&self.scale)).map(|(value, (mean, scale))| (value - mean) / scale)
    }

    /// All rows standardised, row after row.
    pub(crate) fn standardise_all(&self, matrix: &Matrix) -> Vec<f32> {
        let mut values = Vec::with_capacity(matrix.values().len());
        for row in matrix.iter_rows() {
            values.extend(self.standardise(row));
        }
        values
    }

    /// x = mean + scale z of one column.
    pub(crate) fn restore(&self, column: usize, value: f32) -> f32 {
        self.scale[column].mul_add(value, self.mean[column])
    }

    /// Whether there is one finite mean and one positive, finite scale for each of `columns`.
    pub(crate) fn fits(&self, columns: usize) -> bool {
        self.mean.len() == columns
            && self.scale.len() == columns
            && self.mean.iter().all(|mean| mean.is_finite())
            && self.scale.iter().all(|scale| scale.is_finite() && *scale > 0.0)
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "the compared numbers are exact")]
mod tests {
    use super::*;

    /// Column 0 swings by 2, column 1 is constant, column 2 is noise of a millionth, column 3 is constant with a large mean.
    fn table() -> Matrix {
        Matrix::from_fn(100, 4, |row, column| {
            let sign = if row % 2 == 0 { 1.0 } else { -1.0 };
            [5.0 + 2.0 * sign, 0.25, 1e-6 * sign, 1e6][column]
        })
    }

    #[test]
    fn a_varying_column_becomes_unit() {
        let scaling = Scaling::of_features(&table(), 0.01, None);
        assert!((scaling.mean[0] - 5.0).abs() < 1e-6 && (scaling.scale[0] - 2.0).abs() < 1e-6);
        let values: Vec<f32> = scaling.standardise(table().row(0)).collect();
        assert!((values[0] - 1.0).abs() < 1e-6);
        assert!((scaling.restore(0, values[0]) - 7.0).abs() < 1e-5);
    }

    #[test]
    fn noise_is_not_blown_up() {
        let scaling = Scaling::of_features(&table(), 0.01, None);
        for row in table().iter_rows() {
            let values: Vec<f32> = scaling.standardise(row).collect();
            assert_eq!(values[1], 0.0);
            assert!(values[2].abs() < 1e-3, "noise became {}", values[2]);
            assert!(values[3].abs() < 1e-3, "a large constant became {}", values[3]);
        }
        let own = Scaling::of_features(&table(), 0.0, Some(&[0.0, 0.0, 0.5, 0.0]));
        assert_eq!(own.scale[2], 0.5, "the caller's floor holds in the column's unit");
    }

    #[test]
    fn constants_alone_have_a_scale() {
        let constant = Matrix::from_fn(3, 2, |_, _| 0.0);
        assert_eq!(Scaling::of_features(&constant, 0.01, None).scale, [1.0, 1.0]);
        assert_eq!(Scaling::of_targets(&constant, TargetScale::PerColumn).scale, [1.0, 1.0]);
    }

    #[test]
    fn targets_share_a_scale_or_have_their_own() {
        let common = Scaling::of_targets(&table(), TargetScale::Common);
        assert!(common.scale.iter().all(|scale| (scale - 1.0).abs() < 1e-6), "sqrt((4 + 0 + 0 + 0) / 4) = 1");
        let own = Scaling::of_targets(&table(), TargetScale::PerColumn);
        assert!((own.scale[0] - 2.0).abs() < 1e-6 && (own.scale[1] - 0.01).abs() < 1e-6);
    }
}
