//! What a node may ask of the engine while it computes.

use super::NodeError;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A file as the engine hands it to a node.
#[derive(Debug, Clone)]
pub struct SourceFile {
    /// Name of the file without its folder.
    pub name: String,
    /// Its content.
    pub bytes: Arc<Vec<u8>>,
}

/// The engine's side of a [`Context`]: where progress goes and files come from.
pub trait Host: Sync {
    /// Bytes of memory that the node may take.
    fn memory_bytes(&self) -> u64;

    /// Whether nobody asks for the result of the running node any more.
    fn stale(&self) -> bool {
        false
    }

    /// Progress of the running node: fraction done, and named numbers such as a loss.
    fn progress(&self, fraction: f64, numbers: &[(&str, f64)]);

    /// The node's source file.
    ///
    /// # Errors
    /// Where the node has none, or it cannot be read.
    fn source(&self) -> Result<SourceFile, NodeError>;

    /// A file beside the node's source file, by relative name; the engine notes that it was read.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn sibling(&self, name: &str) -> Result<Arc<Vec<u8>>, NodeError>;

    /// A saved state of this very computation from a cook that was cut short.
    fn checkpoint(&self, name: &str) -> Option<Vec<u8>>;

    /// Saves a state of this computation, to go on from should the cook be cut short.
    fn save_checkpoint(&self, name: &str, state: &[u8]);
}

/// What a computing node sees of the engine.
pub struct Context<'a> {
    host: &'a dyn Host,
    cancelled: &'a AtomicBool,
    item: &'a str,
}

impl<'a> Context<'a> {
    /// A context over `host`; `item` is the name of the item being cooked, empty outside of lists.
    pub fn new(host: &'a dyn Host, cancelled: &'a AtomicBool, item: &'a str) -> Self {
        Self { host, cancelled, item }
    }

    /// Reports how far the node is, 0 to 1, with named numbers such as `("loss", 0.01)`.
    pub fn progress(&self, fraction: f64, numbers: &[(&str, f64)]) {
        self.host.progress(fraction, numbers);
    }

    /// Whether the cook was cancelled; long loops ask at least every 100 ms.
    pub fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed) || self.host.stale()
    }

    /// Leaves the computation where the cook was cancelled.
    ///
    /// # Errors
    /// [`NodeError::Cancelled`] once the cook was cancelled.
    pub fn go_on(&self) -> Result<(), NodeError> {
        if self.cancelled() { Err(NodeError::Cancelled) } else { Ok(()) }
    }

    /// Says that the node is about to take `bytes` of memory because of what `parameter` asks for. Nodes say so of what
    /// grows with a parameter, before they take it.
    ///
    /// # Errors
    /// Where it is more than the cook may take.
    pub fn claim(&self, parameter: &str, bytes: usize) -> Result<(), NodeError> {
        let budget_bytes = self.host.memory_bytes();
        if bytes as u64 <= budget_bytes {
            return Ok(());
        }
        Err(NodeError::Memory { parameter: parameter.to_owned(), bytes: bytes as u64, budget_bytes })
    }

    /// Name of the item being cooked (a take's name), empty outside of lists. It is no part of the key: use it
    /// for messages only.
    pub fn item(&self) -> &str {
        self.item
    }

    /// The file that the node's `reads` parameter names.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn source(&self) -> Result<SourceFile, NodeError> {
        self.host.source()
    }

    /// A file beside the source file, by relative name. It becomes part of what the result depends on.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn sibling(&self, name: &str) -> Result<Arc<Vec<u8>>, NodeError> {
        self.host.sibling(name)
    }

    /// A saved state called `name` from an earlier cook of this very computation that was cut short.
    pub fn checkpoint(&self, name: &str) -> Option<Vec<u8>> {
        self.host.checkpoint(name)
    }

    /// Saves a state called `name` to go on from, should this cook be cut short.
    pub fn save_checkpoint(&self, name: &str, state: &[u8]) {
        self.host.save_checkpoint(name, state);
    }
}
