//! The engine of grimace: values, ports, nodes, documents, plans, cooking, the store, why.
//!
//! It knows neither faces nor terminals nor networks. The way of a graph through the crate:
//! [`document`] reads the RON text, [`plan`] flattens nested graphs into a wired plan and checks it,
//! [`cook`] brings every node up to date through [`store`] and [`files`], and what a cook did is kept for `why`; [`watch`] tells
//! what of the files has arrived. [`snapshot`] holds what was cooked against what it was.

pub mod care;
pub mod cook;
pub mod document;
pub mod files;
pub mod node;
pub mod plan;
pub mod snapshot;
pub mod store;
pub mod watch;

#[doc(hidden)]
pub use inventory;
pub use wire;
