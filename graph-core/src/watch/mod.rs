//! Watching: what of the files that a graph depends on has arrived, and what is still being written.
//!
//! `scan` looks at the file system; `arrival` decides from one look after the other, with the time given to it, what came,
//! what went and what differs. Neither waits nor listens: that is for whoever owns a clock (`grimace watch`).

mod arrival;
mod scan;

pub use arrival::{Arrivals, Change, News, Renamed};
pub use scan::{Look, Wanted, look};
