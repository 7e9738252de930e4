//! How the program ends: exit codes, and troubles that keep a command from doing what it was asked.

use crate::{mistakes, output};
use graph_core::cook::CookError;
use graph_core::document::Diagnostics;
use graph_core::store::StoreError;
use std::io;
use std::process::ExitCode;

/// Exit codes, as scripts and farms read them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// All went well.
    Fine = 0,
    /// The graph is wrong, or a file that was asked about cannot be read.
    Wrong = 1,
    /// The command line is wrong.
    CommandLine = 2,
    /// Nodes failed.
    NodesFailed = 3,
    /// Ctrl-C, or a signal to end.
    Cancelled = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// What keeps a command from doing what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// The command line names something that does not exist.
    #[error("{message}")]
    CommandLine {
        /// What is wrong.
        message: String,
        /// The cure, where one is known.
        help: Option<String>,
    },
    /// The graph is wrong; its mistakes have been shown.
    #[error("the graph has {} mistakes", .0.0.len())]
    Graph(Diagnostics),
    /// A file of settings is wrong; its mistakes have been shown.
    #[error("the settings in {} are wrong", .0.display())]
    Settings(std::path::PathBuf),
    /// The store cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The cook could not run.
    #[error(transparent)]
    Cook(CookError),
    /// The snapshot cannot be read or written.
    #[error(transparent)]
    Golden(#[from] graph_core::snapshot::GoldenError),
    /// A value that was cooked cannot be looked at.
    #[error(transparent)]
    Look(#[from] graph_core::cook::LookError),
    /// The page of a report cannot be made.
    #[error(transparent)]
    Report(Box<report::ReportError>),
    /// A plugin cannot be used, built or pinned.
    #[error("{0}")]
    Plugin(String),
    /// A file for people cannot be written.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file.
        path: std::path::PathBuf,
        /// What went wrong.
        problem: io::Error,
    },
    /// Standard output cannot be written.
    #[error("standard output cannot be written: {0}")]
    Output(#[from] io::Error),
    /// The handler of Ctrl-C could not be set.
    #[error("Ctrl-C could not be taken care of: {0}")]
    Signals(#[from] ctrlc::Error),
}

impl From<CookError> for Trouble {
    fn from(error: CookError) -> Self {
        match error {
            CookError::UnknownNode(diagnostic) => {
                Self::CommandLine { message: format!("--only: {}", diagnostic.message), help: diagnostic.help }
            }
            other => Self::Cook(other),
        }
    }
}

impl Trouble {
    /// A wrong command line.
    pub fn command_line(message: impl Into<String>, help: Option<String>) -> Self {
        Self::CommandLine { message: message.into(), help }
    }

    /// Something about a plugin.
    #[cfg(feature = "plugins")]
    pub fn plugin(problem: impl std::fmt::Display) -> Self {
        Self::Plugin(problem.to_string())
    }

    /// Shows the trouble on standard error, and gives the exit code.
    pub fn tell(&self) -> Exit {
        match self {
            // Whoever read the output has had enough of it.
            Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => return Exit::Fine,
            Self::Graph(found) => return mistakes::exit(found),
            Self::Settings(_) => return Exit::CommandLine,
            Self::CommandLine { help, .. } => output::error(&self.to_string(), help.as_deref()),
            _ => output::error(&self.to_string(), None),
        }
        match self {
            Self::Cook(_) | Self::Look(_) | Self::Report(_) => Exit::NodesFailed,
            Self::Golden(_) | Self::Plugin(_) => Exit::Wrong,
            _ => Exit::CommandLine,
        }
    }
}
