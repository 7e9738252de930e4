//! Cooking: bringing every node of a plan up to date.
//!
//! [`cook()`] makes cells from the plan (`cell`, `unfold`), asks for each whether its key is known (`key`, `evaluate`),
//! computes what is not on a pool of threads (`tasks`, `job`; `blocks` and `join` for cells that work per frame), takes in
//! what comes back (`results`), holds values in `slot`s, writes the nodes' files (`publish`), remembers everything for the
//! next cook (`session`) and for `why`.

mod artifact;
mod blocks;
mod cell;
mod evaluate;
mod event;
mod job;
mod join;
mod key;
mod kitchen;
mod publish;
mod results;
mod session;
mod slot;
mod tasks;
mod unfold;
mod why;

pub use artifact::{Artifact, FILES};
pub use event::{Event, Summary};
pub use kitchen::{CookError, Options, cook};
pub use session::{Cause, CellRecord, Session, session_name};
pub use why::story;

/// Frames in a block of a time-varying value, unless the options say otherwise.
pub const BLOCK_FRAMES: usize = 32;
