//! `grimace cache`: how much the store holds.

use crate::arguments::CacheStat;
use crate::exit::{Exit, Trouble};
use crate::words::size;
use crate::{graph, output};
use graph_core::store::{Statistics, Store};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// The counts as JSON.
#[derive(Serialize)]
struct Stat {
    store: String,
    #[serde(flatten)]
    statistics: Statistics,
}

/// Prints counts and sizes.
pub fn stat(arguments: &CacheStat) -> Result<Exit, Trouble> {
    let graph = arguments.graph.as_deref().map(graph::file);
    if let Some(graph) = graph.as_deref().filter(|graph| !graph.exists()) {
        let help = "name a graph file, or the store itself with --store";
        return Err(Trouble::command_line(format!("there is no graph {}", graph.display()), Some(help.into())));
    }
    let place = graph::store_place(&arguments.store, graph.as_deref().unwrap_or(Path::new("")));
    if !place.is_dir() {
        let help = "a cook makes one beside its graph; name another with --store, or the graph it belongs to";
        return Err(Trouble::command_line(format!("there is no store at {}", place.display()), Some(help.into())));
    }
    let statistics = Store::at(&place).statistics();
    if arguments.json {
        output::print_json(&Stat { store: place.display().to_string(), statistics })?;
    } else {
        output::print(&table(&place, &statistics))?;
    }
    Ok(Exit::Fine)
}

fn table(place: &Path, of: &Statistics) -> String {
    let rows = [
        ("results", of.actions, of.action_bytes, "what was computed, by key"),
        ("values", of.packs, of.pack_bytes, "the values themselves, by content"),
        ("checkpoints", of.checkpoints, of.checkpoint_bytes, "states of computations that were cut short"),
    ];
    let mut out = format!("{}\n", place.display());
    for (what, number, bytes, meaning) in rows {
        let _ = writeln!(out, "  {what:<12}{number:>8}  {:>10}  {meaning}", size(bytes));
    }
    let total = of.action_bytes + of.pack_bytes + of.checkpoint_bytes;
    out + &format!("  {:<12}{:>8}  {:>10}\n", "together", "", size(total))
}
