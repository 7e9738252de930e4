//! Why a chore could not be done, or found something wrong.

use std::path::PathBuf;

/// Why a chore could not be done, or found something wrong.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// There is no such chore.
    #[error("{0}")]
    Usage(String),
    /// A chore cannot be done as it was asked for.
    #[error("{0}")]
    CommandLine(String),
    /// A program could not be started, or ended badly.
    #[error("`{command}` {problem}")]
    Command {
        /// The program with its arguments.
        command: String,
        /// What became of it.
        problem: String,
    },
    /// A file could not be read or written.
    #[error("{path}: {problem}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        problem: std::io::Error,
    },
    /// Something is not as it should be; each line is one finding.
    #[error("{}", .0.join("\n"))]
    Findings(Vec<String>),
    /// Checks failed that have already said what is wrong.
    #[error("checks failed")]
    Checks,
}
