//! For authors: from sources to a component beside its `plugin.ron`, and new plugins to start from.

mod compile;
mod component;
mod new;

pub use compile::{Built, build, missing_tools};
pub use component::{INTERFACE, component};
pub use new::{Language, new};

use std::path::PathBuf;

/// Why a plugin could not be built or begun.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A tool that the language needs is not there.
    #[error("{language} plugins are built with {tool}, which this machine has not: {cure}")]
    Tool {
        /// The language.
        language: &'static str,
        /// The tool.
        tool: String,
        /// How to get it.
        cure: &'static str,
    },
    /// A tool failed.
    #[error("`{command}` failed:\n{output}")]
    Failed {
        /// The command.
        command: String,
        /// What it wrote.
        output: String,
    },
    /// What the compiler gave is no plugin.
    #[error("what was compiled is no plugin: {problem}")]
    Component {
        /// What is wrong.
        problem: String,
    },
    /// A file could not be read or written.
    #[error("{}: {problem}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        problem: String,
    },
    /// The manifest is wrong.
    #[error(transparent)]
    Manifest(#[from] crate::ManifestError),
    /// The manifest says nothing of how to build it.
    #[error("{}: `build` is {found}; it must be rust, c, zig, assemblyscript or wat", file.display())]
    Language {
        /// The manifest.
        file: PathBuf,
        /// What it says.
        found: String,
    },
    /// There is something already.
    #[error("{} is there already; choose another name, or take it away", folder.display())]
    There {
        /// The folder.
        folder: PathBuf,
    },
    /// The name cannot be a plugin's.
    #[error("{name:?} cannot be the id of a plugin: small letters, digits, `-` and `_`, the first a letter")]
    Name {
        /// The name.
        name: String,
    },
}
