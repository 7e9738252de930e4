//! Verifying: reads every file of a store, and drops those that are not what was written.

use crate::store::{Entry, Part, Store, content, is_sound};
use rayon::prelude::*;
use serde::Serialize;
use std::fs::{self, File};
use std::io::{self, BufReader, ErrorKind};
use std::path::PathBuf;

/// A file that is not sound.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The part of the store.
    pub part: Part,
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    pub problem: String,
    /// Whether it was removed.
    pub dropped: bool,
}

/// What verifying found.
#[derive(Debug, Default)]
pub struct Verified {
    /// Files read.
    pub files: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Those that are not sound.
    pub findings: Vec<Finding>,
    /// Files that are not of the store's making.
    pub strangers: Vec<PathBuf>,
}

/// Reads every file of `store`. Damaged ones are removed, unless `dry`; whatever they held is computed again when it is
/// needed. `told` is called after each file with its size.
pub fn verify(store: &Store, dry: bool, told: &(dyn Fn(u64) + Sync)) -> Verified {
    let inventory = store.inventory();
    let found = inventory.entries.par_iter().map(|entry| {
        let finding = examine(entry, dry);
        told(entry.bytes);
        finding
    });
    let findings: Vec<Option<Finding>> = found.collect();
    Verified {
        files: inventory.entries.len() as u64,
        bytes: inventory.entries.iter().map(|entry| entry.bytes).sum(),
        findings: findings.into_iter().flatten().collect(),
        strangers: inventory.strangers,
    }
}

/// What is wrong with a file; nothing where it vanished meanwhile.
fn examine(entry: &Entry, dry: bool) -> Option<Finding> {
    let (problem, damaged) = match sound(entry) {
        Ok(true) => return None,
        Ok(false) => ("its content is not what was written".to_owned(), true),
        Err(problem) if problem.kind() == ErrorKind::NotFound => return None,
        Err(problem) => (format!("cannot be read: {problem}"), false),
    };
    // What cannot be read now may be sound: a disk may be away, or a right missing.
    let dropped = damaged && !dry && fs::remove_file(&entry.path).is_ok();
    Some(Finding { part: entry.part, file: entry.path.clone(), problem, dropped })
}

fn sound(entry: &Entry) -> io::Result<bool> {
    if entry.part == Part::Pack {
        let file = File::open(&entry.path)?;
        let length = file.metadata()?.len();
        return is_sound(BufReader::with_capacity(1 << 16, file), length, &entry.name);
    }
    Ok(content(&fs::read(&entry.path)?).is_some())
}
