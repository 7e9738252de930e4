//! Reduces a value to what a snapshot holds: of each of its tables some rows, and statistics over all of them.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::{Digest, Rows, Table, Value};

/// Rows of a table that are held as they are, spread evenly from the first to the last.
const ROWS: usize = 24;
/// Columns of a table that are held; of wider tables, some that are spread evenly.
const COLUMNS: usize = 96;

/// A value as a snapshot holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reduced {
    /// Digest of the whole value.
    pub digest: String,
    /// One line for people.
    pub summary: String,
    /// Its tables, by name.
    #[serde(default)]
    pub tables: BTreeMap<String, ReducedTable>,
}

/// A table as a snapshot holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReducedTable {
    /// The unit of its numbers.
    pub unit: String,
    /// What its rows are: `600 frames from 0 at 60 Hz`.
    pub rows: String,
    /// How many columns it has.
    pub width: usize,
    /// Over all numbers.
    pub all: Statistics,
    /// What the rows are called that are held.
    pub held: Vec<String>,
    /// Columns by their names.
    pub columns: BTreeMap<String, Column>,
}

/// Statistics over numbers, in their unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statistics {
    /// How many numbers are not there (NaN).
    pub missing: usize,
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// The mean.
    pub mean: f64,
}

/// A column as a snapshot holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// How many numbers are not there (NaN).
    pub missing: usize,
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// The mean.
    pub mean: f64,
    /// Root mean square of the change from row to row.
    pub step: f64,
    /// The numbers in the rows that are held.
    pub at: Vec<f64>,
}

/// Reduces a value.
pub fn reduce(value: &dyn Value, digest: &Digest) -> Reduced {
    let tables = value.tables().iter().map(|table| (table.what.to_owned(), reduced(table))).collect();
    Reduced { digest: digest.hex(), summary: value.summary(), tables }
}

fn reduced(table: &Table<'_>) -> ReducedTable {
    let rows = table.rows.count();
    let (held, shown) = (spread(rows, ROWS), spread(table.columns.len(), COLUMNS));
    let mut all = Sum::default();
    for row in 0..rows {
        (0..table.columns.len()).for_each(|column| all.add((table.number)(row, column)));
    }
    let column = |at: &usize| {
        let (mut sum, mut steps, mut before) = (Sum::default(), Sum::default(), f64::NAN);
        for row in 0..rows {
            let number = (table.number)(row, *at);
            sum.add(number);
            steps.add((number - before) * (number - before));
            before = number;
        }
        let Statistics { missing, low, high, mean } = sum.statistics();
        let step = rounded(steps.statistics().mean.max(0.0).sqrt());
        let at_rows = held.iter().map(|row| rounded((table.number)(*row, *at))).collect();
        (table.columns[*at].clone(), Column { missing, low, high, mean, step, at: at_rows })
    };
    ReducedTable {
        unit: table.unit.to_owned(),
        rows: described(&table.rows),
        width: table.columns.len(),
        all: all.statistics(),
        held: held.iter().map(|row| table.rows.name(*row)).collect(),
        columns: shown.iter().map(column).collect(),
    }
}

fn described(rows: &Rows) -> String {
    match rows {
        Rows::Frames(axis) => format!("{} frames from {} at {} Hz", axis.count, axis.first, axis.rate_hz),
        Rows::Named(what, names) => format!("{} of the kind {what}", names.len()),
        Rows::Counted(what, count) => format!("{count} of the kind {what}"),
    }
}

/// At most `most` positions among `count`, the first and the last included.
fn spread(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|index| index * (count - 1) / (most - 1)).collect()
}

/// The number with seven digits that count: more than a snapshot compares, few enough to be read.
fn rounded(number: f64) -> f64 {
    if !number.is_finite() {
        return number;
    }
    format!("{number:.6e}").parse().unwrap_or(number)
}

/// A running sum, in the order in which numbers come.
struct Sum {
    missing: usize,
    count: usize,
    low: f64,
    high: f64,
    total: f64,
}

impl Default for Sum {
    fn default() -> Self {
        Self { missing: 0, count: 0, low: f64::INFINITY, high: f64::NEG_INFINITY, total: 0.0 }
    }
}

impl Sum {
    fn add(&mut self, number: f64) {
        if number.is_nan() {
            self.missing += 1;
            return;
        }
        self.count += 1;
        self.low = self.low.min(number);
        self.high = self.high.max(number);
        self.total += number;
    }

    /// Where no number is there, all are 0, and `missing` says so.
    fn statistics(&self) -> Statistics {
        if self.count == 0 {
            return Statistics { missing: self.missing, low: 0.0, high: 0.0, mean: 0.0 };
        }
        let mean = rounded(self.total / self.count as f64);
        Statistics { missing: self.missing, low: rounded(self.low), high: rounded(self.high), mean }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_spread_from_the_first_to_the_last() {
        assert_eq!(spread(3, 24), [0, 1, 2]);
        let many = spread(600, 24);
        assert_eq!((many.len(), many[0], many[23]), (24, 0, 599));
    }

    #[test]
    fn numbers_keep_seven_digits() {
        let told = [0.123_456_789, -12_345_678.9, 0.0, 1.0].map(|number| rounded(number).to_string());
        assert_eq!(told, ["0.1234568", "-12345680", "0", "1"]);
    }

    #[test]
    fn missing_numbers_are_counted_and_left_out() {
        let mut sum = Sum::default();
        for number in [1.0, f64::NAN, 3.0] {
            sum.add(number);
        }
        assert_eq!(sum.statistics(), Statistics { missing: 1, low: 1.0, high: 3.0, mean: 2.0 });
    }
}
