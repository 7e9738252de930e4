//! The plain table of curves: `frame` first, then one column a channel.

use super::CurveTable;
use crate::WriteError;
use crate::csv::{CsvError, Table, column_error, push_cell};
use face_math::data::Curves;
use std::fmt::Write;

const FORMAT: &str = "curve CSV";

pub(super) fn detect(table: &Table<'_>) -> bool {
    table.names.cells.len() > 1 && table.name(0).eq_ignore_ascii_case("frame")
}

pub(super) fn read(table: &Table<'_>) -> Result<CurveTable, CsvError> {
    if !detect(table) {
        let first = &table.names.cells[0];
        let problem = "the first column must be `frame`, with a channel in each further one (or `Timecode`, then \
                       `BlendshapeCount`, in a recording of Live Link Face)";
        return Err(column_error(&table.names, first, problem));
    }
    let first_frame = table.frames(0)?;
    let channels: Vec<String> = table.names.cells[1..].iter().map(|cell| cell.text.to_string()).collect();
    let mut values = Vec::with_capacity(table.rows.len() * channels.len());
    for row in &table.rows {
        for column in 1..row.cells.len() {
            values.push(table.number(row, column)?);
        }
    }
    let rate_hz = table.rate_hz()?;
    Ok(CurveTable { channels, first_frame, frames: table.rows.len(), rate_hz, values, live_link: None })
}

/// Writes curves as a table: shortest numbers that read back the same, lines that end in LF.
///
/// With `state_rate`, the first line is the comment `# rate_hz: …`. Tools that know no comments want it left out; the
/// rate must then be told to whoever reads the file.
///
/// # Errors
/// Where a value is not finite, or a name is empty or `frame`.
pub fn write(curves: &Curves, state_rate: bool) -> Result<Vec<u8>, WriteError> {
    let axis = curves.frame_axis();
    let mut out = String::with_capacity(curves.values().len() * 10 + 200);
    if state_rate {
        let _ = writeln!(out, "# rate_hz: {}", axis.rate_hz);
    }
    out.push_str("frame");
    for name in curves.channels() {
        if name.is_empty() || name.eq_ignore_ascii_case("frame") {
            let problem = "is empty, or the name of the first column";
            return Err(WriteError::Name { format: FORMAT, name: name.clone(), problem });
        }
        out.push(',');
        push_cell(&mut out, name);
    }
    out.push('\n');
    for position in 0..curves.frames() {
        let frame = axis.first + position.cast_signed() as i64;
        let _ = write!(out, "{frame}");
        for (value, name) in curves.frame(position).iter().zip(curves.channels()) {
            if !value.is_finite() {
                let what = format!("channel `{name}`");
                return Err(WriteError::NotFinite { format: FORMAT, what, frame, value: *value });
            }
            let _ = write!(out, ",{value}");
        }
        out.push('\n');
    }
    Ok(out.into_bytes())
}
