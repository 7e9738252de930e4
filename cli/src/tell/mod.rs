//! Telling how a cook goes: [`JsonLines`] for programs, [`People`] for people.
//!
//! Events come from all threads of a cook. For people they are kept on a `board`, which a thread of its own shows on a
//! `screen` (`bars` on a terminal, plain lines elsewhere), so that a cook never waits for a terminal. `failure` and
//! `ending` word what goes wrong and the last lines.

mod bars;
mod board;
mod ending;
mod failure;
mod json;
mod people;
mod screen;

pub use json::JsonLines;
pub use people::People;

/// How much people want to see.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wanted {
    /// Only what went wrong.
    pub quiet: bool,
    /// Why each cell is cooked, and which were up to date.
    pub verbose: bool,
    /// No bars, since other lines go to the same place.
    pub plain: bool,
}
