//! Curves as tables: plain ones (`frame,channel,…`) and those that Live Link Face records; which, the names decide.

mod live_link;
mod plain;
mod timecode;

pub use live_link::LiveLink;
pub use plain::write;

use crate::csv::{CsvError, Table, text};
use crate::{ReadError, WriteError};
use face_math::data::Curves;
use wire::FrameAxis;

/// A table of curves as it stands in a file, which may not state how fast its frames pass.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveTable {
    /// Channel names.
    pub channels: Vec<String>,
    /// Number of the first frame.
    pub first_frame: i64,
    /// Number of frames.
    pub frames: usize,
    /// Frames a second, where the file says.
    pub rate_hz: Option<f64>,
    /// `frames × channels` values, frame after frame.
    pub values: Vec<f32>,
    /// What else a recording of Live Link Face holds.
    pub live_link: Option<LiveLink>,
}

impl CurveTable {
    /// The curves, at the rate of the file or else at `rate_hz`.
    ///
    /// # Errors
    /// Where neither is known.
    pub fn into_curves(self, rate_hz: Option<f64>) -> Result<Curves, ReadError> {
        let rate_hz = self.rate_hz.or(rate_hz).ok_or(CsvError::NoRate)?;
        let axis = FrameAxis { first: self.first_frame, count: self.frames, rate_hz };
        Ok(Curves::new(axis, self.channels, self.values)?)
    }
}

/// Whether text begins with the names of a table of curves.
pub(crate) fn detect(table: &Table<'_>) -> bool {
    live_link::detect(table) || plain::detect(table)
}

/// Reads a table of curves of either kind. `rate_hz` is used where the file states no rate.
///
/// # Errors
/// See [`CsvError`]: each names line and column.
pub fn read(bytes: &[u8], rate_hz: Option<f64>) -> Result<Curves, ReadError> {
    open(bytes)?.into_curves(rate_hz)
}

/// Reads a table of curves of either kind, with what the file says beside the values.
///
/// # Errors
/// See [`CsvError`].
pub fn open(bytes: &[u8]) -> Result<CurveTable, ReadError> {
    Ok(from_table(Table::read(text(bytes)?)?)?)
}

pub(crate) fn from_table(table: Table<'_>) -> Result<CurveTable, CsvError> {
    let table = table.with_rows()?;
    if live_link::detect(&table) { live_link::read(&table) } else { plain::read(&table) }
}

/// Writes curves as a recording of Live Link Face: the 52 `ARKit` columns, without the rotations of head and eyes.
///
/// The inverse of the reading: the `_L` channel of `BrowInnerUp` and `CheekPuff`, which drive both sides, is averaged
/// with the `_R` one. Timecodes count from 00:00:00:00 at the rate of the curves, rounded to whole hertz.
///
/// # Errors
/// Where a channel has no `ARKit` column, where one that Live Link Face must have is absent, or a value is not finite.
pub fn write_live_link(curves: &Curves) -> Result<Vec<u8>, WriteError> {
    live_link::write(curves)
}
