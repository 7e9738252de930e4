//! Pins: graphs whose results stay in the store however long they are not needed.

use crate::cook::{Session, session_name};
use crate::store::{Part, Store, StoreError};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};
use wire::Digest;

/// A pinned graph.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pin {
    /// The graph's file, as an absolute path.
    pub graph: String,
    /// When it was pinned, in seconds since 1970.
    pub since_s: u64,
}

/// Pins the graph at `graph`: everything that its session names stays, that of later cooks too.
///
/// # Errors
/// Where the graph was never cooked with this store, or the store cannot be written.
pub fn pin(store: &Store, graph: &Path) -> Result<Pin, StoreError> {
    let name = session_name(store, graph);
    if store.peek_session::<Session>(&name).is_none() {
        return Err(StoreError::NeverCooked { graph: graph.to_owned(), store: store.root().to_owned() });
    }
    let absolute = graph.canonicalize().unwrap_or_else(|_| graph.to_owned());
    let since_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let pin = Pin { graph: absolute.display().to_string(), since_s };
    store.put_pin(&name, &pin)?;
    Ok(pin)
}

/// Takes the pin of the graph at `graph` away, which may be gone; whether it was pinned.
///
/// # Errors
/// Where the store cannot be written.
pub fn unpin(store: &Store, graph: &Path) -> Result<bool, StoreError> {
    if store.drop_pin(&session_name(store, graph))? {
        return Ok(true);
    }
    let absolute = std::path::absolute(graph).unwrap_or_else(|_| graph.to_owned());
    let pinned = pins(store).into_iter().find(|(_, pin)| Path::new(&pin.graph) == absolute);
    pinned.map_or(Ok(false), |(name, _)| store.drop_pin(&name))
}

/// All pinned graphs, with the names of their sessions.
pub fn pins(store: &Store) -> Vec<(Digest, Pin)> {
    let entries = store.inventory().entries.into_iter().filter(|entry| entry.part == Part::Pin);
    entries.filter_map(|entry| Some((entry.name, store.pin(&entry.name)?))).collect()
}
