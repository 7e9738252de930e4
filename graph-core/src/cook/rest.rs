//! Rest: what a cook looked at and found, so that the next process can tell by one file and a look at the metadata of each
//! source that nothing changed, without reading the graph. Where it cannot tell so, the graph is cooked as usual.

use super::cell::State;
use super::engine::Engine;
use super::event::{Event, Summary};
use super::options::Options;
use super::session::session_name;
use crate::document::Override;
use crate::files::{Fingerprint, Pattern, Signature};
use crate::node::folders_in;
use crate::store::{Store, StoreError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use wire::{Digest, Hasher};

/// A graph as a cook left it, with everything that the cook depended on.
#[derive(Debug, Serialize, Deserialize)]
pub struct Rest {
    /// How the cook was asked for, and of which program.
    asked: Digest,
    /// Variables of the environment that the graph refers to.
    variables: BTreeMap<String, Option<String>>,
    /// Graph files and source files.
    files: BTreeMap<PathBuf, Fingerprint>,
    /// What patterns matched, by item.
    lists: BTreeMap<PathBuf, BTreeMap<String, PathBuf>>,
    /// Folders in which kinds were looked for, with the folders in them.
    folders: BTreeMap<PathBuf, Vec<String>>,
    /// Written files, each with a sidecar.
    written: BTreeMap<PathBuf, Signature>,
    kinds: Vec<String>,
    /// Name, position of the kind, and number of blocks of each cell.
    cells: Vec<(String, usize, usize)>,
    /// Seconds that it took to find that all of this still holds.
    #[serde(skip)]
    seconds: f64,
}

impl Rest {
    /// The graph at `graph` at rest: what its last cook depended on is as it was, so that a cook that is asked for in the same
    /// way would compute and write nothing. `None` where that is not so, or cannot be told so quickly.
    pub fn find(store: &Store, graph: &Path, overrides: &[Override], options: &Options) -> Option<Self> {
        let start = Instant::now();
        let found: Self = store.rest(&session_name(store, graph))?;
        let found = (found.asked == asked(graph, overrides, options)? && found.holds()).then_some(found)?;
        Some(Self { seconds: start.elapsed().as_secs_f64(), ..found })
    }

    fn holds(&self) -> bool {
        let variable = |name: &str| std::env::var(name).ok();
        let listed = |pattern: &Path| Pattern::new(pattern).files().ok();
        self.variables.iter().all(|(name, value)| variable(name) == *value)
            && self.files.iter().all(|(path, fingerprint)| fingerprint.still_true(path))
            && self.lists.iter().all(|(pattern, files)| listed(pattern).as_ref() == Some(files))
            && self.folders.iter().all(|(path, names)| folders_in(path) == *names)
            && self.written.iter().all(|(path, signature)| super::publish::stands(path, signature))
    }

    /// Tells of a cook in which every cell was up to date.
    pub fn tell(self, tell: &dyn Fn(Event)) -> Summary {
        let mut summary = Summary { cached: self.cells.len(), seconds: self.seconds, ..Summary::default() };
        tell(Event::Planned { cells: self.cells.len() });
        for (node, kind, blocks) in self.cells {
            summary.blocks_cached += blocks;
            tell(Event::Cached { node, kind: self.kinds.get(kind).cloned().unwrap_or_default(), blocks });
        }
        tell(Event::Summary(summary.clone()));
        summary
    }
}

/// How a cook is asked for: everything beside files that its result depends on. The program is known by its file, so that a
/// new build of it, whose nodes may differ, looks at everything anew.
fn asked(graph: &Path, overrides: &[Override], options: &Options) -> Option<Digest> {
    let program = Signature::of(&std::env::current_exe().ok()?).ok()?;
    let mut hasher = Hasher::new("asked");
    for part in [graph, &std::env::current_dir().ok()?] {
        hasher.bytes(part.as_os_str().as_encoded_bytes());
    }
    hasher.number(program.size).number(program.inode);
    hasher.bytes(&program.modified_ns.to_le_bytes()).bytes(&program.changed_ns.to_le_bytes());
    hasher.number(options.block_frames as u64).number(overrides.len() as u64);
    for text in overrides.iter().map(|set| &set.text).chain(&options.only) {
        hasher.bytes(text.as_bytes());
    }
    Some(hasher.finish())
}

impl Engine {
    /// Writes down what this cook depended on, where all of it went well and can be known again by its metadata.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn come_to_rest(&self) -> Result<(), StoreError> {
        match self.rest() {
            Some(rest) => {
                let store = &self.shared.store;
                store.put_rest(&session_name(store, &self.plan.root().path), &rest)
            }
            None => Ok(()),
        }
    }

    fn rest(&self) -> Option<Rest> {
        let well = self.folded.is_empty() && self.cells.iter().all(|cell| matches!(cell.state, State::Done(_)));
        let asked = asked(&self.plan.root().path, &self.overrides, &self.options).filter(|_| well)?;
        let mut files = BTreeMap::new();
        for source in &self.plan.sources {
            let digest = self.shared.files.digest(&source.path).ok()?;
            // Edited while it was cooked.
            if digest != Digest::of(source.text.as_bytes()) {
                return None;
            }
            files.insert(source.path.clone(), self.shared.files.get(&source.path)?);
        }
        let grounds = self.plan.kinds().grounds();
        for (path, digest) in grounds.files {
            // Changed while it was cooked.
            if self.shared.files.digest(&path).ok()? != digest {
                return None;
            }
            let fingerprint = self.shared.files.get(&path)?;
            files.insert(path, fingerprint);
        }
        let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
        let (mut cells, mut written) = (Vec::with_capacity(self.cells.len()), BTreeMap::new());
        for (id, cell) in self.cells.iter().enumerate() {
            let folder = cell.file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
            let read = cell.reads.iter().map(|(name, _)| folder.join(name));
            for file in cell.file.iter().cloned().chain(read) {
                let fingerprint = self.shared.files.get(&file)?;
                files.insert(file, fingerprint);
            }
            if let Some(path) = &cell.writes {
                written.insert(path.clone(), self.written(id)?);
            }
            let next = kinds.len();
            let kind = *kinds.entry(&self.plan.nodes[cell.plan].kind).or_insert(next);
            cells.push((cell.name.clone(), kind, cell.made.block_keys.len()));
        }
        if !files.values().all(Fingerprint::trusted) {
            return None;
        }
        let mut names = vec![String::new(); kinds.len()];
        for (kind, place) in kinds {
            kind.clone_into(&mut names[place]);
        }
        let (variables, lists) = (self.plan.environment.asked(), self.listed.clone());
        let folders = grounds.folders;
        Some(Rest { asked, variables, files, lists, folders, written, kinds: names, cells, seconds: 0.0 })
    }
}
