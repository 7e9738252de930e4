//! The kinds that one graph may name: those linked into the program, and those that catalogues find for it.
//!
//! A crate that brings kinds (plugins beside the graph, say) submits a [`Bringer`]: `submit_bringer!(Plugins);`. What it
//! brings depends on the graph, so each loading of a graph opens catalogues of its own. Nothing is looked for before a graph
//! names a kind that is not linked.

use super::registry::{self, Kind};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use wire::Digest;

/// Opens catalogues of kinds for graphs.
pub trait Bringer: Sync {
    /// The catalogue for the graph at `graph`; `variable` gives variables of the environment, and notes that they were
    /// asked for.
    fn open(&self, graph: &Path, variable: &dyn Fn(&str) -> Option<String>) -> Arc<dyn Catalogue>;
}

/// Kinds that were found for one graph. They are kept for as long as the program runs.
pub trait Catalogue: std::fmt::Debug + Send + Sync {
    /// The kind called `name`; `None` where the catalogue knows nothing of it.
    fn kind(&self, name: &str) -> Option<Result<&'static Kind, NoKind>>;

    /// The names of all kinds that can be had.
    fn names(&self) -> Vec<&'static str>;

    /// What the kinds asked for so far came from.
    fn grounds(&self) -> Grounds;
}

/// Why a kind that a catalogue knows cannot be had.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoKind {
    /// Code of the mistake, such as `broken-plugin`.
    pub code: &'static str,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// What kinds came from: where any of it differs, a graph is to be loaded anew.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Grounds {
    /// Files that were read, with what they held.
    pub files: BTreeMap<PathBuf, Digest>,
    /// Folders that were listed, with the folders in them; none where there is no such folder.
    pub folders: BTreeMap<PathBuf, Vec<String>>,
}

/// The names of the folders in `folder`, in order; none where there is no such folder.
pub fn folders_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let folders = entries.filter(|entry| entry.path().is_dir());
    let mut names: Vec<String> = folders.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A [`Bringer`] as programs link it.
pub struct Linked(pub &'static dyn Bringer);

inventory::collect!(Linked);

/// Lets every program that links this crate ask a [`Bringer`] for kinds: `submit_bringer!(Plugins);`.
#[macro_export]
macro_rules! submit_bringer {
    ($bringer:expr) => {
        $crate::inventory::submit! { $crate::node::Linked(&$bringer) }
    };
}

/// The JSON schemas of parameters, by kind. Kinds live as long as the program, so their places name them.
static SCHEMAS: LazyLock<Mutex<BTreeMap<usize, &'static serde_json::Value>>> = LazyLock::new(Mutex::default);

/// The kinds that a graph may name.
#[derive(Debug, Clone, Default)]
pub struct Kinds {
    catalogues: Vec<Arc<dyn Catalogue>>,
}

impl Kinds {
    /// The kinds for the graph at `graph`.
    pub fn of_graph(graph: &Path, variable: &dyn Fn(&str) -> Option<String>) -> Self {
        let open = |linked: &Linked| linked.0.open(graph, variable);
        Self { catalogues: inventory::iter::<Linked>.into_iter().map(open).collect() }
    }

    /// The linked kinds and those of `catalogues`.
    pub fn with(catalogues: Vec<Arc<dyn Catalogue>>) -> Self {
        Self { catalogues }
    }

    /// The kind called `name`.
    ///
    /// # Errors
    /// `None` where there is no such kind, or why it cannot be had.
    pub fn find(&self, name: &str) -> Result<&'static Kind, Option<NoKind>> {
        if let Some(kind) = registry::kind(name) {
            return Ok(kind);
        }
        match self.catalogues.iter().find_map(|catalogue| catalogue.kind(name)) {
            Some(found) => found.map_err(Some),
            None => Err(None),
        }
    }

    /// The kind called `name`, where it can be had.
    pub fn get(&self, name: &str) -> Option<&'static Kind> {
        self.find(name).ok()
    }

    /// The names of all kinds.
    pub fn names(&self) -> Vec<&'static str> {
        let linked = registry::kinds().map(|(name, _)| name);
        linked.chain(self.catalogues.iter().flat_map(|catalogue| catalogue.names())).collect()
    }

    /// All kinds that can be had.
    pub fn all(&self) -> Vec<(&'static str, &'static Kind)> {
        let brought = self.catalogues.iter().flat_map(|catalogue| catalogue.names());
        registry::kinds().chain(brought.filter_map(|name| Some((name, self.get(name)?)))).collect()
    }

    /// The JSON schema of a kind's parameters.
    pub(crate) fn schema(kind: &'static Kind) -> &'static serde_json::Value {
        let mut known = SCHEMAS.lock().unwrap_or_else(PoisonError::into_inner);
        known.entry(std::ptr::from_ref(kind) as usize).or_insert_with(|| Box::leak(Box::new(kind.schema())))
    }

    /// What the kinds asked for so far came from.
    pub fn grounds(&self) -> Grounds {
        let mut all = Grounds::default();
        for catalogue in &self.catalogues {
            let grounds = catalogue.grounds();
            all.files.extend(grounds.files);
            all.folders.extend(grounds.folders);
        }
        all
    }
}
