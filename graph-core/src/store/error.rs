//! Why the store could not be used: what was to be done, where, and the cure.

use std::io::{self, ErrorKind};
use std::path::PathBuf;

/// Why the store could not be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A folder or file of the store could not be written.
    #[error("the store at {store} cannot be written: {} ({problem}); {}", file.display(), cure(problem, store))]
    Write {
        /// The store.
        store: PathBuf,
        /// What was to be written.
        file: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// A graph that should be pinned has no session.
    #[error("no cook of {graph} is remembered in {store}, so there is nothing to pin; cook it first, with this store")]
    NeverCooked {
        /// The graph.
        graph: PathBuf,
        /// The store.
        store: PathBuf,
    },
    /// What a pinned graph needs cannot be told, so nothing may be removed.
    #[error(
        "what the pinned graph {graph} needs cannot be told, since its session {session} is gone, damaged or of another version \
         of grimace; nothing was removed: cook the graph again, or take its pin away with `grimace cache unpin {graph}`"
    )]
    PinnedUnknown {
        /// The graph, as it was named when it was pinned.
        graph: String,
        /// The session's file.
        session: PathBuf,
    },
}

/// What helps against `problem`.
fn cure(problem: &io::Error, store: &std::path::Path) -> String {
    let elsewhere = "set another place with --store, GRIMACE_STORE or `store` in a grimace.ron";
    match problem.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => format!(
            "make room, for example with `grimace cache gc --keep 10GB --store {}`, or {elsewhere}",
            store.display()
        ),
        ErrorKind::ReadOnlyFilesystem => format!("what stands there is untouched; {elsewhere}"),
        ErrorKind::PermissionDenied => format!("ask for the right to write there, or {elsewhere}"),
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            format!("something that is no folder stands in its way: remove it, or {elsewhere}")
        }
        _ => format!("make room, or {elsewhere}"),
    }
}
