//! C3D: what motion capture systems write. Reads and writes every flavour of it.
//!
//! A file is a header block, parameter blocks and frames; numbers come in the formats of three processors
//! ([`Processor`]), coordinates as integers or reals ([`Storage`]). Sources: the C3D user guide (c3d.org) for the
//! layout, and for what real files do beyond it, the files themselves.

mod error;
mod fields;
mod layout;
mod numbers;
mod parameters;
mod write;

pub use error::C3dError;
pub use layout::Storage;
pub use numbers::Processor;
pub use write::{Flavour, write};

use crate::ReadError;
use crate::markers::{Format, MarkerFile, unique};
use crate::units::LengthUnit;
use face_math::data::Markers;
use glam::Vec3;
use layout::{BLOCK, Layout};
use numbers::{Source, vax_float};
use parameters::Parameters;

/// A take, and how its file stores it.
#[derive(Debug, Clone, PartialEq)]
pub struct Take {
    /// The markers, in metres.
    pub markers: Markers,
    /// Whose number formats the file uses.
    pub processor: Processor,
    /// How the coordinates are stored.
    pub storage: Storage,
    /// The unit of the coordinates in the file.
    pub unit: LengthUnit,
    /// Whether the file states no unit, so that millimetres were assumed, as the format's users do.
    pub unit_assumed: bool,
    /// Points that the file gives no name of their own, under the names they have here.
    pub renamed: Vec<String>,
}

/// Whether bytes look like a C3D file.
pub fn detect(bytes: &[u8]) -> bool {
    bytes.len() >= BLOCK
        && bytes[1] == 0x50
        && bytes[0] >= 2
        && bytes.get(parameters_at(bytes) + 3).is_some_and(|byte| Processor::from_byte(*byte).is_some())
}

/// Reads the markers of a C3D file, in metres.
///
/// A point is missing where its residual is negative or one of its coordinates is no finite number. Points beyond the
/// labels, and those with an empty label, are called `point_N` (N counted from 1); a label that stands twice is made
/// to differ by `#2`, `#3` ….
///
/// # Errors
/// See [`C3dError`]: each says at which byte or in which parameter.
pub fn read(bytes: &[u8]) -> Result<Markers, ReadError> {
    Ok(read_take(bytes)?.markers)
}

/// Reads a C3D file with the facts of its storage, otherwise as [`read`].
///
/// # Errors
/// See [`C3dError`].
pub fn read_take(bytes: &[u8]) -> Result<Take, ReadError> {
    let (file, processor, storage) = decode(bytes)?;
    let (unit, unit_assumed, renamed) = (file.unit, file.unit_assumed, file.renamed.clone());
    Ok(Take { markers: file.into_markers(None)?, processor, storage, unit, unit_assumed, renamed })
}

/// Reads a C3D file as files of markers of all kinds are given, otherwise as [`read`].
///
/// # Errors
/// See [`C3dError`].
pub fn open(bytes: &[u8]) -> Result<MarkerFile, ReadError> {
    Ok(decode(bytes)?.0)
}

fn decode(bytes: &[u8]) -> Result<(MarkerFile, Processor, Storage), C3dError> {
    let source = source(bytes)?;
    let (at, end) = parameter_section(&source)?;
    let parameters = Parameters::read(&source, at, end)?;
    let layout = Layout::read(&source, &parameters)?;
    let (names, renamed) = unique(labels(&parameters, layout.points)?);
    let (processor, storage) = (source.processor, layout.storage);
    let file = MarkerFile {
        format: Format::C3d { processor, storage },
        names,
        first_frame: layout.first_frame,
        frames: layout.frames,
        rate_hz: Some(layout.rate_hz),
        positions: positions(&source, &layout)?,
        unit: layout.unit,
        unit_assumed: layout.unit_assumed,
        renamed,
        left_out: Vec::new(),
    };
    Ok((file, processor, storage))
}

fn parameters_at(bytes: &[u8]) -> usize {
    bytes.first().map_or(0, |block| usize::from(*block).saturating_sub(1) * BLOCK)
}

