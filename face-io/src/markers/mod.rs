//! Files of markers of every kind: which kind it is shows in the content, whatever the file is called.
//!
//! | module | what it reads and writes |
//! |---|---|
//! | [`crate::c3d`] | C3D, of every system |
//! | [`trc`] | TRC, of Motion Analysis, `OpenSim` and others |
//! | [`motive`] | CSV of `OptiTrack`'s Motive (read only) |
//! | [`vicon`] | CSV of Vicon's Nexus (read only) |
//! | [`openface`] | landmarks of `OpenFace` in space (read only) |
//! | [`crate::marker_csv`] | plain tables |
//!
//! [`open`] is the only place where kinds of marker file are told apart.

mod frames;
pub mod motive;
mod names;
pub mod openface;
pub mod trc;
pub mod vicon;

pub(crate) use names::unique;

use crate::c3d::{self, Processor, Storage};
use crate::csv::{CsvError, first_names, text};
use crate::units::LengthUnit;
use crate::{ReadError, curves, marker_csv};
use face_math::data::Markers;
use glam::Vec3;
use std::fmt;
use wire::FrameAxis;

/// What can be read, for messages.
const READABLE: &str = "C3D, TRC, CSV of Motive, of Vicon, of OpenFace (landmarks in space), and tables of markers";

/// The kinds of marker file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    C3d,
    Trc,
    Motive,
    Vicon,
    OpenFace,
    Table,
}

/// Format and flavour of a file of markers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Format {
    /// C3D.
    C3d {
        /// Whose number formats it uses.
        processor: Processor,
        /// How coordinates are stored.
        storage: Storage,
    },
    /// TRC.
    Trc,
    /// CSV of `OptiTrack`'s Motive.
    Motive {
        /// Whether the file has no measured markers, so that the places that Motive expects of the markers of its
        /// bodies stand in.
        expected: bool,
    },
    /// CSV of Vicon's Nexus.
    Vicon,
    /// Landmarks of `OpenFace` in space.
    OpenFace,
    /// A plain table, one row a frame.
    Table,
    /// A plain table, one row a marker: a face at rest.
    Neutral,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::C3d { processor, storage } => write!(f, "C3D, {}, {}", processor.name(), storage.name()),
            Self::Trc => f.write_str("TRC"),
            Self::Motive { expected: false } => f.write_str("CSV, Motive"),
            Self::Motive { expected: true } => f.write_str("CSV, Motive, expected places of markers"),
            Self::Vicon => f.write_str("CSV, Vicon"),
            Self::OpenFace => f.write_str("CSV, OpenFace"),
            Self::Table => f.write_str("CSV, markers by frame"),
            Self::Neutral => f.write_str("CSV, neutral markers"),
        }
    }
}

/// Markers as they stand in a file, which may not state how fast its frames pass.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerFile {
    /// Format and flavour.
    pub format: Format,
    /// Marker names; no two are the same.
    pub names: Vec<String>,
    /// Number of the first frame.
    pub first_frame: i64,
    /// Number of frames.
    pub frames: usize,
    /// Frames a second, where the file says.
    pub rate_hz: Option<f64>,
    /// `frames × names` positions in metres, frame after frame; missing ones NaN.
    pub positions: Vec<Vec3>,
    /// The unit of the file.
    pub unit: LengthUnit,
    /// Whether the file states no unit, so that the one its format's users have was assumed.
    pub unit_assumed: bool,
    /// Markers that the file gives no name of their own, under the names they have here.
    pub renamed: Vec<String>,
    /// What the file holds that is no marker, and was left out, for people.
    pub left_out: Vec<String>,
}

impl MarkerFile {
    /// Whether it is one face at rest, without time.
    pub fn is_neutral(&self) -> bool {
        self.format == Format::Neutral
    }

    /// The markers, at the rate of the file or else at `rate_hz`; a neutral face, which has no time, at 1 Hz where
    /// neither is known.
    ///
    /// # Errors
    /// Where a take states no rate and none is given.
    pub fn into_markers(self, rate_hz: Option<f64>) -> Result<Markers, ReadError> {
        let still = self.is_neutral().then_some(1.0);
        let rate_hz = self.rate_hz.or(rate_hz).or(still).ok_or(CsvError::NoRate)?;
        let axis = FrameAxis { first: self.first_frame, count: self.frames, rate_hz };
        Ok(Markers::new(axis, self.names, self.positions)?)
    }
}

