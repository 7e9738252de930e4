//! Landmarks as `OpenFace` writes them (CSV): of the face in the picture (`x_0`, `y_0` …, pixels) and in space (`X_0`,
//! `Y_0`, `Z_0` …, millimetres from the camera).
//!
//! Only those in space are markers, under the names `landmark_0` …. Their axes are the camera's: x to the right, y
//! down, z away from it. Where `OpenFace` did not succeed, its numbers are left over from another frame: such frames are
//! missing. A file without landmarks in space is refused, because a picture has no depth. With several faces in a
//! file, names begin with the face: `face_1:landmark_0`. Source: `OpenFace`'s wiki, "Output Format".

use super::frames::POINTS_A_BYTE;
use super::{Format, MarkerFile};
use crate::ReadError;
use crate::csv::{CsvError, Row, Table, text};
use crate::units::LengthUnit;
use glam::Vec3;
use std::collections::BTreeMap;

/// Rates of cameras, in hertz.
const USUAL_HZ: [f64; 16] = [
    12.0,
    15.0,
    24_000.0 / 1001.0,
    24.0,
    25.0,
    30_000.0 / 1001.0,
    30.0,
    48.0,
    50.0,
    60_000.0 / 1001.0,
    60.0,
    72.0,
    90.0,
    100.0,
    120_000.0 / 1001.0,
    120.0,
];

/// Time stamps are rounded to this many seconds.
const TICK_S: f64 = 0.001;

/// Whether the names of a table are those of `OpenFace`, of landmarks in space or in the picture.
pub(crate) fn detect(names: &[&str]) -> bool {
    let has = |name: &str| names.contains(&name);
    has("success") && has("confidence") && (has("X_0") || has("x_0")) || has("X_0") && has("Y_0") && has("Z_0")
}

/// The columns of a table of `OpenFace`.
struct Columns {
    frame: usize,
    face: Option<usize>,
    time: Option<usize>,
    success: Option<usize>,
    /// x, y and z of each landmark.
    landmarks: Vec<[usize; 3]>,
}

/// Reads the landmarks in space.
///
/// # Errors
/// See [`CsvError`]: each names the line, and the column where one cell is at fault.
pub fn open(bytes: &[u8]) -> Result<MarkerFile, ReadError> {
    Ok(parse(bytes)?)
}

fn parse(bytes: &[u8]) -> Result<MarkerFile, CsvError> {
    let table = Table::read(text(bytes)?)?.with_rows()?;
    let columns = Columns::of(&table)?;
    let mut by_face: BTreeMap<i64, BTreeMap<i64, usize>> = BTreeMap::new();
    let (mut low, mut high) = (i64::MAX, i64::MIN);
    for (index, row) in table.rows.iter().enumerate() {
        let frame = whole(&table, row, columns.frame)?;
        let face = columns.face.map_or(Ok(0), |column| whole(&table, row, column))?;
        let frames = by_face.entry(face).or_default();
        if let Some((before, _)) = frames.last_key_value()
            && *before >= frame
        {
            let column = row.cells[columns.frame].column;
            return Err(CsvError::Frame { line: row.line, column, before: *before, found: frame });
        }
        frames.insert(frame, index);
        (low, high) = (low.min(frame), high.max(frame));
    }
    let count = high.abs_diff(low).saturating_add(1);
    let names = names(&by_face, columns.landmarks.len());
    let line = table.rows.last().map_or(1, |row| row.line);
    if count.saturating_mul(names.len() as u64) > (bytes.len() * POINTS_A_BYTE) as u64 {
        return Err(CsvError::Sparse { line, markers: names.len() });
    }
    let mut positions = Vec::with_capacity(count as usize * names.len());
    for frame in low..=high {
        for frames in by_face.values() {
            match frames.get(&frame).map(|index| &table.rows[*index]) {
                Some(row) if columns.succeeded(&table, row)? => {
                    for landmark in &columns.landmarks {
                        positions.push(position(&table, row, *landmark)?);
                    }
                }
                _ => positions.extend(columns.landmarks.iter().map(|_| Vec3::NAN)),
            }
        }
    }
    let rate_hz = match (table.rate_hz()?, columns.time) {
        (Some(rate), _) => Some(rate),
        (None, Some(time)) => rate(&table, columns.frame, time)?,
        (None, None) => None,
    };
    Ok(MarkerFile {
        format: Format::OpenFace,
        names,
        first_frame: low,
        frames: count as usize,
        rate_hz,
        positions,
        unit: LengthUnit::Millimetre,
        unit_assumed: false,
        renamed: Vec::new(),
        left_out: others(&table),
    })
}

