//! `grimace snapshot`: takes what a graph gives, and holds it against what was accepted.
//!
//! Both commands cook in a session of their own, write none of the graph's files, and cook a second time to see what the store gives back.

mod accept;
mod check;
mod cooked;
mod differing;
mod plots;

use crate::arguments::{Global, SnapshotCommand};
use crate::exit::{Exit, Trouble};

/// Does what was asked for.
pub fn snapshot(command: &SnapshotCommand, global: &Global) -> Result<Exit, Trouble> {
    match command {
        SnapshotCommand::Accept(of) => accept::accept(of, global),
        SnapshotCommand::Check(of) => check::check(of, global),
    }
}
