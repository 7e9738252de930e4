//! Collecting garbage: removes what was least recently needed, until the rest fits.
//!
//! When a file was last needed: the time of its last change, which is set anew where it is used (to within an hour, see
//! [`USE_GRAIN`]), or the end of the last cook whose session names it, whichever is later. Cooks that find everything as it
//! was read their session and nothing else, so a note for each file would cost them more than the whole cook; the session
//! is that note.

use super::needs::{Needed, Needs};
use super::pin::pins;
use crate::store::{Entry, Part, Store, StoreError, USE_GRAIN};
use serde::Serialize;
use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

/// A file that went, or would go.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Removed {
    /// The part of the store.
    pub part: Part,
    /// The file.
    pub file: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// When it was last needed.
    #[serde(skip)]
    pub last_needed: SystemTime,
}

/// What had to stay although it was old enough to go.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Spared {
    /// Files that pinned graphs need.
    pub pinned: u64,
    /// Bytes of these.
    pub pinned_bytes: u64,
    /// Files that running cooks need, or may need.
    pub running: u64,
    /// Bytes of these.
    pub running_bytes: u64,
}

/// What collecting did, or would do.
#[derive(Debug, Default)]
pub struct Collected {
    /// Bytes before.
    pub before_bytes: u64,
    /// Bytes afterwards.
    pub after_bytes: u64,
    /// What went, in the order in which it was last needed.
    pub removed: Vec<Removed>,
    /// Leases and temporary files of dead processes that went.
    pub swept: Vec<(PathBuf, u64)>,
    /// What had to stay.
    pub spared: Spared,
    /// Files that could not be removed, and why.
    pub refused: Vec<(PathBuf, String)>,
}

/// Removes from `store` what was least recently needed until no more than `keep_bytes` remain; with `dry`, only says what
/// would go. What a running cook or a pinned graph needs stays in any case.
///
/// # Errors
/// Where it cannot be told what a pinned graph needs; nothing is removed then.
pub fn collect(store: &Store, keep_bytes: u64, dry: bool) -> Result<Collected, StoreError> {
    let swept = store.sweep(dry);
    let entries: Vec<Entry> = store.inventory().entries.into_iter().filter(|entry| entry.part != Part::Pin).collect();
    let before_bytes = entries.iter().map(|entry| entry.bytes).sum();
    let needed = needed(store, &entries)?;
    // Asked after the long walk, so that cooks that began meanwhile count.
    let safe = safe_before(store);
    let mut collected = Collected { before_bytes, after_bytes: before_bytes, swept, ..Collected::default() };
    for (last_needed, entry) in in_order(entries, &needed) {
        if collected.after_bytes <= keep_bytes {
            break;
        }
        let name = (entry.part, entry.name);
        let spared = &mut collected.spared;
        if needed.pinned.contains(&name) {
            spared.pinned += 1;
            spared.pinned_bytes += entry.bytes;
            continue;
        }
        // The time of change, not of need: a session that names a file says nothing of the cooks that run now.
        let written = fs::metadata(&entry.path).and_then(|meta| meta.modified()).unwrap_or(entry.modified);
        if needed.running.contains(&name) || safe.is_some_and(|safe| written >= safe) {
            spared.running += 1;
            spared.running_bytes += entry.bytes;
            continue;
        }
        match if dry { Ok(()) } else { fs::remove_file(&entry.path) } {
            Err(problem) if problem.kind() != ErrorKind::NotFound => {
                collected.refused.push((entry.path, problem.to_string()));
            }
            _ => {
                collected.after_bytes -= entry.bytes;
                let Entry { part, path: file, bytes, .. } = entry;
                collected.removed.push(Removed { part, file, bytes, last_needed });
            }
        }
    }
    if !dry {
        drop_empty_checkpoints(store);
    }
    Ok(collected)
}

/// What all sessions name; those of pinned graphs and of running cooks keep it.
fn needed(store: &Store, entries: &[Entry]) -> Result<Needed, StoreError> {
    let pinned = pins(store);
    let running: Vec<_> = store.leases().iter().filter_map(crate::store::LeaseRecord::session_name).collect();
    let mut needed = Needed::default();
    for (name, pin) in &pinned {
        let needs = Needs::of(store, name).ok_or_else(|| StoreError::PinnedUnknown {
            graph: pin.graph.clone(),
            session: store.session_place(name),
        })?;
        needed.add(needs, true, running.contains(name));
    }
    let sessions = entries.iter().filter(|entry| entry.part == Part::Session);
    for session in sessions.filter(|session| pinned.iter().all(|(name, _)| *name != session.name)) {
        if let Some(needs) = Needs::of(store, &session.name) {
            needed.add(needs, false, running.contains(&session.name));
        }
    }
    Ok(needed)
}

/// What was written or noted as used since then may be needed by a running cook. A cook notes no use of what was noted
/// within [`USE_GRAIN`] before.
fn safe_before(store: &Store) -> Option<SystemTime> {
    let oldest = store.leases().iter().map(crate::store::LeaseRecord::since).min()?;
    oldest.checked_sub(USE_GRAIN)
}

/// Files with the time at which they were last needed, that of the longest past first. Of the same second, values go before
/// the actions that name them, and sessions last.
fn in_order(entries: Vec<Entry>, needed: &Needed) -> Vec<(SystemTime, Entry)> {
    let timed = entries.into_iter().map(|entry| {
        let named = needed.last.get(&(entry.part, entry.name));
        (named.map_or(entry.modified, |time| entry.modified.max(*time)), entry)
    });
    let mut timed: Vec<(SystemTime, Entry)> = timed.collect();
    let second = |time: &SystemTime| time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    timed.sort_by_cached_key(|(last, entry)| (second(last), entry.part, entry.path.clone()));
    timed
}

/// Removes the folders of computations that hold no state any more.
fn drop_empty_checkpoints(store: &Store) {
    let folder = store.root().join(Part::Checkpoint.folder());
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        // Fails where something stands in it, as it should.
        let _ = fs::remove_dir(entry.path());
    }
}
