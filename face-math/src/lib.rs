//! Faces as data, and the mathematics on them: pure, with units, knowing neither graphs nor files nor clocks.
//!
//! - [`data`]: markers, curves, rigs, attachments, regions, features, images: what flows on wires.
//! - [`rig`]: how a rig turns channel weights into points, the jaw's part of it, and marker attachment.
//! - [`clean`]: takes made fit for solving: gaps in markers filled.
//! - [`solve`]: features, salience, alignment and the bounded minimisers.
//! - [`strain`]: strain-driven faces: skinning, pose shapes, muscles, solvers.
//! - [`views`]: what calibrated cameras see, and markers in space from it.
//! - [`render`]: a small software rasteriser, to look at faces.
//!
//! Positions are metres, Y is up, the face looks along +Z, `_L`/`_R` are the performer's left and right,
//! rotations are radians, channel weights are unitless and normally 0 to 1.

pub mod clean;
pub mod data;
pub mod render;
pub mod rig;
pub mod solve;
pub mod strain;
pub mod views;
