//! Sessions: what the last cook of a graph knew, so that the next one asks only what changed, and can say why.

use super::cell::{Cell, CellId, State};
use super::engine::Engine;
use crate::files::{Fingerprint, Signature};
use crate::store::{Action, Store};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use wire::Digest;

/// The state of a graph after a cook.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Session {
    /// Number of the cook, counted from 1.
    pub run: u64,
    /// When that cook ended, in seconds since 1970.
    pub time_s: u64,
    /// Fingerprints of the source files.
    pub files: BTreeMap<PathBuf, Fingerprint>,
    /// Published files: what they looked like when they were written, and the digest of the artifact.
    pub published: BTreeMap<PathBuf, (Signature, Digest)>,
    /// The cells.
    pub cells: BTreeMap<String, CellRecord>,
    /// The nodes of the graph, by their path.
    pub nodes: BTreeMap<String, NodeRecord>,
}

/// What is remembered of a node, to say in words what became of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct NodeRecord {
    /// Its kind and its version.
    pub kind: String,
    /// Parameters whose values are not the kind's defaults, as short texts.
    pub values: BTreeMap<String, String>,
    /// What each input is connected to.
    pub inputs: BTreeMap<String, Vec<String>>,
    /// The items that gathering inputs show, where they are few.
    pub items: BTreeMap<String, Vec<String>>,
}

/// What is remembered of a cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellRecord {
    /// The key under which it was cooked.
    pub key: Digest,
    /// What the key was made of: a short digest of each part, by label.
    pub parts: Vec<(String, u64)>,
    /// Its outputs.
    pub action: Action,
    /// Keys of its blocks of frames.
    pub block_keys: Vec<Digest>,
    /// Keys of its blocks over exactly the frames that each sees, for a cell with a halo.
    pub frame_keys: Vec<Digest>,
    /// The cook in which it was last computed, and why.
    pub cooked: Option<(u64, Cause)>,
}

/// Why a cell was computed, as the engine keeps it: without words, which only few cells ever need.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Reason {
    /// It was never computed before.
    New,
    /// Its key is as it was, but the store no longer holds its result.
    Forgotten,
    /// A part of its key that was not there before.
    Added(String),
    /// A part of its key that is no longer there.
    Removed(String),
    /// A part of its key that differs.
    Changed(String),
    /// Its input at this position differs, since the producer gave another result; none where only the connection differs.
    Input(usize, Option<CellId>),
    /// As it was told when it was found, or by an earlier process.
    Told(Box<Cause>),
}

impl Reason {
    pub fn told(cause: Cause) -> Self {
        Self::Told(Box::new(cause))
    }
}

/// Why a cell was computed: the first part of its key that differed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    /// What differed, for people.
    pub text: String,
    /// The line, file or kind at which the difference entered, where it entered here.
    pub place: Option<String>,
    /// The cell whose changed result made the difference.
    pub upstream: Option<String>,
}

/// The name under which the session of the graph at `graph` is in `store`. A graph beside its store is known by its file's
/// name alone, so that a project that is copied with its store goes on where it was.
pub fn session_name(store: &Store, graph: &Path) -> Digest {
    let path = graph.canonicalize().unwrap_or_else(|_| graph.to_owned());
    // The store itself may not be there yet, the folder that it will stand in is.
    let beside = store.root().parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match path.file_name() {
        Some(name) if beside.canonicalize().ok().as_deref() == path.parent() => Digest::of(name.as_encoded_bytes()),
        _ => Digest::of(path.as_os_str().as_encoded_bytes()),
    }
}

impl Session {
    /// The session of the graph at `graph`; an empty one where there is none.
    pub fn load(store: &Store, graph: &Path) -> Self {
        store.session(&session_name(store, graph)).unwrap_or_default()
    }
}

impl Engine {
    /// Everything that is known now, with what earlier cooks knew of cells that this one did not touch.
    pub(super) fn knowledge(&mut self) -> Session {
        let paths: BTreeSet<&str> = self.plan.nodes.iter().map(|node| node.path.as_str()).collect();
        let sound = |cell: &&Cell| !matches!(cell.state, State::Failed(_) | State::Waiting | State::Unknown);
        let unfolded: BTreeSet<&str> =
            self.cells.iter().filter(sound).map(|cell| self.plan.nodes[cell.plan].path.as_str()).collect();
        // Records of cells that were not made, or not finished, this time.
        let mut cells = std::mem::take(&mut self.session.cells);
        cells.retain(|name, _| {
            let path = name.split_once('@').map_or(name.as_str(), |(path, _)| path);
            paths.contains(path) && !unfolded.contains(path)
        });
        for (id, cell) in self.cells.iter().enumerate() {
            match (&cell.state, &cell.before) {
                (State::Done(_), _) => drop(cells.insert(cell.name.clone(), self.record(id))),
                (_, Some(before)) => drop(cells.insert(cell.name.clone(), CellRecord::clone(before))),
                _ => {}
            }
        }
        Session {
            run: self.session.run,
            time_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            files: self.shared.files.all(),
            published: self.published.clone(),
            cells,
            nodes: self.node_records(),
        }
    }

    fn record(&self, id: CellId) -> CellRecord {
        let cell = &self.cells[id];
        let settings = cell.made_settings().into_iter().flat_map(|settings| &settings.parts);
        let mut parts: Vec<_> = settings.map(|part| (part.label.clone(), short(&part.digest))).collect();
        parts.extend(cell.made.file.iter().map(|file| ("file".to_owned(), short(file))));
        parts.extend(cell.links.iter().zip(&cell.made.inputs).map(|(link, digest)| (link.label(), short(digest))));
        CellRecord {
            key: cell.key(),
            parts,
            action: cell.action(),
            block_keys: cell.made.block_keys.clone(),
            frame_keys: cell.made.frame_keys.clone(),
            cooked: cell.cooked.as_ref().map(|(run, reason)| (*run, self.cause(id, reason))),
        }
    }
}

/// A digest cut to eight bytes: enough to see that a part differs.
pub(crate) fn short(digest: &Digest) -> u64 {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&digest.0[..8]);
    u64::from_le_bytes(bytes)
}
