//! The table of numbers that samples come in and predictions go out in.

use crate::error::MatrixError;
use serde::{Deserialize, Serialize};

/// A dense table of `f32`, stored row after row: value (r, c) stands at `r * columns + c`. A row is a sample (a frame), a
/// column is a feature (a channel). It always holds exactly `rows * columns` values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts")]
pub struct Matrix {
    rows: usize,
    columns: usize,
    values: Vec<f32>,
}

/// What a stored matrix holds before its size has been checked.
#[derive(Deserialize)]
struct Parts {
    rows: usize,
    columns: usize,
    values: Vec<f32>,
}

impl TryFrom<Parts> for Matrix {
    type Error = MatrixError;

    fn try_from(parts: Parts) -> Result<Self, MatrixError> {
        Self::new(parts.rows, parts.columns, parts.values)
    }
}

impl Matrix {
    /// A matrix of `rows` x `columns` from values that stand row after row.
    ///
    /// # Errors
    /// [`MatrixError::Size`] when there are not `rows * columns` values.
    pub fn new(rows: usize, columns: usize, values: Vec<f32>) -> Result<Self, MatrixError> {
        if rows.checked_mul(columns) == Some(values.len()) {
            Ok(Self { rows, columns, values })
        } else {
            Err(MatrixError::Size { rows, columns, values: values.len() })
        }
    }

    /// A matrix from rows of equal length. No rows give a matrix of 0 x 0.
    ///
    /// # Errors
    /// [`MatrixError::Ragged`] with the first row whose length differs from that of row 0.
    pub fn from_rows<R: AsRef<[f32]>>(rows: &[R]) -> Result<Self, MatrixError> {
        let columns = rows.first().map_or(0, |row| row.as_ref().len());
        let mut values = Vec::with_capacity(rows.len() * columns);
        for (index, row) in rows.iter().enumerate() {
            let row = row.as_ref();
            if row.len() != columns {
                return Err(MatrixError::Ragged { row: index, found: row.len(), expected: columns });
            }
            values.extend_from_slice(row);
        }
        Ok(Self { rows: rows.len(), columns, values })
    }

    /// A matrix whose value (r, c) is `value(r, c)`.
    pub fn from_fn(rows: usize, columns: usize, mut value: impl FnMut(usize, usize) -> f32) -> Self {
        let mut values = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            values.extend((0..columns).map(|column| value(row, column)));
        }
        Self { rows, columns, values }
    }

    /// A matrix from as many values as it has places.
    pub(crate) fn of_known_size(rows: usize, columns: usize, values: Vec<f32>) -> Self {
        debug_assert_eq!(rows * columns, values.len());
        Self { rows, columns, values }
    }

    /// How many rows (samples) there are.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many columns (features) a row has.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// All values, row after row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The values, row after row, without a copy.
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// One row: `columns` values.
    ///
    /// # Panics
    /// When `row` is not below [`Matrix::rows`], as indexing a slice does.
    pub fn row(&self, row: usize) -> &[f32] {
        &self.values[row * self.columns..(row + 1) * self.columns]
    }

    /// The rows in order, each with `columns` values.
    pub fn iter_rows(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        (0..self.rows).map(|row| self.row(row))
    }

    /// A copy of `count` rows from row `first` on.
    ///
    /// # Panics
    /// When the range does not lie within the matrix, as slicing does.
    #[must_use]
    pub fn slice_rows(&self, first: usize, count: usize) -> Self {
        let values = self.values[first * self.columns..(first + count) * self.columns].to_vec();
        Self { rows: count, columns: self.columns, values }
    }

    /// Row, column and value of the first value that is not finite, if there is one.
    pub(crate) fn first_non_finite(&self) -> Option<(usize, usize, f32)> {
        let index = self.values.iter().position(|value| !value.is_finite())?;
        Some((index / self.columns, index % self.columns, self.values[index]))
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "the compared numbers are exact")]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_values_must_fit() {
        let error = Matrix::new(2, 3, vec![0.0; 5]).unwrap_err();
        assert_eq!(error, MatrixError::Size { rows: 2, columns: 3, values: 5 });
        assert!(Matrix::new(usize::MAX, 2, vec![0.0; 2]).is_err(), "an overflowing size must not wrap");
    }

    #[test]
    fn rows_come_back_as_they_went_in() {
        let matrix = Matrix::from_rows(&[[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]).unwrap();
        assert_eq!((matrix.rows(), matrix.columns()), (3, 2));
        assert_eq!(matrix.row(1), [3.0, 4.0]);
        assert_eq!(matrix.slice_rows(1, 2).values(), [3.0, 4.0, 5.0, 6.0]);
        let ragged = Matrix::from_rows(&[vec![1.0], vec![2.0, 3.0]]).unwrap_err();
        assert_eq!(ragged, MatrixError::Ragged { row: 1, found: 2, expected: 1 });
    }

    #[test]
    fn a_stored_matrix_is_checked_when_read() {
        let error = serde_json::from_str::<Matrix>(r#"{"rows":2,"columns":2,"values":[1.0]}"#).unwrap_err();
        assert!(error.to_string().contains("2 x 2"), "{error}");
    }
}
