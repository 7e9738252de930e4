//! 2D markers as tables: one row for each view of a marker, `camera,marker,u_px,v_px`, with a column `frame` before or
//! after them where there is more than one frame.
//!
//! A row that is not there, or whose u and v are both empty, is a view that was not seen. Frames without any row between
//! the first and the last are frames in which nothing was seen.

use crate::ReadError;
use crate::csv::{CsvError, Row, Table, column_error, text};
use face_math::data::Views;
use glam::Vec2;
use std::collections::{BTreeMap, BTreeSet};
use wire::FrameAxis;

/// The columns that a table of views must have.
const COLUMNS: [&str; 4] = ["camera", "marker", "u_px", "v_px"];

/// A table of views as it stands in a file, which may not state how fast its frames pass.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewTable {
    /// Camera names, in the order in which they first stand there.
    pub cameras: Vec<String>,
    /// Marker names, likewise.
    pub markers: Vec<String>,
    /// Number of the first frame.
    pub first_frame: i64,
    /// Number of frames.
    pub frames: usize,
    /// Frames a second, where the file says.
    pub rate_hz: Option<f64>,
    /// `frames × cameras × markers` points in pixels; those not seen NaN.
    pub points_px: Vec<Vec2>,
    /// Whether it has no column `frame`: one moment, without time.
    pub still: bool,
}

impl ViewTable {
    /// The views, at the rate of the file or else at `rate_hz`; those of one moment at 1 Hz where neither is known.
    ///
    /// # Errors
    /// Where a table with frames states no rate and none is given.
    pub fn into_views(self, rate_hz: Option<f64>) -> Result<Views, ReadError> {
        let still = self.still.then_some(1.0);
        let rate_hz = self.rate_hz.or(rate_hz).or(still).ok_or(CsvError::NoRate)?;
        let axis = FrameAxis { first: self.first_frame, count: self.frames, rate_hz };
        Ok(Views::new(axis, self.cameras, self.markers, self.points_px)?)
    }
}

/// Reads a table of views.
///
/// # Errors
/// See [`CsvError`]: each names line and column.
pub fn open(bytes: &[u8]) -> Result<ViewTable, ReadError> {
    Ok(from_table(Table::read(text(bytes)?)?)?)
}

fn column(table: &Table<'_>, name: &str) -> Option<usize> {
    (0..table.names.cells.len()).find(|index| table.name(*index).eq_ignore_ascii_case(name))
}

/// Whether text begins with the names of a table of views.
pub(crate) fn detect(table: &Table<'_>) -> bool {
    COLUMNS.iter().all(|name| column(table, name).is_some())
}

/// A name in a column, and its place among those seen so far.
fn place(
    table: &Table<'_>,
    row: &Row<'_>,
    index: usize,
    names: &mut Vec<String>,
    known: &mut BTreeMap<String, usize>,
) -> Result<usize, CsvError> {
    let name = row.cells[index].text.as_ref();
    if name.is_empty() {
        return Err(table.cell_error(row, index, "a name"));
    }
    Ok(*known.entry(name.to_owned()).or_insert_with(|| {
        names.push(name.to_owned());
        names.len() - 1
    }))
}

/// Most points that a table may spread out to: a slip in a frame number must not ask for all memory.
const MOST_POINTS: usize = 200_000_000;

