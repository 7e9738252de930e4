//! The built-in nodes, one file a node, in folders in the order the data flows: load → clean → rig → solve →
//! strain → save.
//!
//! A program that cooks graphs names this crate (`use nodes as _;` is enough), since a node stands in the registry
//! of [`graph_core::node`] only where its crate is linked.

pub mod clean;
pub mod edits_text;
pub mod load;
mod patterns;
mod random;
pub mod rig;
pub mod save;
mod selection;
pub mod solve;
pub mod strain;
#[cfg(test)]
mod testing;
mod unit;
pub mod values;
