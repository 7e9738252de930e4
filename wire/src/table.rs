//! Tables: the numbers of a value under names and with units, for whoever compares or draws values whose types it does not know.

use crate::FrameAxis;

/// How far two numbers may lie apart and still count as the same: |a − b| ≤ absolute + relative · |a|.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// In the unit of the numbers.
    pub absolute: f64,
    /// As a share of the expected number.
    pub relative: f64,
}

impl Tolerance {
    /// A tolerance in the unit of the numbers.
    pub const fn absolute(absolute: f64) -> Self {
        Self { absolute, relative: 0.0 }
    }

    /// A tolerance as a share of the expected number.
    pub const fn relative(relative: f64) -> Self {
        Self { absolute: 0.0, relative }
    }

    /// How far a number may be from `expected`, in its unit.
    pub fn at(&self, expected: f64) -> f64 {
        self.absolute + self.relative * expected.abs()
    }
}

/// What the rows of a table are.
#[derive(Debug, Clone, PartialEq)]
pub enum Rows {
    /// Frames.
    Frames(FrameAxis),
    /// Things with names, and what such a thing is: a marker, a shape.
    Named(&'static str, Vec<String>),
    /// Things that are counted from 0, and what such a thing is: a vertex, a row of pixels.
    Counted(&'static str, usize),
}

impl Rows {
    /// How many rows there are.
    pub fn count(&self) -> usize {
        match self {
            Self::Frames(axis) => axis.count,
            Self::Named(_, names) => names.len(),
            Self::Counted(_, count) => *count,
        }
    }

    /// What people call the row at `position`: `frame 1001`, `marker chin`, `vertex 17`.
    pub fn name(&self, position: usize) -> String {
        match self {
            Self::Frames(axis) => format!("frame {}", axis.slice(&(position..position + 1)).first),
            Self::Named(what, names) => format!("{what} {}", names.get(position).map_or("?", String::as_str)),
            Self::Counted(what, _) => format!("{what} {position}"),
        }
    }
}

/// Numbers of a value that have one unit: rows by columns.
pub struct Table<'a> {
    /// What the numbers are: `positions`, `weights`. No two tables of a value have the same name.
    pub what: &'static str,
    /// Their unit, such as `mm`; empty where they have none.
    pub unit: &'static str,
    /// How far two machines may differ in them.
    pub tolerance: Tolerance,
    /// What the rows are.
    pub rows: Rows,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The number in a row and a column; NaN where there is none.
    pub number: Box<dyn Fn(usize, usize) -> f64 + 'a>,
}

impl std::fmt::Debug for Table<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}): {} x {}", self.what, self.unit, self.rows.count(), self.columns.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_called_as_people_count_them() {
        let frames = Rows::Frames(FrameAxis { first: 1001, count: 3, rate_hz: 24.0 });
        assert_eq!((frames.name(2).as_str(), frames.count()), ("frame 1003", 3));
        assert_eq!(Rows::Named("marker", vec!["chin".into()]).name(0), "marker chin");
        assert_eq!(Rows::Counted("vertex", 9).name(8), "vertex 8");
    }

    #[test]
    fn tolerances_add() {
        let tolerance = Tolerance { absolute: 0.5, relative: 0.1 };
        assert_eq!(
            (tolerance.at(-10.0), Tolerance::absolute(0.5).at(99.0), Tolerance::relative(0.5).at(4.0)),
            (1.5, 0.5, 2.0)
        );
    }
}
