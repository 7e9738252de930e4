//! `grimace cache stat`: how much the store holds.

use super::store;
use crate::arguments::CacheStat;
use crate::exit::{Exit, Trouble};
use crate::output;
use crate::words::{count, size};
use graph_core::care::{self, Pin, Statistics};
use graph_core::store::LeaseRecord;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// The counts as JSON.
#[derive(Serialize)]
struct Stat {
    store: String,
    #[serde(flatten)]
    statistics: Statistics,
    pinned: Vec<String>,
    running: Vec<LeaseRecord>,
}

/// Prints counts and sizes.
pub fn stat(arguments: &CacheStat) -> Result<Exit, Trouble> {
    let store = store(&arguments.place)?;
    let statistics = care::statistics(&store);
    let pinned = care::pins(&store).into_iter().map(|(_, Pin { graph, .. })| graph).collect();
    let stat = Stat { store: store.root().display().to_string(), statistics, pinned, running: store.leases() };
    if arguments.json {
        output::print_json(&stat)?;
    } else {
        output::print(&table(store.root(), &stat))?;
    }
    Ok(Exit::Fine)
}

fn table(place: &Path, stat: &Stat) -> String {
    let of = &stat.statistics;
    let rows = [
        ("results", of.actions, of.action_bytes, "what was computed, by key"),
        ("values", of.packs, of.pack_bytes, "the values themselves, by content"),
        ("sessions", of.sessions, of.session_bytes, "what the last cook of each graph knew"),
        ("checkpoints", of.checkpoints, of.checkpoint_bytes, "states of computations that were cut short"),
    ];
    let mut out = format!("{}\n", place.display());
    for (what, number, bytes, meaning) in rows {
        let _ = writeln!(out, "  {what:<12}{number:>8}  {:>10}  {meaning}", size(bytes));
    }
    let _ = writeln!(out, "  {:<12}{:>8}  {:>10}", "together", "", size(of.bytes()));
    for graph in &stat.pinned {
        let _ = writeln!(out, "  pinned: {graph}");
    }
    for lease in &stat.running {
        let _ = writeln!(out, "  a cook runs: process {} on {}", lease.pid, lease.host);
    }
    if of.leftovers > 0 {
        let files = count(of.leftovers as usize, "file");
        let _ = writeln!(out, "  {files}, {}, left behind by dead processes; gc removes them", size(of.leftover_bytes));
    }
    out
}
