//! Graph files: from RON text to [`Graph`], with every part's place kept, and every mistake reported.
//!
//! [`Source::load`] gets the text, [`read`](read()) makes it a [`Graph`], a [`Scope`] fills in what its texts refer to
//! ([`resolve`]), and [`build_node`] holds a node's parameters against its kind and makes the node. Every step
//! gives [`Diagnostic`]s, which [`render`](render()) shows.

mod build;
mod diagnostic;
pub mod edit;
mod load;
mod model;
mod named_fields;
mod nearest;
mod read;
mod render;
mod ron;
#[cfg(test)]
mod sample;
mod scope;

pub(crate) use build::Schema;
pub use build::{build_node, canonical_parameters};
pub use diagnostic::{Diagnostic, Diagnostics};
pub use model::{Body, Entry, EntryInput, EntryParam, Graph, GraphInput, Literal, Place, Source, Span, Spanned};
pub use named_fields::{NamedField, named_fields};
pub use nearest::did_you_mean;
pub use read::read;
pub use render::{render, to_json};
pub use scope::{
    Environment, GivenParam, NodeParameters, Override, Resolved, Scope, ValuePlace, Written, apply_overrides,
    node_parameters, resolve, resolve_name,
};
