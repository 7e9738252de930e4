//! What a network is trained on, and the checks it passes before anything is computed.

use crate::architecture::Architecture;
use crate::error::{Table, TrainError};
use crate::matrix::Matrix;

/// Training samples: row i of every table belongs to sample i.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Features, samples x `Architecture::inputs`.
    pub inputs: &'a Matrix,
    /// Conditioning values, samples x `Architecture::conditions`; `None` where the architecture has 0.
    pub conditions: Option<&'a Matrix>,
    /// What the network shall give, samples x `Architecture::outputs`.
    pub targets: &'a Matrix,
    /// For each column of the inputs, in its own unit, the smallest standard deviation that is worth learning from (for
    /// example the noise of the measurement); columns that vary less are not blown up. `None` leaves it to
    /// [`crate::Training::input_floor`], which compares columns with each other and so supposes that they have one unit.
    pub input_floors: Option<&'a [f32]>,
}

impl<'a> Samples<'a> {
    /// Unconditioned samples.
    pub fn new(inputs: &'a Matrix, targets: &'a Matrix) -> Self {
        Self { inputs, conditions: None, targets, input_floors: None }
    }

    /// The tables that there are, with the number of columns that the architecture wants of each.
    fn tables(&self, architecture: &Architecture) -> Vec<(Table, Option<&'a Matrix>, usize)> {
        vec![
            (Table::Inputs, Some(self.inputs), architecture.inputs),
            (Table::Conditions, self.conditions, architecture.conditions),
            (Table::Targets, Some(self.targets), architecture.outputs),
        ]
    }

    /// Tells whether the tables fit each other and the architecture and hold finite numbers only.
    pub(crate) fn check(&self, architecture: &Architecture) -> Result<(), TrainError> {
        let rows = self.inputs.rows();
        if rows == 0 {
            return Err(TrainError::NoSamples);
        }
        for (table, matrix, expected) in self.tables(architecture) {
            let found = matrix.map_or(0, Matrix::columns);
            if found != expected {
                return Err(TrainError::Columns { table, found, expected });
            }
            let Some(matrix) = matrix else { continue };
            if matrix.rows() != rows {
                return Err(TrainError::Rows { table, found: matrix.rows(), expected: rows });
            }
            if let Some((row, column, value)) = matrix.first_non_finite() {
                return Err(TrainError::NonFinite { table, row, column, value });
            }
        }
        self.check_floors()
    }

    /// A number that changes with any bit of the samples: each 32 bits are mixed in by a multiplication (not for secrets).
    pub(crate) fn fingerprint(&self) -> u64 {
        let conditions = self.conditions.map_or(&[][..], Matrix::values);
        let tables = [self.inputs.values(), conditions, self.targets.values(), self.input_floors.unwrap_or(&[])];
        let mut print = 0u64;
        let mut mix = |bits: u64| print = (print.rotate_left(5) ^ bits).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        for values in tables {
            mix(values.len() as u64);
            for value in values {
                mix(u64::from(value.to_bits()));
            }
        }
        print
    }

    /// Tells whether there is one floor a column, each finite and not negative.
    fn check_floors(&self) -> Result<(), TrainError> {
        let Some(floors) = self.input_floors else { return Ok(()) };
        let expected = self.inputs.columns();
        let bad = floors.iter().position(|floor| !floor.is_finite() || *floor < 0.0);
        if floors.len() != expected || bad.is_some() {
            return Err(TrainError::InputFloors { found: floors.len(), expected, column: bad });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: usize, columns: usize) -> Matrix {
        Matrix::from_fn(rows, columns, |row, column| (row + column) as f32)
    }

    #[test]
    fn misfits_are_named_with_numbers() {
        let architecture = Architecture { conditions: 1, ..Architecture::new(3, 2, 4, 1) };
        let (inputs, targets, conditions) = (table(5, 3), table(5, 2), table(4, 1));
        let samples = Samples::new(&inputs, &targets);
        let missing = samples.check(&architecture).unwrap_err();
        assert_eq!(missing, TrainError::Columns { table: Table::Conditions, found: 0, expected: 1 });
        let short = Samples { conditions: Some(&conditions), ..samples }.check(&architecture).unwrap_err();
        assert_eq!(short, TrainError::Rows { table: Table::Conditions, found: 4, expected: 5 });
        let empty = table(0, 3);
        assert_eq!(Samples::new(&empty, &targets).check(&architecture).unwrap_err(), TrainError::NoSamples);
    }

    #[test]
    fn the_first_bad_value_is_found() {
        let architecture = Architecture::new(3, 2, 4, 1);
        let mut values = table(5, 2).into_values();
        values[7] = f32::NAN;
        let (inputs, targets) = (table(5, 3), Matrix::new(5, 2, values).unwrap());
        let error = Samples::new(&inputs, &targets).check(&architecture).unwrap_err();
        assert!(matches!(error, TrainError::NonFinite { table: Table::Targets, row: 3, column: 1, .. }), "{error}");
        assert!(error.to_string().contains("row 3, column 1 of the targets"), "{error}");
    }

    #[test]
    fn floors_must_fit() {
        let architecture = Architecture::new(3, 2, 4, 1);
        let (inputs, targets) = (table(5, 3), table(5, 2));
        let samples = Samples { input_floors: Some(&[0.1, -1.0, 0.0]), ..Samples::new(&inputs, &targets) };
        let error = samples.check(&architecture).unwrap_err();
        assert_eq!(error, TrainError::InputFloors { found: 3, expected: 3, column: Some(1) });
    }
}