fn from_table(table: Table<'_>) -> Result<ViewTable, CsvError> {
    let table = table.with_rows()?;
    let first = &table.names.cells[0];
    let find = |name: &str| {
        let problem =
            format!("there is no column `{name}`; a table of views has `frame` (or not), camera, marker, u_px, v_px");
        column(&table, name).ok_or_else(|| column_error(&table.names, first, problem))
    };
    let [camera, marker, u, v] = [find("camera")?, find("marker")?, find("u_px")?, find("v_px")?];
    let frame = column(&table, "frame");
    if let Some(other) = table
        .names
        .cells
        .iter()
        .enumerate()
        .find(|(index, _)| ![camera, marker, u, v].contains(index) && Some(*index) != frame)
    {
        return Err(column_error(
            &table.names,
            other.1,
            "a table of views has frame, camera, marker, u_px, v_px alone",
        ));
    }
    let (mut cameras, mut markers) = (Vec::new(), Vec::new());
    let (mut known_cameras, mut known_markers) = (BTreeMap::new(), BTreeMap::new());
    let mut seen = BTreeMap::new();
    let mut frames = BTreeSet::new();
    for row in &table.rows {
        let number = frame.map_or(Ok(0), |index| {
            row.cells[index].text.parse::<i64>().map_err(|_| table.cell_error(row, index, "a whole frame number"))
        })?;
        let from = place(&table, row, camera, &mut cameras, &mut known_cameras)?;
        let what = place(&table, row, marker, &mut markers, &mut known_markers)?;
        frames.insert(number);
        let empty = |index: usize| row.cells[index].text.is_empty();
        let point = match (empty(u), empty(v)) {
            (true, true) => Vec2::NAN,
            (false, false) => Vec2::new(table.number(row, u)?, table.number(row, v)?),
            (first, _) => {
                let wanted = "a number, though the other coordinate is; empty both";
                return Err(table.cell_error(row, if first { u } else { v }, wanted));
            }
        };
        if seen.insert((number, from, what), point).is_some() {
            return Err(table.cell_error(row, marker, "a marker that stands once for each frame and camera"));
        }
    }
    let (first_frame, last) = (frames.first().copied().unwrap_or(0), frames.last().copied().unwrap_or(0));
    let count = usize::try_from(last.saturating_sub(first_frame)).unwrap_or(usize::MAX).saturating_add(1);
    let points = count.checked_mul(cameras.len() * markers.len()).filter(|points| *points <= MOST_POINTS);
    let Some(points) = points else {
        let row = &table.rows[table.rows.len() - 1];
        return Err(table.cell_error(row, frame.unwrap_or(0), "a frame number near the others"));
    };
    let mut points_px = vec![Vec2::NAN; points];
    for ((number, from, what), point) in seen {
        let frame = (number - first_frame) as usize;
        points_px[(frame * cameras.len() + from) * markers.len() + what] = point;
    }
    let rate_hz = table.rate_hz()?;
    Ok(ViewTable { cameras, markers, first_frame, frames: count, rate_hz, points_px, still: frame.is_none() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Views, String> {
        open(text.as_bytes()).and_then(|table| table.into_views(None)).map_err(|error| error.to_string())
    }

    #[test]
    fn one_moment_and_many_frames_are_read() {
        let still = read("camera,marker,u_px,v_px\na,chin,1,2\nb,chin,3,4\nb,lip,,\n").unwrap();
        assert_eq!(
            (still.frames(), still.cameras(), still.markers()),
            (1, &["a".into(), "b".into()][..], &["chin".into(), "lip".into()][..])
        );
        assert_eq!((still.at(0, 1, 0), still.at(0, 0, 1), still.at(0, 1, 1)), (Some(Vec2::new(3.0, 4.0)), None, None));
        let text = "# rate_hz: 60\nframe,u_px,v_px,marker,camera\n7,1,2,chin,a\n9,3,4,chin,a\n";
        let take = read(text).unwrap();
        assert_eq!((take.frames(), take.frame_axis().first, take.at(1, 0, 0)), (3, 7, None));
        assert_eq!(take.at(2, 0, 0), Some(Vec2::new(3.0, 4.0)));
    }

    #[test]
    fn mistakes_name_line_and_column() {
        let head = "frame,camera,marker,u_px,v_px\n";
        assert!(read(&format!("{head}1,a,chin,1,2\n")).unwrap_err().contains("rate"));
        assert!(read(&format!("{head}x,a,chin,1,2\n")).unwrap_err().contains("2:1: `x`"));
        assert!(read(&format!("{head}1,a,chin,1,\n")).unwrap_err().contains("2:12"));
        assert!(read(&format!("{head}1,a,chin,1,2\n1,a,chin,1,3\n")).unwrap_err().contains("3:5"));
        assert!(read(&format!("{head}1,,chin,1,2\n")).unwrap_err().contains("a name"));
        assert!(
            read(&format!("{head}1,a,chin,1,2\n999999999999,a,chin,1,2\n")).unwrap_err().contains("near the others")
        );
        assert!(read("camera,marker,u,v\na,chin,1,2\n").unwrap_err().contains("no column `u_px`"));
        assert!(read("camera,marker,u_px,v_px,w\na,chin,1,2,3\n").unwrap_err().contains("column `w`"));
    }
}
