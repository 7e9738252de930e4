//! The lock file: `plugins.lock` beside a graph, which pins the plugins that were accepted by their digests. Where there is
//! one, a plugin that differs from it, or is not in it, is an error until it is accepted. Without one, nothing is pinned.

use graph_core::document::edit::save;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The plugins that were accepted for the graphs of a folder.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lock {
    /// Pins by the ids of plugins.
    pub plugins: BTreeMap<String, Pin>,
}

/// A plugin that was accepted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pin {
    /// Its version.
    pub version: String,
    /// SHA-256 of its component.
    pub sha256: String,
}

/// What is wrong with a lock file, or held against it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LockError {
    /// It cannot be read or written.
    #[error("{}: {problem}", file.display())]
    File {
        /// The lock file.
        file: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A plugin is not the one that was accepted.
    #[error("plugin `{plugin}` is not the one that {} pins: {found} instead of {pinned}", file.display())]
    Changed {
        /// The lock file.
        file: PathBuf,
        /// The plugin.
        plugin: String,
        /// Version and digest that were accepted.
        pinned: String,
        /// Version and digest that were found.
        found: String,
    },
    /// A plugin was never accepted.
    #[error("plugin `{plugin}` is not in {}, which pins the plugins of these graphs", file.display())]
    Unknown {
        /// The lock file.
        file: PathBuf,
        /// The plugin.
        plugin: String,
    },
}

impl Lock {
    /// Where the lock file for the graph at `graph` is.
    pub fn path(graph: &Path) -> PathBuf {
        graph.with_file_name("plugins.lock")
    }

    /// Reads the lock file `file`; `None` where there is none.
    ///
    /// # Errors
    /// Where it cannot be read, or is no lock file.
    pub fn load(file: &Path) -> Result<Option<Self>, LockError> {
        let wrong = |problem: String| LockError::File { file: file.to_owned(), problem };
        match std::fs::read_to_string(file) {
            Ok(text) => ron::from_str(&text).map(Some).map_err(|error| wrong(error.to_string())),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(wrong(error.to_string())),
        }
    }

    /// Writes the lock file `file`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn save(&self, file: &Path) -> Result<(), LockError> {
        let wrong = |problem: String| LockError::File { file: file.to_owned(), problem };
        let style = ron::ser::PrettyConfig::default().depth_limit(2);
        let text = ron::ser::to_string_pretty(self, style).map_err(|error| wrong(error.to_string()))?;
        let text = format!("// The plugins that these graphs may run. `grimace plugin accept` writes it.\n{text}\n");
        save(file, text).map_err(|error| wrong(error.to_string()))
    }

    /// Whether the plugin called `plugin`, of this version and digest, is the one that was accepted.
    ///
    /// # Errors
    /// Where it is another, or was never accepted.
    pub fn check(&self, file: &Path, plugin: &str, version: &str, sha256: &str) -> Result<(), LockError> {
        let shown = |version: &str, digest: &str| format!("{version} ({})", digest.get(..12).unwrap_or(digest));
        let file = file.to_owned();
        match self.plugins.get(plugin) {
            Some(pin) if pin.sha256 == sha256 => Ok(()),
            Some(pin) => Err(LockError::Changed {
                file,
                plugin: plugin.to_owned(),
                pinned: shown(&pin.version, &pin.sha256),
                found: shown(version, sha256),
            }),
            None => Err(LockError::Unknown { file, plugin: plugin.to_owned() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_pinned_is_held_to() {
        let folder = tempfile::tempdir().unwrap();
        let file = Lock::path(&folder.path().join("graph.ron"));
        assert_eq!(Lock::load(&file).unwrap(), None);
        let mut lock = Lock::default();
        lock.plugins.insert("calm".to_owned(), Pin { version: "1".to_owned(), sha256: "ab".repeat(32) });
        lock.save(&file).unwrap();
        assert_eq!(Lock::load(&file).unwrap(), Some(lock.clone()));
        assert_eq!(lock.check(&file, "calm", "1", &"ab".repeat(32)), Ok(()));
        let changed = lock.check(&file, "calm", "2", &"cd".repeat(32)).unwrap_err().to_string();
        assert!(changed.contains("2 (cdcdcdcdcdcd) instead of 1 (abababababab)"), "{changed}");
        assert!(matches!(lock.check(&file, "other", "1", ""), Err(LockError::Unknown { .. })));
        std::fs::write(&file, "nonsense").unwrap();
        assert!(Lock::load(&file).unwrap_err().to_string().contains("plugins.lock"));
    }
}
