//! Leases: what a running cook leaves in the store for as long as it runs, so that nothing it needs is removed. A lease is
//! renewed while its process lives, and counts for nothing once the process is gone or the time is up.

use super::process::{Life, Process};
use super::{Store, StoreError};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use wire::Digest;

/// How long a lease holds after it was last renewed.
const LEASE: Duration = Duration::from_mins(15);

/// What a lease says, as JSON, for programs and people.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeaseRecord {
    /// The host on which the cook runs.
    pub host: String,
    /// The number of its process there.
    pub pid: u32,
    /// When it began, in milliseconds since 1970.
    pub since_ms: u64,
    /// Until when the lease holds, in milliseconds since 1970.
    pub until_ms: u64,
    /// The session that the cook works from.
    pub session: String,
}

impl LeaseRecord {
    /// The name of the session that the cook works from.
    pub fn session_name(&self) -> Option<Digest> {
        Digest::from_hex(&self.session)
    }

    /// When the cook began.
    pub fn since(&self) -> SystemTime {
        UNIX_EPOCH + Duration::from_millis(self.since_ms)
    }
}

/// A lease in the store. It ends when this value goes out of scope.
#[derive(Debug)]
pub struct Lease {
    path: PathBuf,
    over: Arc<(Mutex<bool>, Condvar)>,
    renewing: Option<JoinHandle<()>>,
}

static NUMBER: AtomicU64 = AtomicU64::new(0);

impl Store {
    /// Takes a lease for a cook that works from the session called `session`. What processes left behind that are gone is
    /// removed on the way.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn lease(&self, session: &Digest) -> Result<Lease, StoreError> {
        self.lease_for(session, LEASE)
    }

    fn lease_for(&self, session: &Digest, time: Duration) -> Result<Lease, StoreError> {
        self.sweep(false);
        let process = Process::this();
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = self.leases_folder().join(format!("{}~{number}", process.name()));
        let now = now_ms();
        let record = LeaseRecord {
            host: process.host.clone(),
            pid: process.pid,
            since_ms: now,
            until_ms: now + time.as_millis() as u64,
            session: session.hex(),
        };
        self.write_unsynced(&path, &json(&record))?;
        let over = Arc::new((Mutex::new(false), Condvar::new()));
        let renewing = self.renewing(path.clone(), record, time, Arc::clone(&over));
        Ok(Lease { path, over, renewing })
    }

    /// A thread that renews a lease until it is over. Should it not start, the lease holds for its first time only.
    fn renewing(
        &self,
        path: PathBuf,
        mut record: LeaseRecord,
        time: Duration,
        over: Arc<(Mutex<bool>, Condvar)>,
    ) -> Option<JoinHandle<()>> {
        let store = Self::at(self.root());
        let renew = move || {
            let (flag, ended) = &*over;
            let mut ending = flag.lock().unwrap_or_else(PoisonError::into_inner);
            while !*ending {
                let waited = ended.wait_timeout(ending, time / 3).unwrap_or_else(PoisonError::into_inner);
                ending = waited.0;
                if !*ending && waited.1.timed_out() {
                    record.until_ms = now_ms() + time.as_millis() as u64;
                    // A full disk may have room again next time; until then the lease holds as it stands.
                    let _ = store.write_unsynced(&path, &json(&record));
                }
            }
        };
        std::thread::Builder::new().name("lease".into()).spawn(renew).ok()
    }

    pub(super) fn leases_folder(&self) -> PathBuf {
        self.root().join("leases")
    }

    /// The leases of cooks that run, as far as can be told.
    pub fn leases(&self) -> Vec<LeaseRecord> {
        lease_files(&self.leases_folder())
            .into_iter()
            .filter(|(path, _, record)| holds(path, record))
            .map(|(.., record)| record)
            .collect()
    }

    /// Removes leases that count for nothing, and temporary files of processes that are gone; tells their paths and sizes.
    /// With `dry`, only tells.
    pub fn sweep(&self, dry: bool) -> Vec<(PathBuf, u64)> {
        let mut swept = Vec::new();
        for (path, bytes, record) in lease_files(&self.leases_folder()) {
            if !holds(&path, &record) {
                swept.push((path, bytes));
            }
        }
        for entry in fs::read_dir(self.temporary_folder()).into_iter().flatten().flatten() {
            let Ok(meta) = entry.metadata() else { continue };
            let life =
                Process::of_name(&entry.file_name().to_string_lossy()).map_or(Life::Unknown, |process| process.life());
            let old = meta.modified().ok().and_then(|time| time.elapsed().ok()).is_some_and(|age| age > ABANDONED);
            if meta.is_file() && (life == Life::Gone || life == Life::Unknown && old) {
                swept.push((entry.path(), meta.len()));
            }
        }
        if !dry {
            swept.retain(|(path, _)| fs::remove_file(path).is_ok());
        }
        swept
    }
}

