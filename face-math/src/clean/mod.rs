//! Makes captured markers fit for solving, before anything is solved from them.
//!
//! - [`find_rigid`]: the markers that move with the skull alone.
//! - [`stabilize()`]: the head's motion out of a take.
//! - [`calm_motion()`]: a rigid motion without the shaking of the few markers that it was told from.
//! - [`learn_shapes`]: the shapes that a face's markers take.
//! - [`smoothed`]: curves calmed over time.
//! - [`fill_gaps`]: points that the cameras lost, from the frames around them, and from the markers beside them or those
//!   shapes.

mod bridge;
mod calm_motion;
mod gaps;
#[cfg(test)]
mod gaps_tests;
mod guide;
mod local_motion;
mod rigid_set;
mod shapes;
mod smoothing;
mod stabilize;
mod steady;

pub use calm_motion::{calm_motion, calm_reach, shrink_motion};
pub use gaps::{Filled, GapError, GapOptions, Source, fill_gaps};
pub use rigid_set::{RigidSet, RigidSetError, find_rigid};
pub use shapes::{ShapeError, learn_shapes};
pub use smoothing::{Smoothing, SmoothingError, kernel, smoothed};
pub use stabilize::{MOTION_CHANNELS, StabilizeError, StabilizeOptions, Stabilized, motion_of, stabilize};
