//! The store on disk.

use super::damage::{Damage, Damages};
use super::process::Process;
use super::seal::{Unsealed, seal, unseal};
use super::{Action, Pack, StoreError};
use serde::{Serialize, de::DeserializeOwned};
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use wire::{Digest, ValueKind};

/// A folder of actions, packs, checkpoints and sessions that many processes may share.
#[derive(Debug)]
pub struct Store {
    root: PathBuf,
    damages: Damages,
}

/// Where files are made before they are renamed into place.
const TEMPORARY_FOLDER: &str = "temporary";

/// How much time may pass between two notes of a file's use. A cook that began when a file was noted this long ago may need
/// the file, although nothing shows it.
pub const USE_GRAIN: Duration = Duration::from_hours(1);

static TEMPORARY: AtomicU64 = AtomicU64::new(0);

impl Store {
    /// The store at `root`. Nothing is made there before something is written.
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_owned(), damages: Damages::default() }
    }

    /// Makes sure that the store can be written, before anything is computed for it.
    ///
    /// # Errors
    /// Where its folder can be neither found nor made, or takes no files.
    pub fn prepare(&self) -> Result<(), StoreError> {
        let probe = self.temporary();
        let made = fs::create_dir_all(self.temporary_folder())
            .and_then(|()| fs::write(&probe, []))
            .and_then(|()| fs::remove_file(&probe));
        made.map_err(|problem| self.cannot_write(&probe, problem))
    }

    pub(super) fn temporary_folder(&self) -> PathBuf {
        self.root.join(TEMPORARY_FOLDER)
    }

    /// A place for a file in the making that no other writer uses.
    fn temporary(&self) -> PathBuf {
        let number = TEMPORARY.fetch_add(1, Ordering::Relaxed);
        self.temporary_folder().join(format!("{}~{number}", Process::this().name()))
    }

    /// The folder of the store.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The files that were found damaged since this was last asked.
    pub fn take_damages(&self) -> Vec<Damage> {
        self.damages.take()
    }

    fn cannot_write(&self, file: &Path, problem: io::Error) -> StoreError {
        StoreError::Write { store: self.root.clone(), file: file.to_owned(), problem }
    }

    fn place(&self, part: &str, digest: &Digest) -> PathBuf {
        let hex = digest.hex();
        self.root.join(part).join(&hex[..2]).join(&hex[2..])
    }

    /// Writes `bytes` at `path` whole or not at all, and on the disk proper.
    fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        self.replace(path, bytes, true)
    }

    /// The same for what a loss of power may take away.
    pub(super) fn write_unsynced(&self, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        self.replace(path, bytes, false)
    }

    fn replace(&self, path: &Path, bytes: &[u8], sync: bool) -> Result<(), StoreError> {
        let temporary = self.temporary();
        let written = write_new(&temporary, bytes, sync).and_then(|()| rename_into(&temporary, path));
        written.map_err(|problem| {
            let _ = fs::remove_file(&temporary);
            self.cannot_write(path, problem)
        })
    }

    /// The bytes of the file at `path`; `None` where there is none. `lost` says what a file costs that is there and cannot
    /// be read.
    fn read(&self, path: &Path, lost: &str) -> Option<Vec<u8>> {
        match fs::read(path) {
            Ok(bytes) => Some(bytes),
            Err(problem) => {
                if !matches!(problem.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) {
                    self.damages.unreadable(path, &problem, lost);
                }
                None
            }
        }
    }

    /// The sealed record at `path`. A damaged one is noted and dropped; one of another version counts as none.
    fn record<T: DeserializeOwned>(&self, path: &Path, lost: &str) -> Option<T> {
        match unseal(&self.read(path, lost)?) {
            Unsealed::Sound(record) => Some(record),
            Unsealed::Other => None,
            Unsealed::Damaged => {
                self.damages.drop_file(path, lost);
                None
            }
        }
    }

    /// The action under `key`. A damaged one is noted and dropped, and its computation will run again.
    pub fn action(&self, key: &Digest) -> Option<Action> {
        let path = self.place("actions", key);
        let action = self.record(&path, "its computation runs again")?;
        note_use(&path);
        Some(action)
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
        note_use(&self.place("packs", root))
    }

    /// The pack of the value `root`, its head verified against the root; `Err` says that it was damaged and is dropped.
    ///
    /// # Errors
    /// Where the pack is damaged.
    pub fn pack(&self, kind: &ValueKind, root: &Digest) -> Result<Option<Pack>, Digest> {
        let path = self.place("packs", root);
        let Some(bytes) = self.read(&path, "its value is computed again") else { return Ok(None) };
        match Pack::open(bytes) {
            Some(pack) if pack.is_of(kind, root) => {
                note_use(&path);
                Ok(Some(pack))
            }
            _ => {
                self.drop_pack(root);
                Err(*root)
            }
        }
    }

    /// Notes that the pack of the value `root` is damaged, and removes it.
    pub fn drop_pack(&self, root: &Digest) {
        self.damages.drop_file(&self.place("packs", root), "its value is computed again");
    }

    /// Writes the pack of the value `root`, where there is none yet.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn put_pack(&self, root: &Digest, pack: &Pack) -> Result<(), StoreError> {
        let path = self.place("packs", root);
        if note_use(&path) { Ok(()) } else { self.write(&path, pack.bytes()) }
    }

    /// Where the session called `name` stands.
    pub(crate) fn session_place(&self, name: &Digest) -> PathBuf {
        self.place("sessions", name)
    }

    /// Reads the session called `name`. A damaged one is noted and dropped.
    pub fn session<T: DeserializeOwned>(&self, name: &Digest) -> Option<T> {
        self.record(&self.session_place(name), "what the last cook knew is found out anew")
    }

    /// The session called `name`, with nothing noted or dropped where it is damaged.
    pub(crate) fn peek_session<T: DeserializeOwned>(&self, name: &Digest) -> Option<T> {
        match unseal(&fs::read(self.session_place(name)).ok()?) {
            Unsealed::Sound(session) => Some(session),
            Unsealed::Other | Unsealed::Damaged => None,
        }
    }

    /// Writes the session called `name`.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn put_session<T: Serialize>(&self, name: &Digest, session: &T) -> Result<(), StoreError> {
        self.write(&self.session_place(name), &seal(session))
    }

    /// What the graph whose session is called `name` was when it came to rest. Reading it counts as a use of the session.
    pub(crate) fn rest<T: DeserializeOwned>(&self, name: &Digest) -> Option<T> {
        let rest = self.record(&self.place("rests", name), "its graph is read again")?;
        note_use(&self.session_place(name)).then_some(rest)
    }

    /// Writes what the graph whose session is called `name` is at rest.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub(crate) fn put_rest<T: Serialize>(&self, name: &Digest, rest: &T) -> Result<(), StoreError> {
        // Where a loss of power takes it, its graph is read again.
        self.write_unsynced(&self.place("rests", name), &seal(rest))
    }

    /// The record of the pin called `name`.
    pub(crate) fn pin<T: DeserializeOwned>(&self, name: &Digest) -> Option<T> {
        self.record(&self.place("pins", name), "its graph is pinned no more")
    }

    /// Writes the record of the pin called `name`.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub(crate) fn put_pin<T: Serialize>(&self, name: &Digest, pin: &T) -> Result<(), StoreError> {
        self.write(&self.place("pins", name), &seal(pin))
    }

    /// Removes the pin called `name`; whether there was one.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub(crate) fn drop_pin(&self, name: &Digest) -> Result<bool, StoreError> {
        let path = self.place("pins", name);
        match fs::remove_file(&path) {
            Ok(()) => Ok(true),
            Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(false),
            Err(problem) => Err(self.cannot_write(&path, problem)),
        }
    }

    /// The state `name` of the computation under `key`, where a cook was cut short in it.
    pub fn checkpoint(&self, key: &Digest, name: &str) -> Option<Vec<u8>> {
        let path = self.checkpoint_place(key, name);
        let state = self.record(&path, "its computation begins anew")?;
        note_use(&path);
        Some(state)
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
}

