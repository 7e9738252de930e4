//! A project in a folder of its own, with a store of its own.

use crate::Run;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A folder with graphs and takes, in which the program is run. It vanishes with this value.
#[derive(Debug)]
pub struct Project {
    folder: TempDir,
    program: PathBuf,
}

impl Project {
    /// An empty project. Tests give `env!("CARGO_BIN_EXE_grimace-under-test")` as the program.
    ///
    /// # Panics
    /// Where no temporary folder can be made.
    pub fn new(program: &str) -> Self {
        let folder = tempfile::tempdir().unwrap_or_else(|problem| panic!("no temporary folder: {problem}"));
        Self { folder, program: program.into() }
    }

    /// Where the file `relative` lies.
    pub fn path(&self, relative: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(relative)
    }

    /// Writes a file, and the folders it needs.
    ///
    /// # Panics
    /// Where it cannot be written.
    pub fn write(&self, relative: &str, content: impl AsRef<[u8]>) {
        let path = self.path(relative);
        let written = fs::create_dir_all(path.parent().unwrap_or(&path)).and_then(|()| fs::write(&path, content));
        written.unwrap_or_else(|problem| panic!("{}: {problem}", path.display()));
    }

    /// The text of a file.
    ///
    /// # Panics
    /// Where it cannot be read.
    pub fn read(&self, relative: &str) -> String {
        let path = self.path(relative);
        fs::read_to_string(&path).unwrap_or_else(|problem| panic!("{}: {problem}", path.display()))
    }

    /// Copies a file or a folder from elsewhere to `relative`.
    ///
    /// # Panics
    /// Where it cannot be copied.
    pub fn copy(&self, from: &Path, relative: &str) {
        copy(from, &self.path(relative)).unwrap_or_else(|problem| panic!("{}: {problem}", from.display()));
    }

    /// Runs the program in the project's folder.
    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command().args(arguments))
    }

    /// The program, to be run in the project's folder with the project's store, without colours.
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        command.current_dir(self.folder.path()).env("GRIMACE_STORE", self.path(".grimace")).env("NO_COLOR", "1");
        for name in ["GRIMACE_JOBS", "GRIMACE_COLOR", "GRIMACE_LOG", "GRIMACE_LOG_FILE"] {
            command.env_remove(name);
        }
        command.env("XDG_CONFIG_HOME", self.path("config")).env("XDG_DATA_HOME", self.path("data"));
        command.env("GRIMACE_PLUGIN_CODE", self.path("code")).env_remove("GRIMACE_PLUGINS");
        command
    }
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    if !from.is_dir() {
        fs::create_dir_all(to.parent().unwrap_or(to))?;
        return fs::copy(from, to).map(drop);
    }
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}
