//! Markers as tables: a neutral face (`marker,x_mm,y_mm,z_mm`, one row a marker), or a take (`frame`, then three columns a
//! marker, `chin_x_mm,chin_y_mm,chin_z_mm`, one row a frame).
//!
//! The unit stands at the end of each column's name. Three empty cells are a missing point.

use crate::csv::{CsvError, Row, Table, column_error, push_cell, text};
use crate::markers::{Format, MarkerFile};
use crate::units::LengthUnit;
use crate::{ReadError, WriteError};
use face_math::data::Markers;
use glam::Vec3;
use std::fmt::Write;

const FORMAT: &str = "marker CSV";
const AXES: [&str; 3] = ["x", "y", "z"];

/// Reads a table of markers of either layout. `rate_hz` is used where the file states no rate.
///
/// # Errors
/// See [`CsvError`]: each names line and column.
pub fn read(bytes: &[u8], rate_hz: Option<f64>) -> Result<Markers, ReadError> {
    open(bytes)?.into_markers(rate_hz)
}

/// Reads a table of markers of either layout, with what the file says beside the positions.
///
/// # Errors
/// See [`CsvError`].
pub fn open(bytes: &[u8]) -> Result<MarkerFile, ReadError> {
    Ok(from_table(Table::read(text(bytes)?)?)?)
}

/// Whether the names of a table's columns are those of a table of markers.
pub(crate) fn detect(names: &[&str]) -> bool {
    let is = |column: usize, name: &str| names[column].eq_ignore_ascii_case(name);
    names.len() > 3 && (is(0, "marker") || is(0, "frame") && column_name(names[1]).is_some())
}

fn from_table(table: Table<'_>) -> Result<MarkerFile, CsvError> {
    let table = table.with_rows()?;
    if table.name(0).eq_ignore_ascii_case("marker") {
        return read_neutral(&table);
    }
    if table.name(0).eq_ignore_ascii_case("frame") {
        return read_take(&table);
    }
    let problem = "the first column must be `marker` (a neutral face) or `frame` (a take)";
    Err(column_error(&table.names, &table.names.cells[0], problem))
}

/// Marker (empty in the neutral layout), axis and unit that a column's name states: `chin_x_mm`.
fn column_name(name: &str) -> Option<(&str, usize, LengthUnit)> {
    let (rest, unit) = name.rsplit_once('_')?;
    let unit = LengthUnit::from_text(unit)?;
    let (marker, axis) = rest.rsplit_once('_').unwrap_or(("", rest));
    let axis = AXES.iter().position(|own| axis.eq_ignore_ascii_case(own))?;
    Some((marker, axis, unit))
}

/// Checks that three columns from `first` on are x, y and z of one marker in one unit.
fn triple<'a>(table: &'a Table<'_>, first: usize, unit: Option<LengthUnit>) -> Result<(&'a str, LengthUnit), CsvError> {
    let mut head: Option<(&str, LengthUnit)> = None;
    for (axis, wanted) in AXES.iter().enumerate() {
        let Some(cell) = table.names.cells.get(first + axis) else {
            let cell = &table.names.cells[table.names.cells.len() - 1];
            return Err(column_error(&table.names, cell, "a marker must have three columns, x, y and z"));
        };
        let wrong = |problem: String| column_error(&table.names, cell, problem);
        let (marker, found, own) = column_name(&cell.text).ok_or_else(|| {
            wrong(format!("it must end in _{wanted} and a unit, such as `chin_{wanted}_mm` ({})", LengthUnit::KNOWN))
        })?;
        let unit = *unit.as_ref().or(head.as_ref().map(|(_, unit)| unit)).unwrap_or(&own);
        if own != unit {
            return Err(wrong(format!("its unit is {own}, that of the columns before {unit}; all must agree")));
        }
        let name = head.map_or(marker, |(name, _)| name);
        if found != axis || marker != name {
            return Err(wrong(format!("expected {wanted} of marker `{name}`: x, y and z of a marker stand together")));
        }
        head = Some((name, unit));
    }
    let first = &table.names.cells[first];
    head.ok_or_else(|| column_error(&table.names, first, "no marker"))
}

/// The position in three cells, missing where all are empty.
fn position(table: &Table<'_>, row: &Row<'_>, first: usize, unit: LengthUnit) -> Result<Vec3, CsvError> {
    let empty = |axis: usize| row.cells[first + axis].text.is_empty();
    if (0..3).all(empty) {
        return Ok(Vec3::NAN);
    }
    if let Some(axis) = (0..3).find(|axis| empty(*axis)) {
        return Err(table.cell_error(row, first + axis, "a number, though others of its point are; empty all three"));
    }
    let mut point = Vec3::ZERO;
    for axis in 0..3 {
        point[axis] = unit.to_metres(f64::from(table.number(row, first + axis)?));
    }
    if point.is_finite() { Ok(point) } else { Err(table.cell_error(row, first, "a position of finite size")) }
}

