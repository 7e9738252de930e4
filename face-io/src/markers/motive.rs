//! Takes as `OptiTrack`'s Motive exports them (CSV), of all versions of that format.
//!
//! The first line holds keys and values (`Format Version`, rates, `Length Units`). Further header lines say for each
//! column what it belongs to (`Marker`, `Rigid Body`, `Bone` …), its name, its number, since Motive 3 its parent, and
//! what it measures (`Position`, `Rotation`, an error); then rows of frames follow. Source: Motive's manual, "Data
//! Export: CSV", and the files themselves.
//!
//! Markers are what the cameras measured: the columns of kind `Marker`. Where a file has none of them, the places
//! that Motive expects of the markers of its rigid bodies and skeletons stand in. The rotations and pivots of bodies
//! and bones are no markers.

use super::frames::{self, Announced, Columns};
use super::names::unique;
use super::{Format, MarkerFile};
use crate::ReadError;
use crate::csv::{CsvError, Grid, GridRow, text};
use crate::units::LengthUnit;
use std::collections::{BTreeMap, BTreeSet};

/// No header of Motive has more lines before its frames.
const HEADER_LINES: usize = 12;

/// Whether text begins as an export of Motive does.
pub(crate) fn detect(text: &str) -> bool {
    text.trim_start_matches([' ', '"']).get(..14).is_some_and(|start| start.eq_ignore_ascii_case("Format Version"))
}

/// The lines of the header, each under what it says of the columns.
struct Header<'a> {
    facts: GridRow<'a>,
    kinds: GridRow<'a>,
    names: GridRow<'a>,
    measures: GridRow<'a>,
    axes: GridRow<'a>,
}

/// Three columns that hold the positions of one thing.
struct Position {
    kind: String,
    name: String,
    first: usize,
}

/// Kind and name of each thing that has no position.
type Others = BTreeSet<(String, String)>;

/// Reads an export of Motive.
///
/// # Errors
/// See [`CsvError`]: each names the line, and the column where one cell is at fault.
pub fn open(bytes: &[u8]) -> Result<MarkerFile, ReadError> {
    Ok(parse(bytes)?)
}

fn parse(bytes: &[u8]) -> Result<MarkerFile, CsvError> {
    let text = text(bytes)?;
    let mut grid = Grid::new(text, ',');
    let header = Header::read(&mut grid)?;
    let unit = match header.fact("Length Units") {
        Some(index) => Some(frames::unit(&header.facts, index)?),
        None => None,
    };
    let rate_hz = match header.fact("Export Frame Rate").or(header.fact("Capture Frame Rate")) {
        Some(index) => Some(frames::rate(&header.facts, index, "Export Frame Rate")?),
        None => None,
    };
    let announced = match header.fact("Total Exported Frames") {
        Some(index) => Some(Announced {
            frames: frames::count(&header.facts, index, "Total Exported Frames")?,
            line: header.facts.line(),
        }),
        None => None,
    };
    let (positions, others) = header.positions()?;
    let is_measured = |position: &Position| position.kind.eq_ignore_ascii_case("Marker");
    let expected = !positions.iter().any(is_measured);
    let is_marker = |position: &Position| {
        if expected { position.kind.to_lowercase().ends_with("marker") } else { is_measured(position) }
    };
    let (markers, rest): (Vec<_>, Vec<_>) = positions.into_iter().partition(is_marker);
    if markers.is_empty() {
        return Err(CsvError::NoMarkers {
            holds: left_out(&rest, &others, expected).join(", "),
            cure: "export it from Motive again with `Markers` switched on",
        });
    }
    let left_out = left_out(&rest, &others, expected);
    let (labels, first): (Vec<_>, Vec<_>) = markers.into_iter().map(|marker| (marker.name, marker.first)).unzip();
    let (names, renamed) = unique(labels);
    let own_unit = unit.unwrap_or(LengthUnit::Metre);
    let columns = Columns { first, names, unit: own_unit, sub_frame: None, width: header.axes.width() };
    let frames = frames::read(&mut grid, &columns, announced, text.len())?;
    Ok(MarkerFile {
        format: Format::Motive { expected },
        names: columns.names,
        first_frame: frames.first,
        frames: frames.count,
        rate_hz,
        positions: frames.positions,
        unit: own_unit,
        unit_assumed: unit.is_none(),
        renamed,
        left_out,
    })
}

