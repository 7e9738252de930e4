//! Cooking: bringing every node of a plan up to date.
//!
//! [`Engine`] makes cells from the plan (`cell`, `unfold`; `refold` where a list has other items), pushes changes to those that depend on them (`push`, `edit`), asks of
//! each dirty one whether its key is known (`key`, `evaluate`), computes what is not: on the threads of a `crew` (`tasks`, `job`; `blocks`, `part` and `join` for cells that
//! work per frame), or `in_place` where the kind has shown itself to be cheap (`cost`). It takes in what comes back (`results`),
//! holds values in `slot`s, as many as `memory` allows, has results written to the store (`writer`) and the nodes' files (`publish`),
//! remembers everything for the next process (`session`) and for `why` (`reason`). What changes while a cook runs is taken in at
//! once (`live`, `carry`). [`cook()`] does all of it once, unless the graph is at `rest`. What was cooked is looked at through `look`.

mod artifact;
mod blocks;
mod carry;
mod cell;
mod cost;
mod crew;
mod edit;
mod engine;
mod evaluate;
mod event;
mod in_place;
mod job;
mod join;
mod key;
mod live;
mod look;
mod memory;
mod options;
mod part;
mod plain;
mod publish;
mod push;
mod reason;
mod refold;
mod rest;
mod results;
mod session;
mod shared;
mod slot;
mod stretch;
mod tasks;
mod turn;
mod unfold;
mod why;
mod writer;

pub use artifact::{Artifact, FILES};
pub use edit::EditError;
pub use engine::{Engine, Tell, cook, cook_and};
pub use event::{Event, Summary};
pub use live::{Change, Changes, Seen};
pub use look::{CellLook, LookError, NamedValue};
pub use options::{CookError, Options};
pub use rest::Rest;
pub use session::{Cause, CellRecord, NodeRecord, Session, session_name};
pub use why::story;

/// Frames in a block of a time-varying value, unless the options say otherwise.
pub const BLOCK_FRAMES: usize = 32;
