//! The inventory: every file of a store, part by part.

use super::Store;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use wire::Digest;

/// A part of the store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// States of computations that were cut short, by key.
    Checkpoint,
    /// Values, by content.
    Pack,
    /// What computations gave, by key.
    Action,
    /// What the last cook of each graph depended on.
    Rest,
    /// What the last cook of each graph knew.
    Session,
    /// Graphs whose results stay.
    Pin,
}

impl Part {
    /// All parts.
    pub const ALL: [Self; 6] = [Self::Checkpoint, Self::Pack, Self::Action, Self::Rest, Self::Session, Self::Pin];

    /// The folder of the part within the store.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Checkpoint => "checkpoints",
            Self::Pack => "packs",
            Self::Action => "actions",
            Self::Rest => "rests",
            Self::Session => "sessions",
            Self::Pin => "pins",
        }
    }
}

/// A file of the store.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// What it is.
    pub part: Part,
    /// The name under which it stands: a key, or the digest of a content; for a checkpoint the key of its computation.
    pub name: Digest,
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// When it was written, or last used as far as was noted.
    pub modified: SystemTime,
}

/// Everything that stands in a store.
#[derive(Debug, Default)]
pub struct Inventory {
    /// Its files, part by part in the order of their names.
    pub entries: Vec<Entry>,
    /// Files among them that are not of its making.
    pub strangers: Vec<PathBuf>,
}

impl Store {
    /// Lists every file. What vanishes meanwhile is left out.
    pub fn inventory(&self) -> Inventory {
        let mut inventory = Inventory::default();
        for part in Part::ALL {
            for folder in sorted(&self.root().join(part.folder())) {
                let prefix = name_of(&folder);
                if !folder.is_dir() {
                    inventory.strangers.push(folder);
                    continue;
                }
                for path in sorted(&folder) {
                    let name = match part {
                        Part::Checkpoint => prefix.clone(),
                        _ => format!("{prefix}{}", name_of(&path)),
                    };
                    let Ok(meta) = fs::metadata(&path) else { continue };
                    match Digest::from_hex(&name).filter(|_| meta.is_file()) {
                        Some(name) => {
                            let modified = meta.modified().unwrap_or(UNIX_EPOCH);
                            inventory.entries.push(Entry { part, name, path, bytes: meta.len(), modified });
                        }
                        None => inventory.strangers.push(path),
                    }
                }
            }
        }
        inventory
    }
}

fn sorted(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