impl<'a> Header<'a> {
    fn read(grid: &mut Grid<'a>) -> Result<Self, CsvError> {
        let ended = |line: usize| CsvError::Header {
            line,
            column: 1,
            problem:
                "the header ends before a line that begins with `Frame`; the file was cut short or damaged, export \
                      it again"
                    .into(),
        };
        let facts = grid.next_full_row()?.ok_or(CsvError::NoBytes)?;
        if !facts.text(0).eq_ignore_ascii_case("Format Version") {
            return Err(facts.wrong(0, "an export of Motive begins with `Format Version`"));
        }
        let mut rows: Vec<GridRow<'a>> = Vec::new();
        let axes = loop {
            let line = grid.line();
            let Some(row) = grid.next_full_row()? else { return Err(ended(line)) };
            if row.text(0).eq_ignore_ascii_case("Frame") {
                break row;
            }
            if rows.len() == HEADER_LINES || !row.text(0).is_empty() {
                return Err(ended(row.line()));
            }
            rows.push(row);
        };
        // From format 1.22 on, the second cell names the line; before that, the order does.
        let labelled = |label: &str| rows.iter().position(|row| row.text(1).eq_ignore_ascii_case(label));
        let (kinds, names) = match (labelled("Type"), labelled("Name")) {
            (Some(kinds), Some(names)) => (kinds, names),
            _ => (0, 1),
        };
        if rows.len() < 3 || kinds == names || rows.len() - 1 <= kinds.max(names) {
            let problem = "the lines with kinds, names and measures of the columns must stand before this one";
            return Err(axes.wrong(0, problem));
        }
        let measures = rows.len() - 1;
        let mut rows: BTreeMap<usize, GridRow<'a>> = rows.into_iter().enumerate().collect();
        match (rows.remove(&kinds), rows.remove(&names), rows.remove(&measures)) {
            (Some(kinds), Some(names), Some(measures)) => Ok(Self { facts, kinds, names, measures, axes }),
            _ => Err(ended(axes.line())),
        }
    }

    /// The cell with the value of a key of the first line.
    fn fact(&self, key: &str) -> Option<usize> {
        let at = (0..self.facts.width()).step_by(2).find(|index| self.facts.text(*index).eq_ignore_ascii_case(key))?;
        (!self.facts.text(at + 1).is_empty()).then_some(at + 1)
    }

    /// The columns of positions, and how many things of each other kind there are.
    fn positions(&self) -> Result<(Vec<Position>, Others), CsvError> {
        let mut positions = Vec::new();
        let mut others = Others::new();
        let mut column = 2;
        while column < self.axes.width() {
            let (kind, name) = (self.kinds.text(column), self.names.text(column));
            if !self.measures.text(column).eq_ignore_ascii_case("Position") {
                if !kind.is_empty() {
                    others.insert((kind.to_owned(), name.to_owned()));
                }
                column += 1;
                continue;
            }
            for (axis, wanted) in ["X", "Y", "Z"].iter().enumerate() {
                let at = column + axis;
                if !self.axes.text(at).eq_ignore_ascii_case(wanted) || self.names.text(at) != name {
                    let problem = format!("expected {wanted} of `{name}`: x, y and z of a marker stand together");
                    return Err(self.axes.wrong(at, problem));
                }
            }
            positions.push(Position { kind: kind.to_owned(), name: name.to_owned(), first: column });
            column += 3;
        }
        Ok((positions, others))
    }
}

/// How many things of each kind are no markers of the take.
fn left_out(rest: &[Position], others: &Others, expected: bool) -> Vec<String> {
    let mut names: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let of_rest = rest.iter().map(|position| (position.kind.as_str(), position.name.as_str()));
    let of_others = others.iter().map(|(kind, name)| (kind.as_str(), name.as_str()));
    for (kind, name) in of_rest.chain(of_others) {
        names.entry(kind).or_default().insert(name);
    }
    // Columns of quality stand beside the markers that they judge.
    names.retain(|kind, _| !(if expected { kind.to_lowercase().ends_with("marker") } else { *kind == "Marker" }));
    names.into_iter().map(|(kind, names)| format!("{} of kind `{kind}`", names.len())).collect()
}
