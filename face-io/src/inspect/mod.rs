//! What any readable file holds: its kind, counts, rate, names, ranges, gaps, as JSON or as text for people.

mod facts;
mod landmarks;

pub use facts::{Inspection, Stats};

use crate::csv::{Table, text};
use crate::{ReadError, Sibling, c3d, camera_json, curves, gltf, marker_csv, png, regions, view_csv};

/// What can be read, for messages.
const READABLE: &str = "C3D takes, glTF and GLB rigs, tables of curves, Live Link Face recordings, tables of markers, \
                        landmarks or views of cameras (CSV), PNG pictures, \
                        calibrated cameras (JSON), regions (JSON or RON)";

/// The kinds of file.
#[derive(Clone, Copy)]
enum Kind {
    C3d,
    Gltf,
    Png,
    Curves,
    Markers,
    Landmarks,
    Views,
    Cameras,
    Regions,
}

/// Says what a file holds. Its kind shows in the bytes, or else in the ending of `name`.
///
/// `sibling` fetches companion files. Positions are in metres.
///
/// # Errors
/// Where the kind is unknown, and those of the kind's own reader.
pub fn inspect(name: &str, bytes: &[u8], sibling: &mut Sibling<'_>) -> Result<Inspection, ReadError> {
    let Some(kind) = by_content(bytes).or_else(|| by_ending(name)) else {
        return Err(ReadError::Unknown { name: name.to_owned(), readable: READABLE });
    };
    let stem = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem);
    Ok(match kind {
        Kind::C3d => facts::take(&c3d::read_take(bytes)?),
        Kind::Gltf => facts::head(&gltf::outline(bytes, stem, sibling)?),
        Kind::Png => facts::picture(&png::read(bytes)?),
        Kind::Curves => facts::curves(&curves::open(bytes)?),
        Kind::Markers => facts::marker_table(&marker_csv::open(bytes)?),
        Kind::Landmarks => landmarks::facts(&Table::read(text(bytes)?)?)?,
        Kind::Views => facts::views(&view_csv::open(bytes)?),
        Kind::Cameras => facts::cameras(&camera_json::read(bytes)?),
        Kind::Regions => facts::regions(&regions::read(bytes)?),
    })
}

fn by_content(bytes: &[u8]) -> Option<Kind> {
    if png::detect(bytes) {
        return Some(Kind::Png);
    }
    if c3d::detect(bytes) {
        return Some(Kind::C3d);
    }
    if gltf::detect(bytes) {
        return Some(Kind::Gltf);
    }
    let text = text(bytes).ok()?;
    if text.trim_start().starts_with(['{', '(', '/', '#']) && regions::detect(bytes) {
        return Some(Kind::Regions);
    }
    if text.trim_start().starts_with('{') && camera_json::detect(bytes) {
        return Some(Kind::Cameras);
    }
    let table = Table::read(text).ok()?;
    if view_csv::detect(&table) {
        Some(Kind::Views)
    } else if marker_csv::detect(&table) {
        Some(Kind::Markers)
    } else if landmarks::detect(&table) {
        Some(Kind::Landmarks)
    } else if curves::detect(&table) {
        Some(Kind::Curves)
    } else {
        None
    }
}

/// The kind that a name's ending promises, for files whose damage hides it.
fn by_ending(name: &str) -> Option<Kind> {
    let (_, ending) = name.rsplit_once('.')?;
    Some(match ending.to_lowercase().as_str() {
        "c3d" => Kind::C3d,
        "glb" | "gltf" => Kind::Gltf,
        "png" => Kind::Png,
        "csv" => Kind::Curves,
        "json" | "ron" => Kind::Regions,
        _ => return None,
    })
}
