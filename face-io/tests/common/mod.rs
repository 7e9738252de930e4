//! Finds the real files that the tests read.
#![allow(dead_code, reason = "each test binary uses its own part of this module")]
#![allow(clippy::unwrap_used, reason = "tests may panic")]

use std::path::{Path, PathBuf};

pub mod forge;
pub mod harm;
pub mod tables;

/// The folder of test data, or nothing (said loudly) where there is none and `GRIMACE_TEST_DATA` asks for none.
#[allow(clippy::print_stderr, reason = "a skipped test must be noticed")]
pub fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    assert!(std::env::var_os("GRIMACE_TEST_DATA").is_none(), "no test data at {}", folder.display());
    eprintln!("SKIPPED: no test data at {} (set GRIMACE_TEST_DATA)", folder.display());
    None
}

/// The bytes of a file.
pub fn bytes(path: impl AsRef<Path>) -> Vec<u8> {
    let path = path.as_ref();
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Reads companion files from a folder.
pub fn siblings(folder: &Path) -> impl FnMut(&str) -> std::io::Result<Vec<u8>> + use<> {
    let folder = folder.to_owned();
    move |name| std::fs::read(folder.join(name))
}

/// All files below a folder that end in `ending` (any case), sorted.
pub fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.to_string_lossy().to_lowercase().ends_with(ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}
