//! Real inputs that are no part of the repository.

use std::path::{Path, PathBuf};

/// The folder of test data; `None`, said loudly, where this machine has none. It is `GRIMACE_TEST_DATA`, or
/// `../shared/data` beside the checkout.
///
/// # Panics
/// Where `GRIMACE_TEST_DATA` is set and is no folder.
pub fn test_data() -> Option<PathBuf> {
    let folder = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    let message = format!("there is no {}; set GRIMACE_TEST_DATA to the folder of test data", folder.display());
    assert!(std::env::var_os("GRIMACE_TEST_DATA").is_none(), "{message}");
    skipped(&message);
    None
}

/// Says that a test was skipped, and why.
#[allow(clippy::print_stderr, reason = "a skipped test says so, where the harness sees it")]
pub fn skipped(reason: &str) {
    eprintln!("SKIPPED: {reason}");
}
