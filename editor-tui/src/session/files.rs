//! Graph files on disk: read, written in one step, and looked at for changes by others.

use graph_core::document::edit::save;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The text of a graph file.
///
/// # Errors
/// Why it cannot be read, for people.
pub fn read(path: &Path) -> Result<String, String> {
    match graph_core::document::Source::load(path) {
        Ok(source) => Ok(source.text),
        Err(mistake) => Err(match mistake.help {
            Some(help) => format!("{}; {help}", mistake.message),
            None => mistake.message,
        }),
    }
}

/// Writes files, each into a temporary one beside it that takes its place. Gives what was written.
pub fn write_all(texts: &BTreeMap<PathBuf, String>) -> Result<Vec<(PathBuf, String)>, String> {
    let mut written = Vec::with_capacity(texts.len());
    for (path, text) in texts {
        let saved = path.canonicalize().and_then(|path| save(&path, text));
        saved.map_err(|problem| format!("{} cannot be written: {problem}", path.display()))?;
        written.push((path.clone(), text.clone()));
    }
    Ok(written)
}

/// What files looked like when they were last looked at.
#[derive(Debug, Default)]
pub struct Seen(HashMap<PathBuf, (u64, Option<SystemTime>)>);

impl Seen {
    /// The file's text where it may have changed since the last look; at first it may have.
    pub fn changed(&mut self, path: &Path) -> Option<Result<String, String>> {
        let now = std::fs::metadata(path).map_or((0, None), |facts| (facts.len(), facts.modified().ok()));
        let same = self.0.get(path) == Some(&now);
        // A file that was just written may change again within the same instant of its file system.
        let settled = now.1.and_then(|at| at.elapsed().ok()).is_none_or(|age| age.as_secs() >= 2);
        if same {
            return None;
        }
        if settled {
            self.0.insert(path.to_owned(), now);
        }
        Some(read(path))
    }

    /// Looks at a file anew.
    pub fn forget(&mut self, path: &Path) {
        self.0.remove(path);
    }
}
