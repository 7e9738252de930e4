//! The rows of frames in tables of capture systems: a frame number, and three cells a marker.

use crate::csv::{CsvError, Grid, GridRow};
use crate::units::LengthUnit;
use glam::Vec3;

/// How many points a table may hold for each byte of it. A point whose cells are all there takes three bytes or more;
/// rows that end before their last markers may hold fewer, but not without bounds.
pub(super) const POINTS_A_BYTE: usize = 16;

/// Where the coordinates of the markers stand in each row.
pub(super) struct Columns {
    /// The column of x of each marker; y and z follow it.
    pub first: Vec<usize>,
    /// What the markers are called, for messages.
    pub names: Vec<String>,
    /// The unit of the coordinates.
    pub unit: LengthUnit,
    /// The column of the number within a frame, which must be 0, where there is one.
    pub sub_frame: Option<usize>,
    /// How many cells a row has that is not cut.
    pub width: usize,
}

/// What a header says about how many frames there are.
#[derive(Clone, Copy)]
pub(super) struct Announced {
    pub frames: u64,
    /// The line that says so.
    pub line: usize,
}

/// The frames of a table.
pub(super) struct Frames {
    pub first: i64,
    pub count: usize,
    /// Metres, frame after frame; missing points NaN.
    pub positions: Vec<Vec3>,
}

/// Reads rows up to a blank one, or up to the end of the text.
///
/// `bytes` is the length of the text. Three cells that are empty, or hold `NaN`, are a missing point. Rows may end
/// before their last markers, which are missing then.
pub(super) fn read(
    grid: &mut Grid<'_>,
    columns: &Columns,
    announced: Option<Announced>,
    bytes: usize,
) -> Result<Frames, CsvError> {
    let mut frames = Frames { first: 0, count: 0, positions: Vec::new() };
    let mut last = grid.line();
    let mut before: Option<i64> = None;
    while let Some(row) = grid.next_row()? {
        if row.is_blank() {
            break;
        }
        last = row.line();
        let frame = frame_number(&row, before)?;
        before = Some(frame);
        if frames.count == 0 {
            frames.first = frame;
        }
        if let Some(column) = columns.sub_frame
            && !matches!(row.text(column).parse::<f64>(), Ok(0.0))
        {
            return Err(row.cell_error(column, "Sub Frame", "0; each row must be one frame"));
        }
        if !row.ended && row.width() < columns.width {
            return Err(CsvError::Cut { line: row.line(), expected: columns.width, found: row.width() });
        }
        frames.count += 1;
        if frames.count.saturating_mul(columns.first.len()) > bytes.saturating_mul(POINTS_A_BYTE) {
            return Err(CsvError::Sparse { line: row.line(), markers: columns.first.len() });
        }
        for (first, name) in columns.first.iter().zip(&columns.names) {
            frames.positions.push(position(&row, *first, name, columns.unit)?);
        }
    }
    if frames.count == 0 {
        return Err(CsvError::NoRows { line: last.saturating_sub(1).max(1) });
    }
    match announced {
        Some(announced) if announced.frames > frames.count as u64 => Err(CsvError::Fewer {
            line: last,
            found: frames.count,
            expected: announced.frames,
            said_in: announced.line,
        }),
        _ => Ok(frames),
    }
}

fn frame_number(row: &GridRow<'_>, before: Option<i64>) -> Result<i64, CsvError> {
    let found: i64 = row.text(0).parse().map_err(|_| row.cell_error(0, "Frame", "a whole frame number"))?;
    match before {
        Some(before) if before.checked_add(1) != Some(found) => {
            Err(CsvError::Frame { line: row.line(), column: row.column(0), before, found })
        }
        _ => Ok(found),
    }
}

/// The position in three cells, missing where all are empty or `NaN`.
fn position(row: &GridRow<'_>, first: usize, name: &str, unit: LengthUnit) -> Result<Vec3, CsvError> {
    let absent = |axis: usize| {
        let text = row.text(first + axis);
        text.is_empty() || text.eq_ignore_ascii_case("nan")
    };
    if absent(0) && absent(1) && absent(2) {
        return Ok(Vec3::NAN);
    }
    let mut point = Vec3::ZERO;
    for axis in 0..3 {
        let wanted =
            if absent(axis) { "a number, though others of its point are; empty all three" } else { "a finite number" };
        // 32 bits, as markers have them: what was written from them reads back bit for bit.
        let metres = row.text(first + axis).parse::<f32>().map(|number| unit.to_metres(f64::from(number)));
        point[axis] = match metres {
            Ok(metres) if metres.is_finite() => metres,
            _ => return Err(row.cell_error(first + axis, name, wanted)),
        };
    }
    Ok(point)
}

/// The frames a second that a cell states.
pub(super) fn rate(row: &GridRow<'_>, index: usize, name: &str) -> Result<f64, CsvError> {
    match row.text(index).parse::<f64>() {
        Ok(rate) if rate.is_finite() && rate > 0.0 => Ok(rate),
        _ => Err(row.cell_error(index, name, "a number of frames a second above 0")),
    }
}

/// The count that a cell states.
pub(super) fn count(row: &GridRow<'_>, index: usize, name: &str) -> Result<u64, CsvError> {
    row.text(index).parse().map_err(|_| row.cell_error(index, name, "a count"))
}

/// The unit of length that a cell states.
pub(super) fn unit(row: &GridRow<'_>, index: usize) -> Result<LengthUnit, CsvError> {
    LengthUnit::from_text(row.text(index)).ok_or_else(|| {
        let problem = format!("`{}` is no unit of length known here ({})", row.text(index), LengthUnit::KNOWN);
        row.wrong(index, problem)
    })
}
