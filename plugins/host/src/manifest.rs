//! Manifests: the `plugin.ron` beside a component, which says what it is and what it may take.

use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Name of the file.
pub const FILE: &str = "plugin.ron";

/// What a `plugin.ron` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The first half of the names of its kinds: small letters, digits, `-` and `_`.
    pub id: String,
    /// Version of the plugin, for people.
    pub version: String,
    /// Version of the interface that it speaks.
    pub api: String,
    /// The component, beside the manifest.
    pub file: String,
    /// SHA-256 of the component; where it is given, nothing else is run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// What it may take.
    #[serde(default)]
    pub limits: Limits,
    /// Licence of the plugin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub licence: Option<String>,
    /// One line on what it is for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doc: Option<String>,
    /// What it is built from, for `grimace plugin build`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub build: Option<String>,
}

/// What one evaluation of a node may take.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Memory in MiB, 1 to 4096.
    pub memory_mb: u32,
    /// Time in seconds, more than 0.
    pub time_s: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { memory_mb: 512, time_s: 60.0 }
    }
}

/// What is wrong with a `plugin.ron`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ManifestError {
    /// It cannot be read.
    #[error("{}: {problem}", file.display())]
    File {
        /// The manifest.
        file: PathBuf,
        /// What the system says.
        problem: String,
    },
    /// It is no manifest.
    #[error("{}:{line}:{column}: {problem}; a manifest holds id, version, api, file, and may hold sha256, limits, licence, doc, build", file.display())]
    Text {
        /// The manifest.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong there.
        problem: String,
    },
    /// A field has a value that it may not have.
    #[error("{}: `{field}` is {found}; it must be {expected}", file.display())]
    Field {
        /// The manifest.
        file: PathBuf,
        /// The field.
        field: &'static str,
        /// What it is.
        found: String,
        /// What it must be.
        expected: &'static str,
    },
}

impl Manifest {
    /// Reads the manifest `file`.
    ///
    /// # Errors
    /// Where it cannot be read, or is wrong.
    pub fn load(file: &Path) -> Result<Self, ManifestError> {
        let text = std::fs::read_to_string(file)
            .map_err(|problem| ManifestError::File { file: file.to_owned(), problem: problem.to_string() })?;
        Self::read(&text, file)
    }

    /// Reads a manifest from the text of `file`.
    ///
    /// # Errors
    /// Where it is wrong.
    pub fn read(text: &str, file: &Path) -> Result<Self, ManifestError> {
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let manifest: Self = options.from_str(text).map_err(|error| ManifestError::Text {
            file: file.to_owned(),
            line: error.span.start.line,
            column: error.span.start.col,
            problem: error.code.to_string(),
        })?;
        manifest.checked(file)
    }

    fn checked(self, file: &Path) -> Result<Self, ManifestError> {
        let wrong = |field, found: String, expected| {
            Err(ManifestError::Field { file: file.to_owned(), field, found, expected })
        };
        let plain = |name: &str| {
            name.starts_with(|letter: char| letter.is_ascii_lowercase())
                && name.len() <= 64
                && name
                    .chars()
                    .all(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || "-_".contains(letter))
        };
        if !plain(&self.id) {
            let expected = "small letters, digits, `-` and `_`, at most 64, the first a letter";
            return wrong("id", format!("{:?}", self.id), expected);
        }
        if self.version.trim().is_empty() || self.version.len() > 64 {
            return wrong("version", format!("{:?}", self.version), "a version such as \"1.0.0\"");
        }
        let inside = Path::new(&self.file);
        if inside.components().count() != 1
            || !matches!(inside.components().next(), Some(std::path::Component::Normal(_)))
        {
            return wrong("file", format!("{:?}", self.file), "the name of a file beside the manifest");
        }
        if !self
            .sha256
            .as_deref()
            .is_none_or(|hex| hex.len() == 64 && hex.chars().all(|digit| digit.is_ascii_hexdigit()))
        {
            return wrong("sha256", format!("{:?}", self.sha256.unwrap_or_default()), "64 hexadecimal digits");
        }
        if !(1..=4096).contains(&self.limits.memory_mb) {
            return wrong("limits.memory_mb", self.limits.memory_mb.to_string(), "1 to 4096");
        }
        if !(self.limits.time_s > 0.0 && self.limits.time_s <= 1e7) {
            return wrong("limits.time_s", self.limits.time_s.to_string(), "more than 0, and at most 1e7");
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "(id: \"calm\", version: \"1.0.0\", api: \"0.1\", file: \"calm.wasm\", limits: (time_s: 5))";

    fn message(text: &str) -> String {
        Manifest::read(text, Path::new("calm/plugin.ron")).unwrap_err().to_string()
    }

    #[test]
    fn a_manifest_is_read_with_its_defaults() {
        let manifest = Manifest::read(WHOLE, Path::new("plugin.ron")).unwrap();
        assert_eq!(manifest.limits, Limits { memory_mb: 512, time_s: 5.0 });
        let text = ron::to_string(&manifest).unwrap();
        assert_eq!(Manifest::read(&text, Path::new("plugin.ron")).unwrap(), manifest);
    }

    #[test]
    fn mistakes_name_the_file_the_place_and_the_cure() {
        assert!(message("(id: \"calm\",\n vresion: \"1\")").starts_with("calm/plugin.ron:2:"));
        assert!(
            message(&WHOLE.replace("\"calm\"", "\"Calm!\"")).contains("`id` is \"Calm!\"; it must be small letters")
        );
        assert!(message(&WHOLE.replace("calm.wasm", "../calm.wasm")).contains("beside the manifest"));
        assert!(message(&WHOLE.replace("time_s: 5", "time_s: 0")).contains("more than 0"));
        assert!(message(&WHOLE.replace("time_s: 5", "memory_mb: 9000")).contains("1 to 4096"));
    }
}
