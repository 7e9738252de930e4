//! How a rig turns channel weights into points: between the data types and every node that poses a head.
//!
//! Read in this order:
//!
//! - [`shape_drivers`]: what names of shapes mean.
//! - [`join_shapes()`]: rigs of one neutral face, each with some of the shapes, as one.
//! - [`keep_parts()`]: some parts of a rig as a rig of their own.
//! - [`ShapeDrivers`]: channel weights to shape weights (combinations, in-betweens).
//! - [`JawPose`]: where the jaw stands at given shape weights.
//! - [`Puppet`]: all vertices of a head at given weights.
//! - [`MarkerRig`]: the few points that carry markers, with derivatives: what solvers work on.
//! - [`attach_markers`]: neutral markers onto the neutral surface.
//! - [`snap_to_vertices`]: markers of a mask that was laid out on the mesh, onto their vertices.
//! - [`fit_rigid`]: the best rotation and translation between two sets of points.
//! - [`register()`]: where a capture lies on a rig, when the two do not share a space.
//! - [`skin_jaw()`]: splits the jaw's motion off a rig whose shapes hold the whole deformation.

mod attach;
mod closest;
mod corners;
mod drivers;
mod error;
mod jaw;
mod jaw_split;
mod join_shapes;
mod keep_parts;
mod limbs;
mod marker_rig;
mod puppet;
mod register;
mod rigid;
mod shape_names;
mod skin_jaw;
mod snap;
#[cfg(test)]
pub(crate) mod toy;

pub use attach::{AttachOptions, Attached, FarMarker, attach_markers};
pub use closest::{ClosestPoint, closest_on_triangle};
pub use drivers::ShapeDrivers;
pub use error::RigError;
pub use jaw::JawPose;
pub use join_shapes::{JoinShapesError, Sculpts, join_shapes};
pub use keep_parts::{keep_parts, keep_points, renumbered};
pub use marker_rig::{MarkerPose, MarkerRig};
pub use puppet::Puppet;
pub use register::{Registered, register};
pub use rigid::{Rigid, RigidError, RigidFit, fit_rigid};
pub use shape_names::{ShapeNameError, shape_drivers};
pub use skin_jaw::{JawFit, SkinJawOptions, SkinnedJaw, skin_jaw};
pub use snap::{SNAP_M, Snapped, snap_to_vertices};
