//! Patterns of files: `takes/*.c3d`, `shots/**/rom_?.csv`, `{day1,day2}_*.c3d`.

use globset::{GlobBuilder, GlobMatcher};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// A path that may hold wild cards: `*`, `?`, `[…]`, `{a,b}` within a name, `**` for any number of folders.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    path: PathBuf,
}

/// Why a pattern gives no files.
#[derive(Debug, thiserror::Error)]
pub enum PatternError {
    /// The wild cards are malformed.
    #[error("`{text}` is not a pattern: {problem}")]
    Malformed {
        /// The pattern.
        text: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A folder could not be listed.
    #[error("the folder {folder} cannot be listed: {problem}")]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the system says.
        problem: std::io::Error,
    },
    /// Two files would make items of one name.
    #[error("`{first}` and `{second}` would both be the item `{item}`; give one of them another name")]
    Twice {
        /// The item.
        item: String,
        /// One file.
        first: PathBuf,
        /// The other file.
        second: PathBuf,
    },
}

fn is_wild(text: &str) -> bool {
    text.contains(['*', '?', '[', '{'])
}

impl Pattern {
    /// A pattern of the absolute or relative `path`.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// Whether it has wild cards; else it names one file.
    pub fn is_wild(&self) -> bool {
        // A file that is really called so is that file.
        self.path.components().any(|part| is_wild(&part.as_os_str().to_string_lossy())) && !self.path.is_file()
    }

    /// The path as written.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The matching files by item name (the file's name without its last extension), in the order of the names.
    /// Hidden files never match. A path without wild cards gives itself, whether it exists or not.
    ///
    /// # Errors
    /// Malformed wild cards, a folder that cannot be listed, or two files of one item name. No match at all is no
    /// error: a watched folder may be empty.
    pub fn files(&self) -> Result<BTreeMap<String, PathBuf>, PatternError> {
        let mut found = Vec::new();
        if self.is_wild() {
            let parts: Vec<_> = self.path.components().collect();
            expand(PathBuf::new(), &parts, &mut found)?;
        } else {
            found.push(self.path.clone());
        }
        let mut items = BTreeMap::new();
        for file in found {
            let item = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            if let Some(first) = items.insert(item.clone(), file.clone()) {
                return Err(PatternError::Twice { item, first, second: file });
            }
        }
        Ok(items)
    }
}

fn expand(folder: PathBuf, parts: &[Component<'_>], found: &mut Vec<PathBuf>) -> Result<(), PatternError> {
    let Some((part, rest)) = parts.split_first() else {
        if folder.is_file() {
            found.push(folder);
        }
        return Ok(());
    };
    let text = part.as_os_str().to_string_lossy();
    if !is_wild(&text) {
        return expand(folder.join(part), rest, found);
    }
    if text == "**" {
        expand(folder.clone(), rest, found)?;
        for (name, path) in list(&folder)? {
            if path.is_dir() && !name.starts_with('.') && !path.is_symlink() {
                expand(path, parts, found)?;
            }
        }
        return Ok(());
    }
    let matcher = matcher(&text)?;
    for (name, path) in list(&folder)? {
        if !name.starts_with('.') && matcher.is_match(&name) && (rest.is_empty() || path.is_dir()) {
            expand(path, rest, found)?;
        }
    }
    Ok(())
}

fn matcher(text: &str) -> Result<GlobMatcher, PatternError> {
    GlobBuilder::new(text)
        .literal_separator(true)
        .build()
        .map(|glob| glob.compile_matcher())
        .map_err(|error| PatternError::Malformed { text: text.to_owned(), problem: error.kind().to_string() })
}

/// Names and paths in a folder, by name; a folder that is not there is empty.
fn list(folder: &Path) -> Result<BTreeMap<String, PathBuf>, PatternError> {
    let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = match std::fs::read_dir(place) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeMap::new()),
        Err(problem) => return Err(PatternError::Folder { folder: folder.to_owned(), problem }),
    };
    let mut names = BTreeMap::new();
    for entry in entries {
        let entry = entry.map_err(|problem| PatternError::Folder { folder: folder.to_owned(), problem })?;
        let name = entry.file_name();
        names.insert(name.to_string_lossy().into_owned(), folder.join(&name));
    }
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(pattern: PathBuf) -> Vec<String> {
        Pattern::new(pattern).files().unwrap().into_keys().collect()
    }

    #[test]
    fn wild_cards_find_files_in_the_order_of_their_names() {
        let folder = tempfile::tempdir().unwrap();
        for file in ["day2_1.c3d", "day1_9.c3d", "day1_1.c3d", "notes.txt", ".hidden.c3d", "sub/deep/day3_1.c3d"] {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "x").unwrap();
        }
        assert_eq!(names(folder.path().join("*.c3d")), ["day1_1", "day1_9", "day2_1"]);
        assert_eq!(names(folder.path().join("{day1,day3}_*.c3d")), ["day1_1", "day1_9"]);
        assert_eq!(names(folder.path().join("**/*.c3d")), ["day1_1", "day1_9", "day2_1", "day3_1"]);
        assert_eq!(names(folder.path().join("nowhere/*.c3d")), Vec::<String>::new());
        assert_eq!(names(folder.path().join("absent.c3d")), ["absent"]);
        assert!(matches!(Pattern::new(folder.path().join("[.c3d")).files(), Err(PatternError::Malformed { .. })));
    }

    #[test]
    fn two_files_of_one_item_name_are_an_error() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.c3d"), "x").unwrap();
        std::fs::write(folder.path().join("a.csv"), "x").unwrap();
        assert!(matches!(Pattern::new(folder.path().join("a.*")).files(), Err(PatternError::Twice { .. })));
    }
}
