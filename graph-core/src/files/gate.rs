//! The gate: which files have arrived. A watch opens it to a file once that stands still; a cook sees others as they were.

use super::Signature;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock};

/// The files that may be read, each only as long as it looks as it did when it arrived.
#[derive(Debug, Default)]
pub struct Gate {
    arrived: RwLock<BTreeMap<PathBuf, Signature>>,
}

impl Gate {
    /// Lets in exactly `arrived`.
    pub fn open_to(&self, arrived: BTreeMap<PathBuf, Signature>) {
        *self.arrived.write().unwrap_or_else(PoisonError::into_inner) = arrived;
    }

    /// Whether a file at `path` ever arrived.
    pub fn knows(&self, path: &Path) -> bool {
        self.arrived.read().unwrap_or_else(PoisonError::into_inner).contains_key(path)
    }

    /// Whether the file at `path` is there, arrived, and still looks as it did then.
    pub fn stands(&self, path: &Path) -> bool {
        let arrived = self.arrived.read().unwrap_or_else(PoisonError::into_inner).get(path).copied();
        arrived.is_some_and(|arrived| Signature::of(path).is_ok_and(|now| now == arrived))
    }

    /// Whether the file at `path` arrived, and still looks as it did then. One that is not there is let through: whoever
    /// reads it says so best.
    pub fn lets_in(&self, path: &Path) -> bool {
        let arrived = self.arrived.read().unwrap_or_else(PoisonError::into_inner).get(path).copied();
        match (arrived, Signature::of(path)) {
            (Some(arrived), Ok(now)) => arrived == now,
            (None, Ok(_)) => false,
            (_, Err(_)) => true,
        }
    }
}
