//! What any readable file holds: its kind, counts, rate, names, ranges, gaps, as JSON or as text for people.

mod facts;
mod landmarks;

pub use facts::{Inspection, Stats};

use crate::csv::{Table, first_names, text};
use crate::{ReadError, Sibling, camera_json, curves, edits, fbx, gltf, markers, obj, png, regions, view_csv};

/// What can be read, for messages.
const READABLE: &str = "C3D and TRC takes, glTF and GLB rigs, FBX rigs, OBJ faces, tables of curves, Live Link Face \
                        recordings, tables of markers (plain, of Motive, Vicon or OpenFace), landmarks or views of cameras \
                        (CSV), PNG pictures, calibrated cameras (JSON), edits (RON), regions (JSON or RON)";

/// The kinds of file.
#[derive(Clone, Copy)]
enum Kind {
    Markers(markers::Kind),
    Gltf,
    Fbx,
    Obj,
    Png,
    Curves,
    Landmarks,
    Views,
    Cameras,
    Edits,
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
        Kind::Markers(kind) => facts::markers(&markers::open_as(kind, bytes)?),
        Kind::Gltf => facts::head(&gltf::outline(bytes, stem, sibling)?),
        Kind::Fbx => facts::fbx(&fbx::outline(bytes, stem)?),
        Kind::Obj => facts::obj(&obj::open(bytes)?, stem)?,
        Kind::Png => facts::picture(&png::read(bytes)?),
        Kind::Curves => facts::curves(&curves::open(bytes)?),
        Kind::Landmarks => landmarks::facts(&Table::read(text(bytes)?)?)?,
        Kind::Views => facts::views(&view_csv::open(bytes)?),
        Kind::Cameras => facts::cameras(&camera_json::read(bytes)?),
        Kind::Edits => facts::edits(&edits::read(bytes)?),
        Kind::Regions => facts::regions(&regions::read(bytes)?),
    })
}

fn by_content(bytes: &[u8]) -> Option<Kind> {
    if png::detect(bytes) {
        return Some(Kind::Png);
    }
    if gltf::detect(bytes) {
        return Some(Kind::Gltf);
    }
    if fbx::detect(bytes) {
        return Some(Kind::Fbx);
    }
    if obj::detect(bytes) {
        return Some(Kind::Obj);
    }
    // OpenFace's landmarks in the picture are no markers, and are told of as landmarks.
    match markers::detect(bytes) {
        Some(markers::Kind::OpenFace) if !in_space(bytes) => {}
        Some(kind) => return Some(Kind::Markers(kind)),
        None => {}
    }
    let text = text(bytes).ok()?;
    if text.trim_start().starts_with(['{', '(', '/', '#']) {
        if regions::detect(bytes) {
            return Some(Kind::Regions);
        }
        if edits::detect(bytes) {
            return Some(Kind::Edits);
        }
    }
    if text.trim_start().starts_with('{') && camera_json::detect(bytes) {
        return Some(Kind::Cameras);
    }
    let table = Table::read(text).ok()?;
    if view_csv::detect(&table) {
        Some(Kind::Views)
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
    if let Some(kind) = markers::by_ending(name) {
        return Some(Kind::Markers(kind));
    }
    let (_, ending) = name.rsplit_once('.')?;
    Some(match ending.to_lowercase().as_str() {
        "glb" | "gltf" => Kind::Gltf,
        "fbx" => Kind::Fbx,
        "obj" => Kind::Obj,
        "png" => Kind::Png,
        "csv" => Kind::Curves,
        "json" | "ron" => Kind::Regions,
        _ => return None,
    })
}

/// Whether a table has landmarks in space.
fn in_space(bytes: &[u8]) -> bool {
    let names = text(bytes).ok().and_then(first_names);
    names.is_some_and(|names| names.iter().any(|name| name == "X_0"))
}
