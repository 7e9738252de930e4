//! How an engine is asked to cook, and why it could not cook at all.

use crate::document::Diagnostic;
use crate::files::Gate;
use crate::store::StoreError;
use std::sync::Arc;
use wire::Digest;

/// How to cook.
#[derive(Debug, Clone)]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub struct Options {
    /// Threads; 0 means one for each core.
    pub jobs: usize,
    /// Bytes of memory that the cook may take; none means most of what the machine has.
    pub memory_bytes: Option<u64>,
    /// Frames in a block.
    pub block_frames: usize,
    /// Only these nodes and what they need; empty means all.
    pub only: Vec<String>,
    /// Only say what would be cooked.
    pub dry: bool,
    /// Whether values stay in memory after a cook, for the next one of the same engine.
    pub resident: bool,
    /// Whether results are kept that are computed again in less time than they would be read.
    pub keep_cheap: bool,
    /// Whether the files that nodes make are put in their places.
    pub publish: bool,
    /// The session to go on from, and to write; the graph's own where none is given.
    pub session: Option<Digest>,
    /// Which files may be read; all where there is none.
    pub gate: Option<Arc<Gate>>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            jobs: 0,
            memory_bytes: None,
            block_frames: super::BLOCK_FRAMES,
            only: Vec::new(),
            dry: false,
            resident: false,
            keep_cheap: false,
            publish: true,
            session: None,
            gate: None,
        }
    }
}

/// Why a cook could not run at all. Failures of nodes are no such error: they are told as events.
#[derive(Debug, thiserror::Error)]
pub enum CookError {
    /// `only` names something that is not in the graph.
    #[error("{}", .0.message)]
    UnknownNode(Box<Diagnostic>),
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The threads could not be started.
    #[error("the pool of threads could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
