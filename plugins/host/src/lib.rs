//! Nodes from outside: WebAssembly components that the engine runs as if they were its own nodes, confined and repeatable.
//!
//! The way of a plugin: `discover` finds folders with a `manifest` (`plugin.ron`), `lock` holds their digests against those
//! that were accepted, `component` refuses what imports more than the interface and compiles (`compiled` keeps the code),
//! `since_0_1` speaks the interface, `schema` is what a plugin says of its nodes, checked, `kind` makes engine kinds of it,
//! `node` computes with them inside the limits of `run`, and `catalogue` hands all of that to the engine.
//!
//! For authors: `build` makes components from sources, `trial` tries a plugin out.

pub mod build;
mod catalogue;
mod compiled;
mod component;
mod digests;
mod discover;
mod engine;
mod fault;
#[allow(unsafe_code, reason = "the two places that need it, with their proofs")]
mod kernel;
mod kind;
mod lock;
mod manifest;
mod node;
mod run;
mod schema;
mod since_0_1;
pub mod trial;
mod values;

pub use catalogue::{Bringing, PluginKinds};
pub use component::{Facts, Plugin};
pub use digests::sha256;
pub use discover::{Found, Place, Places};
pub use fault::{LoadError, RunError};
pub use lock::{Lock, LockError, Pin};
pub use manifest::{Limits, Manifest, ManifestError};
pub use schema::{NodeSchema, ParameterSchema, PortSchema, SchemaError, Setting, TimeUse};
pub use values::{Blob, FrameTensor, Number, Numbers, Tensor, Text};

/// Versions of the interface that this program speaks, the newest last.
pub const INTERFACES: [&str; 1] = ["0.1"];

graph_core::submit_bringer!(Bringing);
