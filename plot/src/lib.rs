//! Plots as SVG: lines in a frame with axes, and rasters of colours. Text in, text out; what nodes, snapshots and reports draw with.

mod lines;
mod raster;

pub use lines::{Ink, Line, Plot, draw};
pub use raster::{Raster, draw_rasters};

/// The text with what SVG and HTML read as their own replaced.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
