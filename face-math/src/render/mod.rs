//! A small software rasteriser, to look at faces: reports, contact sheets, tests that a head reads as a head.
//!
//! In order: [`Camera`] frames the head, [`render_rig`] shades its parts into an [`Image`](crate::data::Image),
//! [`draw_marks`] puts markers over it, [`Sheet`] lays pictures out with captions. Everything is deterministic:
//! the picture does not depend on the number of threads.

mod camera;
mod font;
mod lights;
mod marks;
mod normals;
mod occlusion;
mod raster;
mod shade;
mod sheet;

pub use camera::Camera;
pub use font::{GLYPH_HEIGHT_PX, GLYPH_WIDTH_PX, draw_text};
pub use marks::{Mark, MarkShape, draw_marks};
pub use normals::smooth_normals;
pub use shade::{Style, render_rig};
pub use sheet::Sheet;
