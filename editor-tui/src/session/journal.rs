//! The journal: operations as they are made, written down at once, so that a killed editor loses none of them.
//!
//! A journal stands in the store's folder under the graph's name and the process's number: first the texts that its
//! operations begin with, then a line an operation. It is gone when everything is saved, or left on purpose.

use crate::model::texts::{Operation, Texts};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What a journal holds: the texts that its operations begin with, by file, and the operations.
pub type Held = (Vec<(PathBuf, String)>, Vec<Operation>);

/// The journal of this editor, and those that others left.
#[derive(Debug)]
pub struct Journal {
    folder: PathBuf,
    name: String,
    open: Option<File>,
    found: Vec<PathBuf>,
}

impl Journal {
    /// The journal of the graph at `root`, with the store at `store`.
    pub fn of(store: &Path, root: &Path) -> Self {
        let whole = root.canonicalize().unwrap_or_else(|_| root.to_owned());
        let digest = wire::Digest::of(whole.as_os_str().as_encoded_bytes());
        let name: String = digest.to_string().chars().take(16).collect();
        Self { folder: store.join("edits"), name, open: None, found: Vec::new() }
    }

    fn own(&self) -> PathBuf {
        self.folder.join(format!("{}.{}.journal", self.name, std::process::id()))
    }

    /// What an editor of this graph left that is no longer there; of several, the newest.
    pub fn left_behind(&mut self) -> Option<Held> {
        let entries = std::fs::read_dir(&self.folder).ok()?;
        let mut left: Vec<(std::time::SystemTime, PathBuf)> = Vec::new();
        for entry in entries.filter_map(Result::ok) {
            let file = entry.file_name().to_string_lossy().into_owned();
            let mut parts = file.split('.');
            let ours = parts.next() == Some(&self.name);
            let process = parts.next().and_then(|number| number.parse::<u32>().ok());
            let alive = process.is_some_and(|process| process != std::process::id() && lives(process));
            if ours && !alive {
                let time = entry.metadata().and_then(|facts| facts.modified());
                left.push((time.unwrap_or(std::time::UNIX_EPOCH), entry.path()));
            }
        }
        left.sort();
        self.found = left.iter().map(|(_, path)| path.clone()).collect();
        self.found.iter().rev().find_map(|path| read(path))
    }

    /// Writes an operation down, after the texts it begins with where it is the first.
    ///
    /// # Errors
    /// Where the journal cannot be written.
    pub fn note(&mut self, texts: &Texts, operation: &Operation) -> std::io::Result<()> {
        if self.open.is_none() {
            // The first operation is made already: the texts on disk and all that is unsaved say the same.
            self.restart(texts);
            return if self.open.is_some() || !texts.is_unsaved() {
                Ok(())
            } else {
                Err(std::io::Error::other(format!("{} cannot be made", self.own().display())))
            };
        }
        let Some(file) = &mut self.open else { return Ok(()) };
        let line = serde_json::to_string(operation).map_err(std::io::Error::other)?;
        writeln!(file, "{line}")
    }

    /// Begins the journal anew with all that is unsaved.
    pub fn restart(&mut self, texts: &Texts) {
        let Some(operation) = texts.unsaved_operation() else { return self.drop_own() };
        let bases: Vec<(&PathBuf, &String)> = texts.files().map(|(path, text)| (path, &text.base)).collect();
        let label = texts.last().unwrap_or("edits").to_owned();
        let operation = Operation { label, ..operation };
        let begun = || -> std::io::Result<File> {
            std::fs::create_dir_all(&self.folder)?;
            let beside = self.own().with_extension("new");
            let mut file = OpenOptions::new().create(true).write(true).truncate(true).open(&beside)?;
            let head = serde_json::to_string(&bases).map_err(std::io::Error::other)?;
            let first = serde_json::to_string(&operation).map_err(std::io::Error::other)?;
            file.write_all(format!("{head}\n{first}\n").as_bytes())?;
            std::fs::rename(&beside, self.own())?;
            Ok(file)
        };
        self.open = begun().ok();
    }

    /// Throws this editor's journal away.
    pub fn drop_own(&mut self) {
        self.open = None;
        drop(std::fs::remove_file(self.own()));
    }

    /// Throws it away with those that were found.
    pub fn drop_all(&mut self) {
        self.drop_own();
        for path in std::mem::take(&mut self.found) {
            drop(std::fs::remove_file(path));
        }
    }
}

/// Whether a process still runs; one that has ended and was not waited for does not.
fn lives(process: u32) -> bool {
    let facts = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let state = facts.rsplit(')').next().and_then(|rest| rest.split_whitespace().next());
    !matches!(state, None | Some("Z" | "X"))
}

/// What the journal at `path` holds; a last line that was not written to its end is left out.
fn read(path: &Path) -> Option<Held> {
    let text = std::fs::read_to_string(path).ok()?;
    let mut lines = text.lines();
    let bases = serde_json::from_str(lines.next()?).ok()?;
    let operations: Vec<Operation> = lines.map_while(|line| serde_json::from_str(line).ok()).collect();
    (!operations.is_empty()).then_some((bases, operations))
}