fn read_neutral(table: &Table<'_>) -> Result<MarkerFile, CsvError> {
    if table.names.cells.len() != 4 {
        let cell = &table.names.cells[table.names.cells.len() - 1];
        return Err(column_error(&table.names, cell, "a neutral face has the columns marker, x, y and z"));
    }
    let (_, unit) = triple(table, 1, None)?;
    let mut names: Vec<String> = Vec::with_capacity(table.rows.len());
    let mut seen = std::collections::BTreeSet::new();
    let mut positions = Vec::with_capacity(table.rows.len());
    for row in &table.rows {
        let name = row.cells[0].text.as_ref();
        if name.is_empty() || !seen.insert(name) {
            return Err(table.cell_error(row, 0, "a name that stands once"));
        }
        names.push(name.to_owned());
        positions.push(position(table, row, 1, unit)?);
    }
    let rate_hz = table.rate_hz()?;
    Ok(file(Format::Neutral, names, (0, 1, rate_hz), positions, unit))
}

fn read_take(table: &Table<'_>) -> Result<MarkerFile, CsvError> {
    let first_frame = table.frames(0)?;
    let mut names = Vec::new();
    let mut unit = None;
    let mut column = 1;
    while column < table.names.cells.len() {
        let (name, own) = triple(table, column, unit)?;
        unit = Some(own);
        if name.is_empty() {
            return Err(column_error(&table.names, &table.names.cells[column], "it names no marker"));
        }
        names.push(name.to_owned());
        column += 3;
    }
    let Some(unit) = unit else {
        return Err(column_error(&table.names, &table.names.cells[0], "no marker's columns follow it"));
    };
    let mut positions = Vec::with_capacity(table.rows.len() * names.len());
    for row in &table.rows {
        for marker in 0..names.len() {
            positions.push(position(table, row, 1 + 3 * marker, unit)?);
        }
    }
    let (rate_hz, frames) = (table.rate_hz()?, table.rows.len());
    Ok(file(Format::Table, names, (first_frame, frames, rate_hz), positions, unit))
}

fn file(
    format: Format,
    names: Vec<String>,
    (first_frame, frames, rate_hz): (i64, usize, Option<f64>),
    positions: Vec<Vec3>,
    unit: LengthUnit,
) -> MarkerFile {
    let (renamed, left_out) = (Vec::new(), Vec::new());
    MarkerFile { format, names, first_frame, frames, rate_hz, positions, unit, unit_assumed: false, renamed, left_out }
}

/// Writes a take as a table, one row a frame, coordinates in `unit`, missing points as empty cells. The first line is
/// the comment `# rate_hz: …`.
///
/// # Errors
/// Where a name is empty.
pub fn write(markers: &Markers, unit: LengthUnit) -> Result<Vec<u8>, WriteError> {
    let axis = markers.frame_axis();
    let mut out = format!("# rate_hz: {}\nframe", axis.rate_hz);
    for name in checked_names(markers)? {
        for axis in AXES {
            out.push(',');
            push_cell(&mut out, &format!("{name}_{axis}_{unit}"));
        }
    }
    out.push('\n');
    for frame in 0..markers.frames() {
        let _ = write!(out, "{}", axis.first + frame.cast_signed() as i64);
        for point in markers.frame(frame) {
            push_point(&mut out, *point, unit);
        }
        out.push('\n');
    }
    Ok(out.into_bytes())
}

/// Writes one frame as a neutral face, one row a marker, coordinates in `unit`, missing points as empty cells.
///
/// # Errors
/// Where a name is empty, or there is not exactly one frame.
pub fn write_neutral(markers: &Markers, unit: LengthUnit) -> Result<Vec<u8>, WriteError> {
    if markers.frames() != 1 {
        return Err(WriteError::Fit { format: FORMAT, what: "frames", expected: 1, found: markers.frames() });
    }
    let mut out = format!("marker,x_{unit},y_{unit},z_{unit}\n");
    for (name, point) in checked_names(markers)?.iter().zip(markers.frame(0)) {
        push_cell(&mut out, name);
        push_point(&mut out, *point, unit);
        out.push('\n');
    }
    Ok(out.into_bytes())
}

fn checked_names(markers: &Markers) -> Result<&[String], WriteError> {
    match markers.names().iter().find(|name| name.is_empty()) {
        Some(name) => Err(WriteError::Name { format: FORMAT, name: name.clone(), problem: "is empty" }),
        None => Ok(markers.names()),
    }
}

fn push_point(out: &mut String, point: Vec3, unit: LengthUnit) {
    for coordinate in point.to_array() {
        out.push(',');
        if !point.is_nan() {
            let _ = write!(out, "{}", unit.from_metres(coordinate));
        }
    }
}
