//! C3D: what motion capture systems write. Reads every flavour of it, writes the plainest.
//!
//! A file is a header block, parameter blocks and frames; numbers come in the formats of three processors
//! ([`Processor`]), coordinates as integers or reals ([`Storage`]). Sources: the C3D user guide (c3d.org) for the
//! layout, and for what real files do beyond it, the files themselves.

mod error;
mod layout;
mod numbers;
mod parameters;
mod write;

pub use error::C3dError;
pub use layout::Storage;
pub use numbers::Processor;
pub use write::write;

use crate::ReadError;
use crate::units::LengthUnit;
use face_math::data::Markers;
use glam::Vec3;
use layout::{BLOCK, Layout};
use numbers::Source;
use parameters::Parameters;
use std::collections::BTreeSet;
use wire::FrameAxis;

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
    let source = open(bytes)?;
    let (at, end) = parameter_section(&source)?;
    let parameters = Parameters::read(&source, at, end)?;
    let layout = Layout::read(&source, &parameters)?;
    let (names, renamed) = names(&parameters, layout.points)?;
    let positions = positions(&source, &layout)?;
    let axis = FrameAxis { first: layout.first_frame, count: layout.frames, rate_hz: layout.rate_hz };
    Ok(Take {
        markers: Markers::new(axis, names, positions)?,
        processor: source.processor,
        storage: layout.storage,
        unit: layout.unit,
        unit_assumed: layout.unit_assumed,
        renamed,
    })
}

fn parameters_at(bytes: &[u8]) -> usize {
    bytes.first().map_or(0, |block| usize::from(*block).saturating_sub(1) * BLOCK)
}

fn open(bytes: &[u8]) -> Result<Source<'_>, C3dError> {
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
        return Err(C3dError::Value { name: "the parameter block", value: bytes[0].to_string(), what });
    }
    let at = parameters_at(bytes) + 3;
    let found = unknown.u8(at, "the head of the parameters")?;
    let processor = Processor::from_byte(found).ok_or(C3dError::Processor { at, found })?;
    Ok(Source { bytes, processor })
}

/// Where the parameters begin, and where they end at the latest: at the data, or else after as many blocks as their
/// head says (a byte, too small for large sections).
fn parameter_section(source: &Source<'_>) -> Result<(usize, usize), C3dError> {
    let start = parameters_at(source.bytes);
    let blocks = usize::from(source.u8(start + 2, "the head of the parameters")?);
    let data = usize::from(source.u16(16, "the header")?).saturating_sub(1) * BLOCK;
    let end = if data > start { data } else { start + blocks.max(1) * BLOCK };
    Ok((start + 4, end))
}

fn names(parameters: &Parameters, points: usize) -> Result<(Vec<String>, Vec<String>), C3dError> {
    // A parameter holds at most 255 labels; the others are in LABELS2, LABELS3 ….
    let mut labels = parameters.texts("POINT:LABELS")?;
    for extra in 2.. {
        let name = format!("POINT:LABELS{extra}");
        if !parameters.has(&name) {
            break;
        }
        labels.extend(parameters.texts(&name)?);
    }
    labels.truncate(points);
    labels.resize(points, String::new());
    let mut taken: BTreeSet<String> = labels.iter().filter(|label| !label.is_empty()).cloned().collect();
    let mut seen = BTreeSet::new();
    let mut renamed = Vec::new();
    for (index, label) in labels.iter_mut().enumerate() {
        if !label.is_empty() && seen.insert(label.clone()) {
            continue;
        }
        let (stem, bare) =
            if label.is_empty() { (format!("point_{}", index + 1), true) } else { (label.clone(), false) };
        let mut name = if bare { stem.clone() } else { format!("{stem}#2") };
        let mut number = 2;
        while !taken.insert(name.clone()) {
            number += 1;
            name = format!("{stem}#{number}");
        }
        renamed.push(name.clone());
        *label = name;
    }
    Ok((labels, renamed))
}

fn positions(source: &Source<'_>, layout: &Layout) -> Result<Vec<Vec3>, C3dError> {
    if layout.points == 0 || layout.frames == 0 {
        return Ok(Vec::new());
    }
    let word = layout.storage.word();
    let data = source.slice(layout.data_at, layout.frames * layout.frame_length, "the frames")?;
    let mut positions = Vec::with_capacity(layout.frames * layout.points);
    for frame in data.chunks_exact(layout.frame_length) {
        for point in frame[..4 * layout.points * word].chunks_exact(4 * word) {
            let words: [f64; 4] = std::array::from_fn(|index| {
                let at = index * word;
                match layout.storage {
                    Storage::Real => {
                        f64::from(source.processor.f32([point[at], point[at + 1], point[at + 2], point[at + 3]]))
                    }
                    Storage::Integer { .. } => {
                        f64::from(source.processor.u16([point[at], point[at + 1]]).cast_signed())
                    }
                }
            });
            positions.push(position(words, layout));
        }
    }
    Ok(positions)
}

/// x, y, z and the residual word, as stored, to a position in metres.
fn position([x, y, z, residual]: [f64; 4], layout: &Layout) -> Vec3 {
    let scale = match layout.storage {
        Storage::Integer { scale } => scale,
        Storage::Real => 1.0,
    };
    let point = Vec3::from_array([x, y, z].map(|number| layout.unit.to_metres(number * scale)));
    // A residual that is no number says as little about the point as a negative one.
    if residual >= 0.0 && point.is_finite() { point } else { Vec3::NAN }
}
