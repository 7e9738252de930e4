//! TRC: the tab-separated tables of markers that Motion Analysis invented, and `OpenSim` and others write.
//!
//! Five lines of header (`PathFileType`, keys, their values, names, axes), as a rule a blank one, and a row a frame:
//! number, time, and three cells a marker. Source for what real files do beyond it: the files themselves. Trajectories
//! that the header gives no name, which such systems append as they come and go, belong to no marker and are left out.

use super::frames::{self, Announced, Columns};
use super::names::unique;
use super::{Format, MarkerFile};
use crate::csv::{CsvError, Grid, GridRow, text};
use crate::units::LengthUnit;
use crate::{ReadError, WriteError};
use face_math::data::Markers;
use std::fmt::Write;

const FORMAT: &str = "TRC";
const AXES: [&str; 3] = ["X", "Y", "Z"];

/// Whether text begins as a TRC file does.
pub(crate) fn detect(text: &str) -> bool {
    text.trim_start().get(..12).is_some_and(|start| start.eq_ignore_ascii_case("PathFileType"))
}

/// Reads a TRC file.
///
/// # Errors
/// See [`CsvError`]: each names the line, and the column where one cell is at fault.
pub fn open(bytes: &[u8]) -> Result<MarkerFile, ReadError> {
    parse(bytes).map_err(ReadError::Trc)
}

/// What the second and third line say.
struct Facts {
    rate_hz: f64,
    unit: LengthUnit,
    announced: Option<Announced>,
}

fn parse(bytes: &[u8]) -> Result<MarkerFile, CsvError> {
    let text = text(bytes)?;
    if text.trim().is_empty() {
        return Err(CsvError::NoBytes);
    }
    let mut grid = Grid::new(text, '\t');
    let first = header_row(&mut grid, "`PathFileType`")?;
    if !first.text(0).eq_ignore_ascii_case("PathFileType") {
        return Err(first.wrong(0, "a TRC file begins with `PathFileType`"));
    }
    let keys = header_row(&mut grid, "the keys `DataRate`, `Units` …")?;
    let values = header_row(&mut grid, "the values of the keys")?;
    let facts = facts(&keys, &values)?;
    let names = header_row(&mut grid, "the names of the markers")?;
    if !names.text(0).to_lowercase().starts_with("frame") {
        return Err(names.wrong(0, "the line of names begins with `Frame#`, `Time` and the first marker"));
    }
    let (labels, columns) = labels(&names)?;
    let mut after = grid.clone();
    let axes = match after.next_full_row()? {
        Some(row) if row.text(0).is_empty() => {
            check_axes(&row, &columns)?;
            grid = after;
            Some(row)
        }
        _ => None,
    };
    // As a rule a blank line follows.
    let mut after = grid.clone();
    while after.next_row()?.is_some_and(|row| row.is_blank()) {
        grid = after.clone();
    }
    let width = columns.last().map_or(2, |last| last + 3);
    let stated = axes.map_or(width, |row| row.width().max(width));
    let (names, renamed) = unique(labels);
    let columns = Columns { first: columns, names, unit: facts.unit, sub_frame: None, width };
    let widest = widest(&grid)?.max(stated);
    let frames = frames::read(&mut grid, &columns, facts.announced, text.len())?;
    if let Some(row) = grid.next_full_row()? {
        return Err(CsvError::Blank { line: row.line() - 1 });
    }
    let unnamed = (widest - width) / 3;
    let left_out = if unnamed > 0 { vec![format!("{unnamed} unnamed trajectories")] } else { Vec::new() };
    Ok(MarkerFile {
        format: Format::Trc,
        names: columns.names,
        first_frame: frames.first,
        frames: frames.count,
        rate_hz: Some(facts.rate_hz),
        positions: frames.positions,
        unit: facts.unit,
        unit_assumed: false,
        renamed,
        left_out,
    })
}

fn header_row<'a>(grid: &mut Grid<'a>, wanted: &str) -> Result<GridRow<'a>, CsvError> {
    let line = grid.line();
    grid.next_full_row()?.ok_or_else(|| CsvError::Header {
        line,
        column: 1,
        problem: format!("the file ends where {wanted} must stand; it was cut short, export it again"),
    })
}

fn facts(keys: &GridRow<'_>, values: &GridRow<'_>) -> Result<Facts, CsvError> {
    let column = |key: &str| (0..keys.width()).find(|index| keys.text(*index).eq_ignore_ascii_case(key));
    let needed = |key: &str| {
        column(key).ok_or_else(|| keys.wrong(0, format!("the key `{key}` is absent; a TRC file states it here")))
    };
    let announced = match column("NumFrames") {
        Some(index) => Some(Announced { frames: frames::count(values, index, "NumFrames")?, line: values.line() }),
        None => None,
    };
    Ok(Facts {
        rate_hz: frames::rate(values, needed("DataRate")?, "DataRate")?,
        unit: frames::unit(values, needed("Units")?)?,
        announced,
    })
}

