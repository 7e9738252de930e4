//! The store on disk.

use super::{Action, Pack, PackWriter};
use serde::{Serialize, de::DeserializeOwned};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use wire::{Digest, ValueKind};

/// Why the store could not be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A folder or file of the store could not be written.
    #[error(
        "the store at {store} cannot be written ({problem}); make room or set another place with --store or GRIMACE_STORE"
    )]
    Write {
        /// The store.
        store: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
}

/// How much a store holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Statistics {
    /// Number of actions.
    pub actions: u64,
    /// Bytes of actions.
    pub action_bytes: u64,
    /// Number of packs.
    pub packs: u64,
    /// Bytes of packs.
    pub pack_bytes: u64,
    /// Number of saved states of cooks that were cut short.
    pub checkpoints: u64,
    /// Bytes of these states.
    pub checkpoint_bytes: u64,
}

/// A folder of actions, packs, checkpoints and sessions that many processes may share.
#[derive(Debug)]
pub struct Store {
    root: PathBuf,
}

/// Where files are made before they are renamed into place.
const TEMPORARY_FOLDER: &str = "temporary";

static TEMPORARY: AtomicU64 = AtomicU64::new(0);

impl Store {
    /// The store at `root`. Nothing is made there before something is written.
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    /// Makes sure that the store can be written, before anything is computed for it.
    ///
    /// # Errors
    /// Where its folder can be neither found nor made, or takes no files.
    pub fn prepare(&self) -> Result<(), StoreError> {
        let probe = self.temporary();
        let folder = self.root.join(TEMPORARY_FOLDER);
        let made =
            fs::create_dir_all(folder).and_then(|()| fs::write(&probe, [])).and_then(|()| fs::remove_file(probe));
        made.map_err(|problem| self.cannot_write(problem))
    }

    /// A place for a file in the making that no other writer uses.
    fn temporary(&self) -> PathBuf {
        let number = TEMPORARY.fetch_add(1, Ordering::Relaxed);
        self.root.join(TEMPORARY_FOLDER).join(format!("{}-{number}", std::process::id()))
    }

    /// The folder of the store.
    pub fn root(&self) -> &Path {
        &self.root
    }

    fn cannot_write(&self, problem: io::Error) -> StoreError {
        StoreError::Write { store: self.root.clone(), problem }
    }

    fn place(&self, part: &str, digest: &Digest) -> PathBuf {
        let hex = digest.hex();
        self.root.join(part).join(&hex[..2]).join(&hex[2..])
    }

    /// Writes `bytes` at `path` whole or not at all.
    fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        self.try_write(path, bytes).map_err(|problem| self.cannot_write(problem))
    }

    fn try_write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let temporary = self.temporary();
        let written = replace_file(&temporary, path, bytes);
        if written.is_err() {
            let _ = fs::remove_file(&temporary);
        }
        written
    }

    /// The action under `key`. A damaged one is dropped, and its computation will run again.
    pub fn action(&self, key: &Digest) -> Option<Action> {
        let path = self.place("actions", key);
        let bytes = fs::read(&path).ok()?;
        let action = unseal(&bytes);
        if action.is_none() {
            let _ = fs::remove_file(&path);
        }
        action
    }

    /// Writes the action under `key`.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn put_action(&self, key: &Digest, action: &Action) -> Result<(), StoreError> {
        self.write(&self.place("actions", key), &seal(action))
    }

    /// Whether there is a pack of the value `root`.
    pub fn has_pack(&self, root: &Digest) -> bool {
        self.place("packs", root).is_file()
    }

    /// The pack of the value `root`, its head verified against the root; `Err` says that it was damaged and is dropped.
    ///
    /// # Errors
    /// Where the pack is damaged.
    pub fn pack(&self, kind: &ValueKind, root: &Digest) -> Result<Option<Pack>, Digest> {
        let Ok(bytes) = fs::read(self.place("packs", root)) else { return Ok(None) };
        match Pack::open(bytes) {
            Some(pack) if super::ValueRecord::root(kind, &pack.digests()) == *root => Ok(Some(pack)),
            _ => {
                self.drop_pack(root);
                Err(*root)
            }
        }
    }

    /// Removes the pack of the value `root`, since it is damaged.
    pub fn drop_pack(&self, root: &Digest) {
        let _ = fs::remove_file(self.place("packs", root));
    }

    /// Writes the pack of the value `root`, where there is none yet.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn put_pack(&self, root: &Digest, pack: &PackWriter) -> Result<(), StoreError> {
        let path = self.place("packs", root);
        if path.is_file() { Ok(()) } else { self.write(&path, &pack.finish()) }
    }

    /// Reads the session called `name`; damaged bytes count as none.
    pub fn session<T: DeserializeOwned>(&self, name: &Digest) -> Option<T> {
        unseal(&fs::read(self.place("sessions", name)).ok()?)
    }

    /// Writes the session called `name`.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn put_session<T: Serialize>(&self, name: &Digest, session: &T) -> Result<(), StoreError> {
        self.write(&self.place("sessions", name), &seal(session))
    }

    /// The state `name` of the computation under `key`, where a cook was cut short in it.
    pub fn checkpoint(&self, key: &Digest, name: &str) -> Option<Vec<u8>> {
        unseal(&fs::read(self.checkpoint_place(key, name)).ok()?)
    }

    /// Saves the state `name` of the computation under `key`.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn put_checkpoint(&self, key: &Digest, name: &str, state: &[u8]) -> Result<(), StoreError> {
        self.write(&self.checkpoint_place(key, name), &seal(&state.to_vec()))
    }

    /// Forgets the states of the computation under `key`, since it is done.
    pub fn drop_checkpoints(&self, key: &Digest) {
        let _ = fs::remove_dir_all(self.root.join("checkpoints").join(key.hex()));
    }

    fn checkpoint_place(&self, key: &Digest, name: &str) -> PathBuf {
        self.root.join("checkpoints").join(key.hex()).join(Digest::of(name.as_bytes()).short())
    }

    /// Counts what the store holds.
    pub fn statistics(&self) -> Statistics {
        let (actions, action_bytes) = count(&self.root.join("actions"));
        let (packs, pack_bytes) = count(&self.root.join("packs"));
        let (checkpoints, checkpoint_bytes) = count(&self.root.join("checkpoints"));
        Statistics { actions, action_bytes, packs, pack_bytes, checkpoints, checkpoint_bytes }
    }
}

/// Writes `bytes` to `temporary`, syncs, and renames it to `path`, whose folder is made where needed.
fn replace_file(temporary: &Path, path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut file = fs::File::create(temporary)?;
    file.write_all(bytes)?;
    file.sync_data()?;
    fs::rename(temporary, path)
}

/// A record as bytes that prove themselves: its digest, then its encoding.
fn seal<T: Serialize>(record: &T) -> Vec<u8> {
    let encoding = postcard::to_stdvec(record).expect("records of plain data serialise into memory");
    let mut bytes = Digest::of(&encoding).0.to_vec();
    bytes.extend_from_slice(&encoding);
    bytes
}

fn unseal<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let (seal, encoding) = bytes.split_at_checked(32)?;
    if Digest::of(encoding).0 != seal {
        return None;
    }
    postcard::from_bytes(encoding).ok()
}

fn count(folder: &Path) -> (u64, u64) {
    let mut sums = (0, 0);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let Ok(meta) = entry.metadata() else { continue };
        let (files, bytes) = if meta.is_dir() { count(&entry.path()) } else { (1, meta.len()) };
        sums = (sums.0 + files, sums.1 + bytes);
    }
    sums
}
