//! What the tests of nodes share: an engine that is not there, and the way to test data.

use graph_core::node::{Context, Host, Inputs, Node, NodeError, Outputs, SourceFile};
use sample_head::SampleHead;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock, Mutex};

/// A coarse procedural head with a short range of motion.
pub(crate) static HEAD: LazyLock<SampleHead> = LazyLock::new(|| {
    let options = sample_head::Options { density: 0.5, motion_frames: 600, ..Default::default() };
    sample_head::build(&options).unwrap()
});

/// The engine's side of a context: files from memory, progress kept, checkpoints kept.
#[derive(Debug, Default)]
pub(crate) struct Bench {
    source: Option<SourceFile>,
    siblings: BTreeMap<String, Arc<Vec<u8>>>,
    checkpoints: Mutex<BTreeMap<String, Vec<u8>>>,
    progress: Mutex<Vec<f64>>,
    cancelled: AtomicBool,
    cancel_after: Option<usize>,
    reports: AtomicUsize,
}

impl Bench {
    /// With `bytes` as the source file, under the name `name`.
    pub fn with_source(mut self, name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        self.source = Some(SourceFile { name: name.to_owned(), bytes: Arc::new(bytes.into()) });
        self
    }

    /// With a file beside the source file.
    pub fn with_sibling(mut self, name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        self.siblings.insert(name.to_owned(), Arc::new(bytes.into()));
        self
    }

    /// Cancels once the node has reported progress so many times; 0 is from the start.
    pub fn cancelled_after(mut self, reports: usize) -> Self {
        self.cancel_after = Some(reports);
        self.cancelled = AtomicBool::new(reports == 0);
        self
    }

    /// A later cook, which finds the checkpoints of this one.
    pub fn resumed(&self) -> Self {
        Self { checkpoints: Mutex::new(self.checkpoints.lock().unwrap().clone()), ..Self::default() }
    }

    /// Computes `node`.
    pub fn compute(&self, node: &dyn Node, inputs: &Inputs) -> Result<Outputs, NodeError> {
        node.compute(&Context::new(self, &self.cancelled, ""), inputs)
    }

    /// The fractions reported so far.
    pub fn fractions(&self) -> Vec<f64> {
        self.progress.lock().unwrap().clone()
    }
}

impl Host for Bench {
    fn memory_bytes(&self) -> u64 {
        1 << 30
    }

    fn progress(&self, fraction: f64, _: &[(&str, f64)]) {
        self.progress.lock().unwrap().push(fraction);
        let reports = self.reports.fetch_add(1, Ordering::Relaxed) + 1;
        if self.cancel_after.is_some_and(|limit| reports >= limit) {
            self.cancelled.store(true, Ordering::Relaxed);
        }
    }

    fn source(&self) -> Result<SourceFile, NodeError> {
        self.source.clone().ok_or_else(|| NodeError::failed("this node has no source file"))
    }

    fn sibling(&self, name: &str) -> Result<Arc<Vec<u8>>, NodeError> {
        self.siblings.get(name).cloned().ok_or_else(|| NodeError::file(name, "there is no such file"))
    }

    fn checkpoint(&self, name: &str) -> Option<Vec<u8>> {
        self.checkpoints.lock().unwrap().get(name).cloned()
    }

    fn save_checkpoint(&self, name: &str, state: &[u8]) {
        self.checkpoints.lock().unwrap().insert(name.to_owned(), state.to_vec());
    }
}

/// Computes a node that reads no files.
pub(crate) fn compute(node: &dyn Node, inputs: &Inputs) -> Result<Outputs, NodeError> {
    Bench::default().compute(node, inputs)
}

/// A node of the kind whose parameters are `T`, made from JSON as graphs make it.
pub(crate) fn made<T: serde::de::DeserializeOwned>(parameters: serde_json::Value) -> T {
    serde_json::from_value(parameters).unwrap()
}

/// Where a real test input lies; `None`, said loudly, where this machine has none. Where
/// `GRIMACE_TEST_DATA` names a folder that lacks it, that is a failure.
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
pub(crate) fn test_data(relative: &str) -> Option<PathBuf> {
    let root = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let path = root.join(relative);
    if path.exists() {
        return Some(path);
    }
    assert!(std::env::var_os("GRIMACE_TEST_DATA").is_none(), "{} is missing; set GRIMACE_TEST_DATA", path.display());
    eprintln!("SKIPPED: {} is missing; set GRIMACE_TEST_DATA to run this test", path.display());
    None
}
