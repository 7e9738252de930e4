//! Sessions: what the last cook of a graph knew, so that the next one asks only what changed, and can say why.

use crate::files::{Fingerprint, Signature};
use crate::store::{Action, Store};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
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

/// The name under which the session of the graph at `graph` is stored.
pub fn session_name(graph: &Path) -> Digest {
    let path = graph.canonicalize().unwrap_or_else(|_| graph.to_owned());
    Digest::of(path.as_os_str().as_encoded_bytes())
}

impl Session {
    /// The session of the graph at `graph`; an empty one where there is none.
    pub fn load(store: &Store, graph: &Path) -> Self {
        store.session(&session_name(graph)).unwrap_or_default()
    }
}

/// A digest cut to eight bytes: enough to see that a part differs.
pub(crate) fn short(digest: &Digest) -> u64 {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&digest.0[..8]);
    u64::from_le_bytes(bytes)
}
