//! Makes captured markers fit for solving, before anything is solved from them.
//!
//! - [`find_rigid`]: the markers that move with the skull alone.
//! - [`stabilize`]: the head's motion out of a take.
//! - [`fill_gaps`]: points that the cameras lost, from the frames around them and from the markers beside them.

mod bridge;
mod gaps;
#[cfg(test)]
mod gaps_tests;
mod local_motion;
mod rigid_set;
mod stabilize;
mod steady;

pub use gaps::{Filled, GapError, GapOptions, fill_gaps};
pub use rigid_set::{RigidSet, RigidSetError, find_rigid};
pub use stabilize::{MOTION_CHANNELS, StabilizeError, Stabilized, motion_of, stabilize};
