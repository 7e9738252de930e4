//! What can go wrong with plugins: while one is made ready, and while one of its nodes computes.

use crate::manifest::ManifestError;
use crate::schema::SchemaError;
use graph_core::node::NodeError;
use std::path::PathBuf;

/// Why a plugin cannot be used.
#[derive(Debug, Clone, thiserror::Error)]
pub enum LoadError {
    /// Its `plugin.ron` is wrong.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// A file of it cannot be read.
    #[error("{}: {problem}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        problem: String,
    },
    /// Its component is not the one that the manifest was written for.
    #[error(
        "{} has the SHA-256 {found}, and its plugin.ron says {expected}; `grimace plugin build` writes both, or mend `sha256`",
        file.display()
    )]
    Digest {
        /// The component.
        file: PathBuf,
        /// What the manifest says.
        expected: String,
        /// What the file has.
        found: String,
    },
    /// It is no valid component.
    #[error("plugin `{plugin}`: its component is damaged or no component: {problem}")]
    Component {
        /// The plugin.
        plugin: String,
        /// What the validator found.
        problem: String,
    },
    /// It wants more than the interface offers.
    #[error(
        "plugin `{plugin}` imports {}, which plugins are not given; they reach nothing but `grimace:node/host`: build it without",
        imports.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
    )]
    Imports {
        /// The plugin.
        plugin: String,
        /// The imports.
        imports: Vec<String>,
    },
    /// It speaks another version of the interface.
    #[error("plugin `{plugin}` speaks the interface {found}; this program speaks {supported}: {}", cure(found))]
    Interface {
        /// The plugin.
        plugin: String,
        /// What it exports or imports.
        found: String,
        /// What there is.
        supported: String,
    },
    /// It describes its nodes in a way that cannot be.
    #[error("plugin `{plugin}`: {problem}")]
    Schema {
        /// The plugin.
        plugin: String,
        /// What is wrong.
        problem: SchemaError,
    },
    /// It could not be run to describe its nodes.
    #[error(transparent)]
    Run(#[from] RunError),
}

fn cure(found: &str) -> &'static str {
    if found == "no `grimace:node/nodes`" {
        "build it against the interface in plugins/wit"
    } else {
        "build it against one of these, or update grimace"
    }
}

/// Why a plugin's node gave nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// The cook was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// It took too long.
    #[error("plugin `{plugin}` ran longer than the {seconds} s that `limits.time_s` of its plugin.ron allows{frames}")]
    Time {
        /// The plugin.
        plugin: String,
        /// Seconds allowed.
        seconds: f64,
        /// Where it was.
        frames: String,
    },
    /// It asked for too much memory.
    #[error(
        "plugin `{plugin}` asked for {wanted_mb} MiB of memory (it had {had_mb}); `limits.memory_mb` of its plugin.ron allows {limit_mb}"
    )]
    Memory {
        /// The plugin.
        plugin: String,
        /// MiB asked for.
        wanted_mb: u64,
        /// MiB it had.
        had_mb: u64,
        /// MiB allowed.
        limit_mb: u64,
    },
    /// It asked for too large a table.
    #[error("plugin `{plugin}` asked for a table of {wanted} entries; plugins may have {limit}")]
    Table {
        /// The plugin.
        plugin: String,
        /// Entries asked for.
        wanted: usize,
        /// Entries allowed.
        limit: usize,
    },
    /// It called itself too deep.
    #[error("plugin `{plugin}` overflowed its stack of 512 KiB{frames}")]
    Stack {
        /// The plugin.
        plugin: String,
        /// Where it was.
        frames: String,
    },
    /// It trapped, after saying something or not.
    #[error("plugin `{plugin}` {}{frames}", panic.as_ref().map_or_else(|| format!("trapped: {trap}"), |said| format!("panicked: {said}")))]
    Trap {
        /// The plugin.
        plugin: String,
        /// The kind of trap.
        trap: String,
        /// What it said last, where it panicked.
        panic: Option<String>,
        /// Where it was.
        frames: String,
    },
    /// What it gave is not what its schema says.
    #[error("plugin `{plugin}` gave {problem}")]
    Gave {
        /// The plugin.
        plugin: String,
        /// What is wrong with it.
        problem: String,
    },
    /// It says itself that an input is wrong.
    #[error("input `{name}`: {problem}")]
    Input {
        /// The input.
        name: String,
        /// What the plugin says.
        problem: String,
    },
    /// It says itself that a parameter is wrong.
    #[error("parameter `{name}`: {problem}")]
    Parameter {
        /// The parameter.
        name: String,
        /// What the plugin says.
        problem: String,
    },
    /// It says itself that it failed.
    #[error("plugin `{plugin}`: {problem}")]
    Failed {
        /// The plugin.
        plugin: String,
        /// What the plugin says.
        problem: String,
    },
    /// The engine could not run it.
    #[error("plugin `{plugin}` could not be run: {problem}")]
    Engine {
        /// The plugin.
        plugin: String,
        /// What the engine says.
        problem: String,
    },
}

impl From<RunError> for NodeError {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Cancelled => Self::Cancelled,
            RunError::Input { name, problem } => Self::Input { port: name, problem },
            RunError::Parameter { name, problem } => Self::Parameter { parameter: name, problem },
            other => Self::Failed(other.to_string()),
        }
    }
}
