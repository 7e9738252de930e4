//! Nodes that make takes fit for solving: after loading, before anything is solved.

mod fill_gaps;

pub use fill_gaps::FillGaps;
