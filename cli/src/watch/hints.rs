//! Hints: what the system tells of folders, and where it does not tell, so that one has to look again and again.

use super::Wake;
use notify::event::{EventKind, ModifyKind, RenameMode};
use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::mpsc::Sender;

/// A reason to look.
#[derive(Debug, Default)]
pub struct Hint {
    /// Files that were renamed into place, by their absolute paths.
    pub renamed: BTreeSet<PathBuf>,
    /// Why everything has to be looked at, where the system lost count.
    pub lost: Option<String>,
}

/// A folder that is followed, and the file system's number of it: one that goes and comes again has another.
type Followed = (bool, Option<(u64, u64)>);

/// The folders that are listened to.
#[derive(Debug)]
pub struct Hints {
    watcher: Option<RecommendedWatcher>,
    followed: BTreeMap<PathBuf, Followed>,
    /// Whether files have to be looked at without being told.
    pub polling: bool,
    forced: bool,
}

impl Hints {
    /// Hints that are sent to `wake`; none where files are `polled`.
    pub fn new(wake: Sender<Wake>, polled: bool) -> Self {
        let take = move |told: notify::Result<Event>| {
            if let Some(hint) = hint(told) {
                // Nobody listens any more where the watch is over.
                let _ = wake.send(Wake::Hint(hint));
            }
        };
        let watcher = if polled { None } else { notify::recommended_watcher(take).ok() };
        let forced = watcher.is_none();
        Self { watcher, followed: BTreeMap::new(), polling: forced, forced }
    }

    /// Follows exactly `folders`, each with the folders in it where that is said. Whether a folder is followed that was not.
    pub fn follow(&mut self, folders: &BTreeMap<PathBuf, bool>) -> bool {
        let Some(watcher) = &mut self.watcher else { return false };
        let (mut polling, mut anew) = (self.forced, false);
        let wanted: BTreeMap<PathBuf, bool> = folders
            .iter()
            .map(|(folder, deep)| (std::path::absolute(folder).unwrap_or_else(|_| folder.clone()), *deep))
            .collect();
        self.followed.retain(|folder, (deep, number)| {
            let stays = wanted.get(folder) == Some(deep) && *number == number_of(folder);
            if !stays {
                // A folder that is gone is no longer followed anyway.
                let _ = watcher.unwatch(folder);
            }
            stays
        });
        for (folder, deep) in wanted {
            polling |= is_remote(&folder);
            if self.followed.contains_key(&folder) {
                continue;
            }
            let mode = if deep { RecursiveMode::Recursive } else { RecursiveMode::NonRecursive };
            let number = number_of(&folder);
            match watcher.watch(&folder, mode) {
                Ok(()) => {
                    anew = true;
                    self.followed.insert(folder, (deep, number));
                }
                // Out of watches, or not supported there.
                Err(_) => polling = true,
            }
        }
        self.polling = polling;
        anew
    }
}

fn hint(told: notify::Result<Event>) -> Option<Hint> {
    let event = match told {
        Ok(event) => event,
        Err(problem) => return Some(Hint { lost: Some(problem.to_string()), ..Hint::default() }),
    };
    if event.need_rescan() {
        return Some(Hint { lost: Some("the system lost count of changes".to_owned()), ..Hint::default() });
    }
    match event.kind {
        EventKind::Access(access) if !matches!(access, notify::event::AccessKind::Close(_)) => None,
        EventKind::Modify(ModifyKind::Name(RenameMode::To | RenameMode::Both)) => {
            Some(Hint { renamed: event.paths.last().cloned().into_iter().collect(), lost: None })
        }
        _ => Some(Hint::default()),
    }
}

#[cfg(unix)]
fn number_of(folder: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    std::fs::metadata(folder).ok().map(|meta| (meta.dev(), meta.ino()))
}

#[cfg(not(unix))]
fn number_of(_: &Path) -> Option<(u64, u64)> {
    None
}

/// Whether `folder` lies on a disk whose changes others make unseen: NFS, SMB, CIFS, FUSE, 9P, AFS, Ceph, Lustre, GPFS, `BeeGFS`,
/// or a folder of a virtual machine's host. The numbers are those of `linux/magic.h` and of the file systems' own sources.
#[cfg(target_os = "linux")]
fn is_remote(folder: &Path) -> bool {
    const REMOTE: [u32; 13] = [
        0x6969,
        0x517B,
        0xFF53_4D42,
        0xFE53_4D42,
        0x6573_5546,
        0x0102_1997,
        0x5346_414F,
        0x00C3_6400,
        0x0BD0_0BD0,
        0x4750_4653,
        0x1983_0326,
        0x786F_4256,
        0x7375_7245,
    ];
    rustix::fs::statfs(folder).is_ok_and(|facts| REMOTE.contains(&(facts.f_type as u32)))
}

#[cfg(not(target_os = "linux"))]
fn is_remote(_: &Path) -> bool {
    false
}
