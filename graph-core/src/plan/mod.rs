//! Plans: graph files flattened into one list of wired nodes, checked, in an order in which they can be cooked.
//!
//! [`load`](load()) reads the graph and every file nested in it (`read`), resolves every wire through the nesting
//! (`resolve`), finds over which lists each node repeats (`scope`), and checks the types (`check`).

mod check;
mod dot;
mod load;
mod model;
mod resolve;
mod scope;

pub(crate) use check::{Made, make};
pub use dot::dot;
pub use load::{load, load_texts, tidy};
pub use model::{Origin, OriginId, Plan, PlanInput, PlanNode, PlanSource, Template};
