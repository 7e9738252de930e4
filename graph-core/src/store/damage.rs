//! Damage: files of the store that are not what was written. They are noted when they are met, and a cook tells of them.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A file that was found damaged.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// The file.
    pub file: PathBuf,
    /// What was found, and what was done about it.
    pub message: String,
}

/// What was found so far and not told yet.
#[derive(Debug, Default)]
pub(super) struct Damages(Mutex<Vec<Damage>>);

impl Damages {
    /// Notes a file whose content is not what was written, and removes it.
    pub fn drop_file(&self, file: &Path, lost: &str) {
        let message = match std::fs::remove_file(file) {
            Ok(()) => format!("was damaged; it was dropped, and {lost}"),
            Err(problem) if problem.kind() == std::io::ErrorKind::NotFound => return,
            Err(problem) => format!("is damaged and cannot be removed ({problem}); {lost}"),
        };
        self.note(file, message);
    }

    /// Notes a file that is there and cannot be read.
    pub fn unreadable(&self, file: &Path, problem: &std::io::Error, lost: &str) {
        self.note(file, format!("cannot be read ({problem}), and {lost}"));
    }

    fn note(&self, file: &Path, message: String) {
        let damage = Damage { file: file.to_owned(), message };
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !known.contains(&damage) {
            known.push(damage);
        }
    }

    /// What was noted since this was last asked.
    pub fn take(&self) -> Vec<Damage> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
