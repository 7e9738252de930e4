//! File formats to and from the data types of faces, nothing else.
//!
//! Readers take bytes and answer with a value in metres, hertz and weights, or with an error that names the place and
//! the cure; writers answer with bytes. No file is opened here: formats with companion files ask for them through
//! [`Sibling`]. One format a module:
//!
//! | module | what it reads and writes |
//! |---|---|
//! | [`markers`] | markers of every kind of file, told apart by content; TRC, Motive, Vicon and `OpenFace` themselves |
//! | [`c3d`] | markers, as motion capture systems write them |
//! | [`marker_csv`] | markers as tables |
//! | [`camera_json`] | calibrated cameras |
//! | [`view_csv`] | 2D markers that cameras saw, as tables |
//! | [`curves`] | animation curves as tables, plain or of Live Link Face |
//! | [`gltf`] | rigs with morph targets, and animated heads to look at |
//! | [`fbx`] | rigs of Maya, Blender and their like |
//! | [`obj`] | faces, and shapes as one file each |
//! | [`usda`] | animated heads for programs that read USD |
//! | [`muscles`] | which muscles a strain rig has |
//! | [`regions`] | which markers and channels belong together |
//! | [`edits`] | keys over solved curves, and anchor poses |
//! | [`mod@png`] | pictures |
//!
//! [`inspect()`] says what any of these files holds.

pub mod c3d;
pub mod camera_json;
mod csv;
pub mod curves;
pub mod edits;
mod error;
pub mod fbx;
pub mod gltf;
mod inspect;
pub mod marker_csv;
pub mod markers;
mod motion;
pub mod muscles;
pub mod obj;
pub mod png;
pub mod regions;
mod surface;
mod units;
pub mod usda;
pub mod view_csv;

pub use csv::{CsvError, csv_line};
pub use error::{ReadError, Sibling, WriteError, no_sibling};
pub use inspect::{Inspection, Stats, inspect};
pub use units::LengthUnit;
