//! Fingerprints: a file is known by the digest of its content; its metadata only saves reading it again.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};
use wire::Digest;

/// What the file system says of a file. Equal signatures mean equal content, unless the file was written within the
/// clock's grain of the moment at which it was read (see [`Fingerprint::trusted`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Signature {
    /// Size in bytes.
    pub size: u64,
    /// Time of last change of the content, in nanoseconds since 1970.
    pub modified_ns: i128,
    /// Time of last change of content or metadata, in nanoseconds since 1970; 0 where the system has none.
    pub changed_ns: i128,
    /// Number of the file in its file system; 0 where the system has none.
    pub inode: u64,
}

/// How coarse a clock a file system may keep, in nanoseconds: the coarsest in use is FAT's two seconds.
const CLOCK_GRAIN_NS: i128 = 2_000_000_000;

impl Signature {
    /// The signature of the file at `path`, links followed.
    ///
    /// # Errors
    /// Where the file is not there or cannot be asked.
    pub fn of(path: &Path) -> io::Result<Self> {
        let meta = std::fs::metadata(path)?;
        if meta.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a folder, where a file is needed"));
        }
        let modified_ns = meta.modified().map_or(0, since_1970_ns);
        #[cfg(unix)]
        let (changed_ns, inode) = {
            use std::os::unix::fs::MetadataExt;
            (i128::from(meta.ctime()) * 1_000_000_000 + i128::from(meta.ctime_nsec()), meta.ino())
        };
        #[cfg(not(unix))]
        let (changed_ns, inode) = (0, 0);
        Ok(Self { size: meta.len(), modified_ns, changed_ns, inode })
    }
}

fn since_1970_ns(time: SystemTime) -> i128 {
    match time.duration_since(UNIX_EPOCH) {
        Ok(after) => after.as_nanos() as i128,
        Err(before) => -(before.duration().as_nanos() as i128),
    }
}

/// A file's content digest, and what the file looked like when it was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint {
    /// Digest of the content.
    pub digest: Digest,
    /// The signature before reading.
    pub signature: Signature,
    /// When it was read, in nanoseconds since 1970.
    pub read_ns: i128,
}

impl Fingerprint {
    /// Whether an unchanged signature proves an unchanged content: only where the file was already older than the
    /// clock's grain when it was read. Else a second edit could hide behind the same time stamp.
    pub fn trusted(&self) -> bool {
        let newest = self.signature.modified_ns.max(self.signature.changed_ns);
        self.read_ns - newest > CLOCK_GRAIN_NS
    }

    /// Whether the file at `path` is surely unchanged since, by one look at its metadata.
    pub fn still_true(&self, path: &Path) -> bool {
        self.trusted() && Signature::of(path).is_ok_and(|now| now == self.signature)
    }
}

/// Content that stands in the place of a file's, with its digest.
type Held = (Arc<Vec<u8>>, Digest);

/// Fingerprints of all files met so far, so that none is read twice without need.
#[derive(Debug, Default)]
pub struct Fingerprints {
    known: Mutex<BTreeMap<PathBuf, Fingerprint>>,
    /// Files that are being edited and are not saved yet. Nothing of them is noted: a fingerprint is of what is on disk.
    held: Mutex<BTreeMap<PathBuf, Held>>,
}

impl Fingerprints {
    /// Starts from fingerprints of an earlier cook.
    pub fn new(known: BTreeMap<PathBuf, Fingerprint>) -> Self {
        Self { known: Mutex::new(known), held: Mutex::default() }
    }

    /// Has exactly these files count as holding this content, whatever is on disk.
    pub fn hold(&self, contents: &BTreeMap<PathBuf, String>) {
        let held = contents.iter().map(|(path, text)| {
            let bytes = Arc::new(text.clone().into_bytes());
            let digest = Digest::of(&bytes);
            (path.clone(), (bytes, digest))
        });
        *self.held.lock().unwrap_or_else(PoisonError::into_inner) = held.collect();
    }

    fn held(&self, path: &Path) -> Option<Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned()
    }

    /// The digest of the file's content; the file is read only where its signature does not prove it unchanged.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn digest(&self, path: &Path) -> io::Result<Digest> {
        if let Some((_, digest)) = self.held(path) {
            return Ok(digest);
        }
        let now = Signature::of(path)?;
        let known = self.lock().get(path).copied();
        if let Some(known) = known.filter(|known| known.signature == now && known.trusted()) {
            return Ok(known.digest);
        }
        self.read(path).map(|(_, digest)| digest)
    }

    /// Reads the file, and notes its fingerprint.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn read(&self, path: &Path) -> io::Result<(Arc<Vec<u8>>, Digest)> {
        if let Some(held) = self.held(path) {
            return Ok(held);
        }
        let signature = Signature::of(path)?;
        let read_ns = since_1970_ns(SystemTime::now());
        let bytes = std::fs::read(path)?;
        let digest = Digest::of(&bytes);
        self.lock().insert(path.to_owned(), Fingerprint { digest, signature, read_ns });
        Ok((Arc::new(bytes), digest))
    }

    /// The fingerprint noted for `path`; none while other content stands in its place.
    pub fn get(&self, path: &Path) -> Option<Fingerprint> {
        if self.held(path).is_some() {
            return None;
        }
        self.lock().get(path).copied()
    }

    /// The digest that the content at `path` had when it was last read.
    pub fn last_digest(&self, path: &Path) -> Option<Digest> {
        self.held(path).map(|(_, digest)| digest).or_else(|| Some(self.get(path)?.digest))
    }

    /// All fingerprints noted so far.
    pub fn all(&self) -> BTreeMap<PathBuf, Fingerprint> {
        self.lock().clone()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<PathBuf, Fingerprint>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_same_second_same_size_edit_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("take.c3d");
        let files = Fingerprints::default();
        let mut digests = Vec::new();
        for content in ["aaaa", "bbbb", "cccc"] {
            std::fs::write(&path, content).unwrap();
            digests.push(files.digest(&path).unwrap());
        }
        assert_ne!(digests[0], digests[1]);
        assert_ne!(digests[1], digests[2]);
    }

    #[test]
    fn content_that_is_held_counts_and_is_not_noted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("edits.ron");
        std::fs::write(&path, "on disk").unwrap();
        let files = Fingerprints::default();
        let on_disk = files.digest(&path).unwrap();
        let noted = files.all();
        files.hold(&BTreeMap::from([(path.clone(), "on screen".to_owned())]));
        assert_eq!(files.digest(&path).unwrap(), Digest::of(b"on screen"));
        assert_eq!(*files.read(&path).unwrap().0, b"on screen");
        assert_eq!((files.get(&path), files.all()), (None, noted));
        files.hold(&BTreeMap::new());
        assert_eq!(files.digest(&path).unwrap(), on_disk);
    }

    #[test]
    fn an_old_file_is_read_once_and_a_touched_equal_one_has_the_same_digest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("take.c3d");
        std::fs::write(&path, "markers").unwrap();
        let old = SystemTime::now() - std::time::Duration::from_hours(1);
        let touch = |time| std::fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        touch(old);
        let files = Fingerprints::default();
        let before = files.digest(&path).unwrap();
        touch(old + std::time::Duration::from_mins(1));
        assert_eq!(files.digest(&path).unwrap(), before);
    }
}