/// The kind of marker file that bytes are, as far as their beginning tells.
pub(crate) fn detect(bytes: &[u8]) -> Option<Kind> {
    if c3d::detect(bytes) {
        return Some(Kind::C3d);
    }
    // What is no text further on is still known by its beginning, and its reader says where it is damaged.
    let text = match text(bytes) {
        Ok(text) => text,
        Err(CsvError::NotText { at, .. }) => crate::csv::text(&bytes[..at]).ok()?,
        Err(_) => return None,
    };
    if trc::detect(text) {
        return Some(Kind::Trc);
    }
    if motive::detect(text) {
        return Some(Kind::Motive);
    }
    if vicon::detect(text) {
        return Some(Kind::Vicon);
    }
    let names = first_names(text)?;
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    if openface::detect(&names) {
        Some(Kind::OpenFace)
    } else if marker_csv::detect(&names) {
        Some(Kind::Table)
    } else {
        None
    }
}

/// The kind that a name's ending promises, for files whose damage hides it.
pub(crate) fn by_ending(name: &str) -> Option<Kind> {
    let (_, ending) = name.rsplit_once('.')?;
    match ending.to_lowercase().as_str() {
        "c3d" => Some(Kind::C3d),
        "trc" => Some(Kind::Trc),
        _ => None,
    }
}

/// Reads the markers of a file of any kind. The kind shows in `bytes`; the ending of `name` only serves to say what
/// is wrong with a file whose damage hides it.
///
/// # Errors
/// Where the bytes are no markers, and those of the kind's own reader: each names the place.
pub fn open(name: &str, bytes: &[u8]) -> Result<MarkerFile, ReadError> {
    match detect(bytes).or_else(|| by_ending(name)) {
        Some(kind) => open_as(kind, bytes),
        None if bytes.is_empty() => Err(CsvError::NoBytes.into()),
        None => Err(no_markers(name, bytes)),
    }
}

pub(crate) fn open_as(kind: Kind, bytes: &[u8]) -> Result<MarkerFile, ReadError> {
    match kind {
        Kind::C3d => c3d::open(bytes),
        Kind::Trc => trc::open(bytes),
        Kind::Motive => motive::open(bytes),
        Kind::Vicon => vicon::open(bytes),
        Kind::OpenFace => openface::open(bytes),
        Kind::Table => marker_csv::open(bytes),
    }
}

/// Reads the markers of a file of any kind, as [`open`]. `rate_hz` is used where the file states no rate.
///
/// # Errors
/// As [`open`], and where neither the file nor the caller knows the rate.
pub fn read(name: &str, bytes: &[u8], rate_hz: Option<f64>) -> Result<Markers, ReadError> {
    open(name, bytes)?.into_markers(rate_hz)
}

/// What is wrong with a file that is no markers, as far as it can be told.
fn no_markers(name: &str, bytes: &[u8]) -> ReadError {
    let refused = |holds: &str, cure| CsvError::NoMarkers { holds: holds.to_owned(), cure }.into();
    if let Some(names) = text(bytes).ok().and_then(first_names) {
        let has = |wanted: &str| names.iter().any(|name| name == wanted);
        if has("x_0") && has("y_0") {
            return refused(
                "landmarks in a picture, in pixels, without depth",
                "load them as landmarks, or track the face in space",
            );
        }
        let first = |wanted: &str| names.first().is_some_and(|name| name.eq_ignore_ascii_case(wanted));
        if first("timecode") && names.len() > 2 {
            return refused("animation curves of Live Link Face", "load it as curves");
        }
        if first("frame") && curves::open(bytes).is_ok() {
            return refused("animation curves", "load it as curves; columns of markers end in _x_mm, _y_mm, _z_mm");
        }
        if name.to_lowercase().ends_with(".csv")
            && let Err(error) = marker_csv::open(bytes)
        {
            return error;
        }
    }
    ReadError::Unknown { name: name.to_owned(), readable: READABLE }
}