impl Columns {
    fn of(table: &Table<'_>) -> Result<Self, CsvError> {
        let by_name: BTreeMap<&str, usize> =
            table.names.cells.iter().enumerate().map(|(index, cell)| (cell.text.as_ref(), index)).collect();
        let column = |name: &str| by_name.get(name).copied();
        let landmark = |index: usize| {
            let axis = |axis: &str| column(&format!("{axis}_{index}"));
            Some([axis("X")?, axis("Y")?, axis("Z")?])
        };
        let landmarks: Vec<_> = (0..by_name.len()).map_while(landmark).collect();
        if landmarks.is_empty() {
            return Err(CsvError::NoMarkers {
                holds: "landmarks in a picture, in pixels, without depth".to_owned(),
                cure: "run OpenFace with `-3Dfp`, so that it writes X_0, Y_0, Z_0 …, or load them as landmarks",
            });
        }
        let Some(frame) = column("frame") else {
            return Err(CsvError::NoMarkers {
                holds: "landmarks of single pictures (it has no column `frame`)".to_owned(),
                cure: "run OpenFace on the whole sequence (FeatureExtraction)",
            });
        };
        let (face, time, success) = (column("face_id"), column("timestamp"), column("success"));
        Ok(Self { frame, face, time, success, landmarks })
    }

    fn succeeded(&self, table: &Table<'_>, row: &Row<'_>) -> Result<bool, CsvError> {
        let Some(column) = self.success else { return Ok(true) };
        match row.cells[column].text.parse::<f64>() {
            Ok(0.0) => Ok(false),
            Ok(1.0) => Ok(true),
            _ => Err(table.cell_error(row, column, "0 or 1")),
        }
    }
}

fn names(by_face: &BTreeMap<i64, BTreeMap<i64, usize>>, landmarks: usize) -> Vec<String> {
    let prefix = |face: &i64| if by_face.len() > 1 { format!("face_{face}:") } else { String::new() };
    let of_face = |face| (0..landmarks).map(move |index| format!("{}landmark_{index}", prefix(face)));
    by_face.keys().flat_map(of_face).collect()
}

fn whole(table: &Table<'_>, row: &Row<'_>, column: usize) -> Result<i64, CsvError> {
    let number = row.cells[column].text.parse::<f64>().ok();
    let whole = number.filter(|number| number.fract() == 0.0 && number.abs() < 1e15);
    whole.map(|number| number as i64).ok_or_else(|| table.cell_error(row, column, "a whole number"))
}

/// Millimetres in three cells to metres; missing where all are `NaN`.
fn position(table: &Table<'_>, row: &Row<'_>, columns: [usize; 3]) -> Result<Vec3, CsvError> {
    if columns.iter().all(|column| row.cells[*column].text.to_lowercase().trim_start_matches('-').starts_with("nan")) {
        return Ok(Vec3::NAN);
    }
    let mut point = Vec3::ZERO;
    for (axis, column) in columns.into_iter().enumerate() {
        point[axis] = LengthUnit::Millimetre.to_metres(f64::from(table.number(row, column)?));
    }
    Ok(point)
}

/// The rate that the time stamps tell: (frames from first to last) / (seconds from first to last).
///
/// The stamps are rounded, so the rate is known to lie between two bounds. Where exactly one usual rate does, it is
/// that one; where more than one does (29.97 and 30 in a short take), or no time passes, it is not known.
fn rate(table: &Table<'_>, frame: usize, time: usize) -> Result<Option<f64>, CsvError> {
    let (Some(first), Some(last)) = (table.rows.first(), table.rows.last()) else { return Ok(None) };
    let frames = (whole(table, last, frame)? - whole(table, first, frame)?) as f64;
    let stamp = |row: &Row<'_>| table.number(row, time).map(f64::from);
    let seconds = stamp(last)? - stamp(first)?;
    if frames < 1.0 || seconds <= TICK_S {
        return Ok(None);
    }
    let (low, high) = (frames / (seconds + TICK_S), frames / (seconds - TICK_S));
    let usual: Vec<f64> = USUAL_HZ.into_iter().filter(|rate| (low..=high).contains(rate)).collect();
    Ok(match usual.as_slice() {
        [one] => Some(*one),
        [] => Some(frames / seconds),
        _ => None,
    })
}

/// What else `OpenFace` wrote.
fn others(table: &Table<'_>) -> Vec<String> {
    let has = |start: &str| table.names.cells.iter().any(|cell| cell.text.starts_with(start));
    let groups = [
        ("x_0", "landmarks in the picture"),
        ("eye_lmk_", "landmarks of the eyes"),
        ("gaze_", "gaze"),
        ("pose_", "pose of the head"),
        ("p_", "parameters of its face model"),
        ("AU", "action units"),
    ];
    groups.into_iter().filter(|(start, _)| has(start)).map(|(_, what)| what.to_owned()).collect()
}
