//! Takes as Vicon's Nexus and its forebears export them (ASCII, as CSV or with tabs).
//!
//! The file is sections, parted by blank lines: `Devices`, `Joints`, `Model Outputs`, `Trajectories` …, in any order.
//! Each begins with its title and its rate; names, axes and units of the columns follow, then rows. Only the
//! trajectories are markers; velocities and accelerations (`X'`, `X''`) beside them are not. Source: the files
//! themselves.

use super::frames::{self, Columns};
use super::names::unique;
use super::{Format, MarkerFile};
use crate::ReadError;
use crate::csv::{CsvError, Grid, GridRow, full_lines, text};
use crate::units::LengthUnit;

const TRAJECTORIES: &str = "trajectories";

/// Titles of sections, in small letters.
const TITLES: [&str; 9] = [
    TRAJECTORIES,
    "devices",
    "joints",
    "model outputs",
    "model output",
    "segments",
    "events",
    "analog",
    "force plates",
];

/// Whether text begins with a section of such an export.
pub(crate) fn detect(text: &str) -> bool {
    let bare = |line: &str| line.trim_matches([',', ';', '\t', ' ', '"']).to_lowercase();
    full_lines(text).map(bare).find(|line| !line.is_empty()).is_some_and(|line| TITLES.contains(&line.as_str()))
}

/// The title of the section that begins in this row.
fn title(row: &GridRow<'_>) -> Option<String> {
    let title = row.text(0).to_lowercase();
    let alone = (1..row.width()).all(|index| row.text(index).is_empty());
    (alone && TITLES.contains(&title.as_str())).then_some(title)
}

/// Reads the trajectories of an export.
///
/// # Errors
/// See [`CsvError`]: each names the line, and the column where one cell is at fault.
pub fn open(bytes: &[u8]) -> Result<MarkerFile, ReadError> {
    Ok(parse(bytes)?)
}

fn parse(bytes: &[u8]) -> Result<MarkerFile, CsvError> {
    let text = text(bytes)?;
    let mut grid = Grid::guess(text);
    let mut others: Vec<String> = Vec::new();
    loop {
        let Some(row) = grid.next_full_row()? else {
            return Err(CsvError::NoMarkers {
                holds: format!("the sections {}", others.join(", ")),
                cure: "export it from Nexus again with `Trajectories` switched on",
            });
        };
        match title(&row) {
            Some(title) if title == TRAJECTORIES => break,
            Some(_) => others.push(format!("`{}`", row.text(0))),
            None => {}
        }
    }
    let mut file = section(&mut grid, text.len())?;
    while let Some(row) = grid.next_full_row()? {
        match title(&row) {
            Some(title) if title == TRAJECTORIES => {
                let problem = "a second section `Trajectories`; cut the file into one for each";
                return Err(row.wrong(0, problem));
            }
            Some(_) => others.push(format!("`{}`", row.text(0))),
            None => {}
        }
    }
    file.left_out.extend((!others.is_empty()).then(|| format!("the sections {}", others.join(", "))));
    Ok(file)
}

fn row<'a>(grid: &mut Grid<'a>, wanted: &str) -> Result<GridRow<'a>, CsvError> {
    let line = grid.line();
    match grid.next_row()? {
        Some(row) if !row.is_blank() => Ok(row),
        _ => Err(CsvError::Header {
            line,
            column: 1,
            problem: format!("{wanted} must stand here; the file was cut short or damaged, export it again"),
        }),
    }
}

fn section(grid: &mut Grid<'_>, bytes: usize) -> Result<MarkerFile, CsvError> {
    let rate = row(grid, "the rate of the trajectories")?;
    let number = rate.text(0).trim_end_matches(|c: char| c.is_alphabetic() || c.is_whitespace());
    let rate_hz = match number.parse::<f64>() {
        Ok(rate) if rate.is_finite() && rate > 0.0 => rate,
        _ => return Err(rate.cell_error(0, "rate", "a number of frames a second above 0")),
    };
    let names = row(grid, "the names of the markers")?;
    let axes = row(grid, "the line `Frame`, `Sub Frame`, `X`, `Y`, `Z` …")?;
    let head = axes.text(0).to_lowercase();
    if !(head.starts_with("frame") || head.starts_with("field")) {
        return Err(axes.wrong(0, "the line of axes begins with `Frame`"));
    }
    let sub_frame = axes.text(1).to_lowercase().starts_with("sub").then_some(1);
    let mut after = grid.clone();
    let units = after.next_row()?.filter(|row| row.text(0).is_empty() && !row.is_blank());
    if units.is_some() {
        *grid = after;
    }
    let (labels, first, skipped) = columns(&names, &axes)?;
    let unit = match &units {
        Some(units) => Some(common_unit(units, &first)?),
        None => None,
    };
    let (names, renamed) = unique(labels);
    let own_unit = unit.unwrap_or(LengthUnit::Millimetre);
    let columns = Columns { first, names, unit: own_unit, sub_frame, width: axes.width() };
    let frames = frames::read(grid, &columns, None, bytes)?;
    Ok(MarkerFile {
        format: Format::Vicon,
        names: columns.names,
        first_frame: frames.first,
        frames: frames.count,
        rate_hz: Some(rate_hz),
        positions: frames.positions,
        unit: own_unit,
        unit_assumed: unit.is_none(),
        renamed,
        left_out: (skipped > 0).then(|| format!("{skipped} columns of velocities and the like")).into_iter().collect(),
    })
}

/// Name and column of x of each marker, and how many columns hold no position.
fn columns(names: &GridRow<'_>, axes: &GridRow<'_>) -> Result<(Vec<String>, Vec<usize>, usize), CsvError> {
    let (mut labels, mut first, mut skipped) = (Vec::new(), Vec::new(), 0);
    let is = |index: usize, axis: &str| axes.text(index).eq_ignore_ascii_case(axis);
    let start = if axes.text(1).to_lowercase().starts_with("sub") { 2 } else { 1 };
    let mut column = start;
    while column < axes.width() {
        if is(column, "X") && is(column + 1, "Y") && is(column + 2, "Z") {
            labels.push(names.text(column).to_owned());
            first.push(column);
            column += 3;
        } else if ["X", "Y", "Z"].iter().any(|axis| is(column, axis)) {
            let problem = format!(
                "`{}` stands alone; x, y and z of marker `{}` stand together, in this order",
                axes.text(column),
                names.text(column)
            );
            return Err(axes.wrong(column, problem));
        } else {
            skipped += usize::from(!axes.text(column).is_empty());
            column += 1;
        }
    }
    if let Some(stray) = (start..names.width()).find(|index| !names.text(*index).is_empty() && *index >= axes.width()) {
        return Err(names.wrong(stray, format!("no columns stand below the name `{}`", names.text(stray))));
    }
    if first.is_empty() {
        return Err(axes.wrong(0, "no columns X, Y, Z of a marker follow"));
    }
    Ok((labels, first, skipped))
}

/// The unit of all coordinates.
fn common_unit(units: &GridRow<'_>, first: &[usize]) -> Result<LengthUnit, CsvError> {
    let mut common: Option<LengthUnit> = None;
    for index in first.iter().flat_map(|first| *first..first + 3) {
        let own = frames::unit(units, index)?;
        match common {
            Some(unit) if unit != own => {
                let problem = format!("its unit is {own}, that of the columns before {unit}; all must agree");
                return Err(units.wrong(index, problem));
            }
            _ => common = Some(own),
        }
    }
    common.ok_or_else(|| units.wrong(0, "no units follow"))
}
