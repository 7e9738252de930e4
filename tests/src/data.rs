//! Real inputs that are no part of the repository.

use std::path::{Path, PathBuf};

/// The folder of test data; `None`, said loudly, where this machine has none. It is `GRIMACE_TEST_DATA`, or
/// `../shared/data` beside the checkout.
///
/// # Panics
/// In CI (where `CI` is set), so that nothing goes untested there.
pub fn test_data() -> Option<PathBuf> {
    let folder = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    let message = format!("there is no {}; set GRIMACE_TEST_DATA to the folder of test data", folder.display());
    assert!(std::env::var_os("CI").is_none(), "{message}");
    said(&message);
    None
}

#[allow(clippy::print_stderr, reason = "a skipped test says so, where the harness sees it")]
fn said(message: &str) {
    eprintln!("SKIPPED: {message}");
}