/// Temporary files of processes that cannot be asked count as left behind once they are as old as this.
const ABANDONED: Duration = Duration::from_hours(24);

/// Whether the lease at `path` counts.
fn holds(path: &Path, record: &LeaseRecord) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let life = Process::of_name(&name).map_or(Life::Unknown, |process| process.life());
    life != Life::Gone && now_ms() < record.until_ms
}

/// All leases in a folder with their sizes. One that cannot be understood is taken for one that began with its file's last
/// change and names nothing, until its time is up.
fn lease_files(folder: &Path) -> Vec<(PathBuf, u64, LeaseRecord)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, Ok(meta)) = (entry.path(), entry.metadata()) else { continue };
        if !meta.is_file() {
            continue;
        }
        let record = fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        let record = record.unwrap_or_else(|| {
            let changed = meta.modified().unwrap_or(UNIX_EPOCH).duration_since(UNIX_EPOCH).unwrap_or_default();
            let since_ms = changed.as_millis() as u64;
            let until_ms = since_ms + LEASE.as_millis() as u64;
            LeaseRecord { host: String::new(), pid: 0, since_ms, until_ms, session: String::new() }
        });
        found.push((path, meta.len(), record));
    }
    found
}

fn json(record: &LeaseRecord) -> Vec<u8> {
    serde_json::to_vec(record).expect("plain data serialises into memory")
}

fn now_ms() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_millis() as u64)
}

impl Drop for Lease {
    fn drop(&mut self) {
        *self.over.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.over.1.notify_all();
        if let Some(renewing) = self.renewing.take() {
            let _ = renewing.join();
        }
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lease_is_renewed_while_it_is_held_and_gone_afterwards() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        let session = Digest::of(b"graph");
        let lease = store.lease_for(&session, Duration::from_millis(300)).unwrap();
        std::thread::sleep(Duration::from_secs(1));
        let held = store.leases();
        assert_eq!(held.len(), 1, "renewed three times over");
        assert_eq!((held[0].pid, held[0].session_name()), (std::process::id(), Some(session)));
        drop(lease);
        assert_eq!(store.leases(), []);
        assert_eq!(fs::read_dir(store.leases_folder()).unwrap().count(), 0);
    }

    #[test]
    fn what_the_dead_and_the_late_left_counts_for_nothing_and_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        store.prepare().unwrap();
        fs::create_dir_all(store.leases_folder()).unwrap();
        let lease = |name: &str, until_ms: u64| {
            let record = LeaseRecord { host: "h".into(), pid: 1, since_ms: 1, until_ms, session: String::new() };
            fs::write(store.leases_folder().join(name), json(&record)).unwrap();
        };
        let later = now_ms() + 60_000;
        lease("elsewhere~~7~7~0", now_ms() - 1);
        lease("elsewhere~~7~7~1", later);
        let this = Process::this().name();
        let (rest, start) = this.rsplit_once('~').unwrap();
        if cfg!(target_os = "linux") {
            lease(&format!("{rest}~{}~0", start.parse::<u64>().unwrap() + 1), later);
        }
        fs::write(store.leases_folder().join("unreadable"), "{").unwrap();
        assert_eq!(store.leases().len(), 2, "one elsewhere that holds, and one that says nothing yet");
        let temporary = store.temporary_folder().join("elsewhere~~7~7~3");
        fs::write(&temporary, "half").unwrap();
        fs::write(store.temporary_folder().join(format!("{this}~99")), "in the making").unwrap();
        store.sweep(true);
        assert_eq!(fs::read_dir(store.leases_folder()).unwrap().count(), if cfg!(target_os = "linux") { 4 } else { 3 });
        store.sweep(false);
        assert_eq!(fs::read_dir(store.leases_folder()).unwrap().count(), 2);
        let old = SystemTime::now() - ABANDONED - Duration::from_mins(1);
        assert_eq!(store.sweep(false), []);
        fs::File::options().write(true).open(&temporary).unwrap().set_modified(old).unwrap();
        assert_eq!(store.sweep(false).len(), 1, "a file in the making stays");
    }
}
