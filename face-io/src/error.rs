//! Why bytes could not be read or written, and how readers reach companion files.
//!
//! Each format has its own error with its own facts; [`ReadError`] and [`WriteError`] are what all of them become
//! at the border of the crate. None of them knows the name of the file: whoever handed the bytes over adds it.

use crate::c3d::C3dError;
use crate::camera_json::CamerasError;
use crate::csv::CsvError;
use crate::edits::EditsError;
use crate::fbx::FbxError;
use crate::gltf::GltfError;
use crate::muscles::MusclesError;
use crate::obj::ObjError;
use crate::png::PngError;
use crate::regions::RegionsError;
use face_math::data::DataError;
use face_math::rig::RigError;

/// Fetches a file that another one refers to, by the relative path that stands there.
///
/// Whoever calls a reader decides where that path leads and whether it may be followed.
pub type Sibling<'a> = dyn FnMut(&str) -> std::io::Result<Vec<u8>> + 'a;

/// For formats or files without companions: refuses each request.
///
/// # Errors
/// Always.
pub fn no_sibling(path: &str) -> std::io::Result<Vec<u8>> {
    Err(std::io::Error::new(std::io::ErrorKind::NotFound, format!("no companion files are at hand, `{path}` neither")))
}

/// Why a file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// A C3D file.
    #[error("C3D: {0}")]
    C3d(#[from] C3dError),
    /// A glTF or GLB file.
    #[error("glTF: {0}")]
    Gltf(#[from] GltfError),
    /// An FBX file.
    #[error("FBX: {0}")]
    Fbx(#[from] FbxError),
    /// An OBJ file.
    #[error("OBJ: {0}")]
    Obj(#[from] ObjError),
    /// A table of comma-separated values.
    #[error("CSV: {0}")]
    Csv(#[from] CsvError),
    /// A TRC file.
    #[error("TRC: {0}")]
    Trc(CsvError),
    /// A PNG picture.
    #[error("PNG: {0}")]
    Png(#[from] PngError),
    /// A file of regions.
    #[error("regions: {0}")]
    Regions(#[from] RegionsError),
    /// A file of edits.
    #[error("edits: {0}")]
    Edits(#[from] EditsError),
    /// A file of muscles.
    #[error("muscles: {0}")]
    Muscles(#[from] MusclesError),
    /// A file of calibrated cameras.
    #[error("cameras: {0}")]
    Cameras(#[from] CamerasError),
    /// None of the kinds of file that can be read.
    #[error("`{name}` is none of the kinds of file that are read here: {readable}")]
    Unknown {
        /// Name of the file.
        name: String,
        /// What can be read.
        readable: &'static str,
    },
    /// What was read does not fit together.
    #[error("{0}")]
    Data(#[from] DataError),
}

/// Why a value could not be written in a format.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// What is written together does not fit.
    #[error("{0}")]
    Data(#[from] DataError),
    /// The rig cannot be posed.
    #[error("{0}")]
    Rig(#[from] RigError),
    /// The format has no room for a number this large (or small).
    #[error("{format}: {what} is {value}, the format holds {low} to {high}")]
    Range {
        /// The format.
        format: &'static str,
        /// What is out of range.
        what: String,
        /// Its value.
        value: f64,
        /// The smallest value the format holds.
        low: f64,
        /// The largest value the format holds.
        high: f64,
    },
    /// A name that the format cannot hold.
    #[error("{format}: the name `{name}` {problem}; rename it first")]
    Name {
        /// The format.
        format: &'static str,
        /// The name.
        name: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Two values that are written together do not fit.
    #[error("{format}: {what}: {found} where {expected} are needed")]
    Fit {
        /// The format.
        format: &'static str,
        /// What does not fit.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A value that is not a finite number.
    #[error("{format}: {what} in frame {frame} is {value}, not a finite number; mend the curve before it is saved")]
    NotFinite {
        /// The format.
        format: &'static str,
        /// What holds the value.
        what: String,
        /// Number of the frame.
        frame: i64,
        /// The value.
        value: f32,
    },
}