fn write_new(path: &Path, bytes: &[u8], sync: bool) -> io::Result<()> {
    let mut file = match fs::File::create(path) {
        Err(problem) if problem.kind() == ErrorKind::NotFound => {
            fs::create_dir_all(path.parent().unwrap_or(Path::new("")))?;
            fs::File::create(path)?
        }
        created => created?,
    };
    file.write_all(bytes)?;
    if sync { file.sync_data() } else { Ok(()) }
}

/// Renames a file into a folder that is made where needed; another process may remove it just then while it is empty.
fn rename_into(from: &Path, to: &Path) -> io::Result<()> {
    for _ in 0..8 {
        match fs::rename(from, to) {
            Err(problem) if problem.kind() == ErrorKind::NotFound => {
                fs::create_dir_all(to.parent().unwrap_or(Path::new("")))?;
            }
            done => return done,
        }
    }
    fs::rename(from, to)
}

/// Notes that the file at `path` is in use: its time of change is when it was last needed, to [`USE_GRAIN`]. Whether there
/// is such a file. Where the note cannot be made, the file only looks older than it is.
fn note_use(path: &Path) -> bool {
    let Ok(meta) = fs::metadata(path) else { return false };
    if meta.modified().ok().and_then(|time| time.elapsed().ok()).is_some_and(|age| age > USE_GRAIN) {
        touch(path);
    }
    meta.is_file()
}

#[cfg(unix)]
fn touch(path: &Path) {
    use rustix::fs::{AtFlags, CWD, Timespec, Timestamps, UTIME_NOW, UTIME_OMIT};
    let time = |tv_nsec| Timespec { tv_sec: 0, tv_nsec };
    // "Now" may be set by everyone who may write the file, another time by its owner alone.
    let times = Timestamps { last_access: time(UTIME_OMIT), last_modification: time(UTIME_NOW) };
    let _ = rustix::fs::utimensat(CWD, path, &times, AtFlags::empty());
}

#[cfg(not(unix))]
fn touch(path: &Path) {
    let opened = fs::File::options().append(true).open(path);
    let _ = opened.and_then(|file| file.set_modified(std::time::SystemTime::now()));
}
