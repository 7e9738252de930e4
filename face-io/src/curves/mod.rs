//! Curves as tables: plain ones (`frame,channel,…`) and those that Live Link Face records; which, the names decide.

mod clock;
mod live_link;
mod plain;
mod timecode;

pub use clock::{Gap, Timing};
pub use live_link::LiveLink;
pub use plain::write;
pub use timecode::Timecode;

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

    /// Refuses a recording with a gap that lasts longer than `longest_s` seconds.
    ///
    /// # Errors
    /// With the line after the first such gap.
    pub fn refuse_gaps(&self, longest_s: f64) -> Result<(), CsvError> {
        let gaps = self.live_link.iter().flat_map(|live_link| &live_link.gaps);
        match gaps.into_iter().find(|gap| gap.seconds > longest_s) {
            Some(Gap { line, frames, seconds }) => {
                Err(CsvError::LongGap { line: *line, frames: *frames, seconds: *seconds, longest_s })
            }
            None => Ok(()),
        }
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
    open_with(bytes, Timing::default())
}

/// Reads a table of curves of either kind; rows with timecodes become frames as `timing` says, which does not matter
/// for plain tables.
///
/// # Errors
/// See [`CsvError`].
pub fn open_with(bytes: &[u8], timing: Timing) -> Result<CurveTable, ReadError> {
    let table = Table::read(text(bytes)?)?.with_rows()?;
    Ok(if live_link::detect(&table) { live_link::read(&table, timing) } else { plain::read(&table) }?)
}

/// Writes curves as a recording of Live Link Face: the 52 `ARKit` columns, without the rotations of head and eyes.
///
/// The inverse of the reading: the `_L` channel of `BrowInnerUp` and `CheekPuff`, which drive both sides, is averaged
/// with the `_R` one. Timecodes count from `first` on, at the rate of the curves rounded to whole hertz; drop-frame,
/// where `first` is, which 29.97, 59.94 and 119.88 Hz allow.
///
/// # Errors
/// Where a channel has no `ARKit` column, where one that Live Link Face must have is absent, a value is not finite, or
/// `first` is no timecode at this rate.
pub fn write_live_link(curves: &Curves, first: Timecode) -> Result<Vec<u8>, WriteError> {
    live_link::write(curves, first)
}
