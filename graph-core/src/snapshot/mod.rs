//! Snapshots: what a graph gave once, kept as text beside it, and held against what it gives now.
//!
//! [`Taken::after`] chooses outputs ([`chosen()`]) after a cook, reduces their values to statistics and samples
//! ([`reduce()`]), and notes what every cell before them was made of ([`Trace`]). [`Golden`] is the same as files;
//! [`compare()`] finds what differs by more than a [`tolerance`](wire::Tolerance) allows, and [`Trace::first`] where that
//! came from.

mod chosen;
mod compare;
mod golden;
mod reduce;
mod taken;
mod trace;
mod written;

pub use chosen::{Chosen, chosen};
pub use compare::{Agreement, Difference, Verdict, compare};
pub use golden::{Golden, GoldenError, HeldOutput, HeldTolerance, Hits};
pub use reduce::{Column, Reduced, ReducedTable, Statistics, reduce};
pub use taken::{Taken, TakenOutput};
pub use trace::{FirstDifference, Trace, TracedCell};
