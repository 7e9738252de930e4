//! What calibrated cameras see, and what follows from it: between 2D markers tracked in footage and markers in space.
//!
//! - [`project`], [`ray_through`]: a point into a picture with its derivative, and a picture's point back to a ray.
//! - [`triangulate()`]: markers seen by several cameras, to points in space; a bad view does not bend them.
//! - [`cast_ray`], [`meetings`]: where a ray meets a surface, for markers that one camera sees (pupils; section 8 of FDLS).

mod cast;
mod lens;
mod point;
mod triangulate;

pub use cast::{Hit, cast_ray, meetings};
pub use lens::{Projected, Ray, project, ray_through};
pub use point::{Found, Sight, TriangulateOptions, Unfound, locate};
pub use triangulate::{TriangulateError, Triangulated, triangulate};