fn source(bytes: &[u8]) -> Result<Source<'_>, C3dError> {
    match bytes {
        [] => return Err(C3dError::Empty),
        [_, 0x50, ..] => {}
        [_, found, ..] => return Err(C3dError::NoC3d { found: *found }),
        [_] => {
            return Err(C3dError::Short { what: "the header".into(), begins: 0, length: BLOCK, have: 1 });
        }
    }
    // Only the processor byte tells how to read numbers, so it is found with any of them.
    let unknown = Source { bytes, processor: Processor::Intel };
    unknown.slice(0, BLOCK, "the header")?;
    if bytes[0] < 2 {
        let what = "the header's pointer to the parameters must be 2 or more";
        return Err(C3dError::Value { at: 0, name: "the parameter block", value: bytes[0].to_string(), what });
    }
    let at = parameters_at(bytes) + 3;
    let found = unknown.u8(at, "the head of the parameters")?;
    let processor = Processor::from_byte(found).ok_or(C3dError::Processor { at, found })?;
    Ok(Source { bytes, processor })
}

/// Where the parameters begin, and where they end at the latest: at the data, or after as many blocks as their head
/// says (a byte, too small for large sections), whichever is farther; either may have been left behind.
fn parameter_section(source: &Source<'_>) -> Result<(usize, usize), C3dError> {
    let start = parameters_at(source.bytes);
    let blocks = usize::from(source.u8(start + 2, "the head of the parameters")?);
    let data = usize::from(source.u16(16, "the header")?).saturating_sub(1) * BLOCK;
    Ok((start + 4, data.max(start + blocks.max(1) * BLOCK)))
}

/// The label of each point; empty where the file has none.
fn labels(parameters: &Parameters, points: usize) -> Result<Vec<String>, C3dError> {
    // A parameter holds at most 255 labels; the others are in LABELS2, LABELS3 ….
    let mut labels = parameters.texts("POINT:LABELS")?;
    for extra in 2.. {
        let name = format!("POINT:LABELS{extra}");
        if !parameters.has(&name) {
            break;
        }
        labels.extend(parameters.texts(&name)?);
    }
    labels.resize(points, String::new());
    Ok(labels)
}

/// The positions of all frames in metres.
fn positions(source: &Source<'_>, layout: &Layout) -> Result<Vec<Vec3>, C3dError> {
    if layout.points == 0 || layout.frames == 0 {
        return Ok(Vec::new());
    }
    let data = source.slice(layout.data_at, layout.frames * layout.frame_length, "the frames")?;
    let unit = layout.unit;
    let processor = source.processor;
    let real = |point: &[u8; 16], number: fn([u8; 4]) -> f32| {
        let word = |at: usize| f64::from(number([point[at], point[at + 1], point[at + 2], point[at + 3]]));
        position([word(0), word(4), word(8)], word(12), unit)
    };
    Ok(match (layout.storage, processor) {
        (Storage::Real, Processor::Intel) => points(data, layout, |point| real(point, f32::from_le_bytes)),
        (Storage::Real, Processor::Mips) => points(data, layout, |point| real(point, f32::from_be_bytes)),
        (Storage::Real, Processor::Dec) => points(data, layout, |point| real(point, vax_float)),
        (Storage::Integer { scale }, _) => points(data, layout, |point: &[u8; 8]| {
            let word = |at: usize| f64::from(processor.u16([point[at], point[at + 1]]).cast_signed());
            position([word(0), word(2), word(4)].map(|number| number * scale), word(6), unit)
        }),
    })
}

/// One position of each `N` bytes of the points of each frame; the analog samples behind them are skipped.
fn points<const N: usize>(data: &[u8], layout: &Layout, position: impl Fn(&[u8; N]) -> Vec3) -> Vec<Vec3> {
    let mut positions = Vec::with_capacity(layout.frames * layout.points);
    for frame in data.chunks_exact(layout.frame_length) {
        positions.extend(frame.as_chunks::<N>().0.iter().take(layout.points).map(&position));
    }
    positions
}

/// x, y, z in units of length, and the residual, to a position in metres.
fn position(coordinates: [f64; 3], residual: f64, unit: LengthUnit) -> Vec3 {
    let point = Vec3::from_array(coordinates.map(|coordinate| unit.to_metres(coordinate)));
    // A residual that is no number says as little about the point as a negative one.
    if residual >= 0.0 && point.is_finite() { point } else { Vec3::NAN }
}
