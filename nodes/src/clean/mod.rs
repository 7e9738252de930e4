//! Nodes that make takes fit for solving: after loading, before anything is solved.

mod fill_gaps;
mod smooth_markers;

pub use fill_gaps::FillGaps;
pub use smooth_markers::SmoothMarkers;
