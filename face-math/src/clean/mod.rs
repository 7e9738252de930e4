//! Makes captured markers fit for solving, before anything is solved from them.
//!
//! - [`fill_gaps`]: points that the cameras lost, from the frames around them and from the markers beside them.

mod bridge;
mod gaps;
#[cfg(test)]
mod gaps_tests;
mod local_motion;

pub use gaps::{Filled, GapError, GapOptions, fill_gaps};
