//! The care of the store: damage, garbage, pins, leases, disks that are full or may not be written, many processes at once.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

mod care;
#[path = "../common/mod.rs"]
mod common;
mod damage;
mod disks;
mod leases;

use common::Project;
use std::path::{Path, PathBuf};

/// Two takes that are written anew.
pub(crate) const SAVING: &str = r#"(
    grimace: 1,
    params: { "rate": 24.0 },
    nodes: {
        "takes": (kind: "load_curves", with: (path: "takes/*.csv")),
        "still": (kind: "load_curves", with: (path: "rom.csv", rate_hz: "${rate}")),
        "save": (kind: "save_curves", in: {"curves": "takes"}, with: (path: "out/{take}.csv")),
    },
)"#;

/// A project whose results are worth keeping.
pub(crate) fn project() -> Project {
    let project = Project::new(SAVING);
    project.long_takes();
    project
}

/// All files below a folder, in order.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}

/// The files of a store that a gc weighs.
pub(crate) fn stored(project: &Project) -> Vec<PathBuf> {
    ["actions", "packs", "sessions"].iter().flat_map(|part| files(&project.path(".grimace").join(part))).collect()
}

/// Makes a file look as if it had last been changed so many days ago.
pub(crate) fn age(path: &Path, days: u64) {
    static NOW: std::sync::LazyLock<std::time::SystemTime> = std::sync::LazyLock::new(std::time::SystemTime::now);
    let time = *NOW - std::time::Duration::from_hours(24 * days);
    std::fs::File::options().append(true).open(path).unwrap().set_modified(time).unwrap();
}

/// What was written, by name.
pub(crate) fn written(project: &Project) -> Vec<(PathBuf, Vec<u8>)> {
    let csv = files(&project.path("out")).into_iter().filter(|path| path.extension().is_some_and(|end| end == "csv"));
    csv.map(|path| (path.file_name().unwrap().into(), std::fs::read(path).unwrap())).collect()
}
