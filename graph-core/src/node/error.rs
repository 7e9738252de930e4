//! Why a node could not compute.

use wire::AxisError;

/// Why a node could not compute. Messages are for the person who wrote the graph: what, where, and the cure.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// Something is wrong with the value on an input.
    #[error("input `{port}`: {problem}")]
    Input {
        /// The port.
        port: String,
        /// What is wrong.
        problem: String,
    },
    /// A parameter's value does not fit the inputs.
    #[error("parameter `{parameter}`: {problem}")]
    Parameter {
        /// The parameter.
        parameter: String,
        /// What is wrong.
        problem: String,
    },
    /// A parameter asks for more memory than the cook may take.
    #[error(
        "parameter `{parameter}`: this takes {} of memory, and the cook may take {}; lower it, or raise `--memory`",
        gigabytes(*bytes),
        gigabytes(*budget_bytes)
    )]
    Memory {
        /// The parameter.
        parameter: String,
        /// Bytes that it asks for.
        bytes: u64,
        /// Bytes that the cook may take.
        budget_bytes: u64,
    },
    /// A file could not be read or is damaged.
    #[error("{file}: {problem}")]
    File {
        /// The file, as the graph names it.
        file: String,
        /// What is wrong, with its place.
        problem: String,
    },
    /// The computation itself found no answer.
    #[error("{0}")]
    Failed(String),
    /// The cook was cancelled.
    #[error("cancelled")]
    Cancelled,
}

fn gigabytes(bytes: u64) -> String {
    match bytes as f64 / 1e9 {
        large if large >= 0.0995 => format!("{large:.1} GB"),
        small => format!("{:.1} MB", small * 1e3),
    }
}

impl NodeError {
    /// Something is wrong with the value on `port`.
    pub fn input(port: &str, problem: impl std::fmt::Display) -> Self {
        Self::Input { port: port.to_owned(), problem: problem.to_string() }
    }

    /// The value of `parameter` does not fit the inputs.
    pub fn parameter(parameter: &str, problem: impl std::fmt::Display) -> Self {
        Self::Parameter { parameter: parameter.to_owned(), problem: problem.to_string() }
    }

    /// `file` could not be read.
    pub fn file(file: &str, problem: impl std::fmt::Display) -> Self {
        Self::File { file: file.to_owned(), problem: problem.to_string() }
    }

    /// The computation found no answer.
    pub fn failed(problem: impl std::fmt::Display) -> Self {
        Self::Failed(problem.to_string())
    }
}

impl From<AxisError> for NodeError {
    fn from(error: AxisError) -> Self {
        Self::Failed(error.to_string())
    }
}