/// The markers' names, and the column of each one's x.
///
/// A name stands over x and is followed by two empty cells; some writers leave those out.
fn labels(row: &GridRow<'_>) -> Result<(Vec<String>, Vec<usize>), CsvError> {
    let named: Vec<usize> = (2..row.width()).filter(|index| !row.text(*index).is_empty()).collect();
    let labels = named.iter().map(|index| row.text(*index).to_owned()).collect();
    let Some(last) = named.last() else {
        return Err(row.wrong(1, "no marker's name follows `Time`"));
    };
    let dense = named.len() > 1 && *last == named.len() + 1;
    if dense {
        return Ok((labels, (0..named.len()).map(|index| 2 + 3 * index).collect()));
    }
    match named.iter().find(|index| (**index - 2) % 3 != 0) {
        Some(odd) => {
            let problem = format!("the name `{}` stands over no marker's x; each takes three columns", row.text(*odd));
            Err(row.wrong(*odd, problem))
        }
        None => Ok((labels, named)),
    }
}

/// Checks that x, y and z stand in this order under each name, as far as the line goes.
fn check_axes(row: &GridRow<'_>, columns: &[usize]) -> Result<(), CsvError> {
    for first in columns {
        for (axis, wanted) in AXES.iter().enumerate() {
            let found = row.text(first + axis);
            if !found.is_empty() && !found.to_uppercase().starts_with(wanted) {
                let problem = format!("`{found}` stands where {wanted} of a marker must; export it in the order X Y Z");
                return Err(row.wrong(first + axis, problem));
            }
        }
    }
    Ok(())
}

/// The most cells that hold something up to their end, of all rows.
fn widest(grid: &Grid<'_>) -> Result<usize, CsvError> {
    let mut grid = grid.clone();
    let mut widest = 0;
    while let Some(row) = grid.next_row()? {
        let full = (0..row.width()).rev().find(|index| !row.text(*index).is_empty());
        widest = widest.max(full.map_or(0, |last| last + 1));
    }
    Ok(widest)
}

/// Writes markers as TRC with coordinates in `unit`; missing points are empty cells.
///
/// Markers that were read from a file in the same unit (or any, written in metres) read back bit for bit.
///
/// # Errors
/// Where a name is empty, begins or ends with a blank, or holds a tab or a line end, or there are no markers or frames.
pub fn write(markers: &Markers, unit: LengthUnit) -> Result<Vec<u8>, WriteError> {
    for name in markers.names() {
        let wrong = |problem| Err(WriteError::Name { format: FORMAT, name: name.clone(), problem });
        if name.is_empty() || name.trim() != name {
            return wrong("is empty, or begins or ends with a blank");
        }
        if name.contains(['\t', '\n', '\r', '"']) {
            return wrong("holds a tab, a line end or a quote");
        }
    }
    for (what, count) in [("markers", markers.names().len()), ("frames", markers.frames())] {
        if count == 0 {
            return Err(WriteError::Range { format: FORMAT, what: what.into(), value: 0.0, low: 1.0, high: f64::MAX });
        }
    }
    let axis = markers.frame_axis();
    let (rate, count, first) = (axis.rate_hz, markers.frames(), axis.first);
    let mut out = String::from("PathFileType\t4\t(X/Y/Z)\tmarkers.trc\n");
    out += "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n";
    let names = markers.names().len();
    let _ = writeln!(out, "{rate}\t{rate}\t{count}\t{names}\t{unit}\t{rate}\t{first}\t{count}");
    out += "Frame#\tTime";
    for name in markers.names() {
        let _ = write!(out, "\t{name}\t\t");
    }
    out += "\n\t";
    for number in 1..=names {
        let _ = write!(out, "\tX{number}\tY{number}\tZ{number}");
    }
    out += "\n\n";
    for frame in 0..count {
        let _ = write!(out, "{}\t{:.6}", first + frame.cast_signed() as i64, frame as f64 / rate);
        for point in markers.frame(frame) {
            for coordinate in point.to_array() {
                out.push('\t');
                if !point.is_nan() {
                    let _ = write!(out, "{}", unit.from_metres(coordinate));
                }
            }
        }
        out.push('\n');
    }
    Ok(out.into_bytes())
}
