//! `grimace cache`: the care of the store.

mod collect;
mod pin;
mod stat;
mod verify;

use crate::arguments::{CacheCommand, CachePlace, Global, StoreArguments};
use crate::exit::{Exit, Trouble};
use crate::graph;
use graph_core::store::Store;
use std::path::{Path, PathBuf};

/// Does what was asked for.
pub fn cache(command: &CacheCommand, global: &Global) -> Result<Exit, Trouble> {
    match command {
        CacheCommand::Stat(arguments) => stat::stat(arguments),
        CacheCommand::Verify(arguments) => verify::verify(arguments),
        CacheCommand::Gc(arguments) => collect::collect(arguments, global),
        CacheCommand::Pin(arguments) => pin::pin(arguments),
        CacheCommand::Unpin(arguments) => pin::unpin(arguments),
    }
}

/// The store that is meant, which must be there.
fn store(place: &CachePlace) -> Result<Store, Trouble> {
    let graph = place.graph.as_deref().map(graph_file).transpose()?;
    existing(&place.store, graph.as_deref().unwrap_or(Path::new("")))
}

/// The graph file that `named` means, which must be there.
fn graph_file(named: &Path) -> Result<PathBuf, Trouble> {
    let graph = graph::file(named);
    if graph.exists() {
        return Ok(graph);
    }
    let help = "name a graph file, or the store itself with --store";
    Err(Trouble::command_line(format!("there is no graph {}", graph.display()), Some(help.into())))
}

fn existing(arguments: &StoreArguments, graph: &Path) -> Result<Store, Trouble> {
    let place = graph::store_place(arguments, graph);
    if !place.is_dir() {
        let help = "a cook makes one beside its graph; name another with --store, or the graph it belongs to";
        return Err(Trouble::command_line(format!("there is no store at {}", place.display()), Some(help.into())));
    }
    Ok(Store::at(&place))
}
