//! Changes while a cook runs: files that came, went or differ, another plan. A cook takes them in as soon as what it is doing
//! allows: it makes its cells anew (`refold`), and computations in the making go on where they are still asked for (`carry`).

use super::cell::CellId;
use super::cost::Costs;
use super::engine::Engine;
use super::options::{CookError, Options};
use super::results::Message;
use crate::files::Pattern;
use crate::plan::{OriginId, Plan};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::mpsc::Sender;
use wire::Digest;

/// Something that changed.
#[derive(Debug)]
pub enum Change {
    /// Source files may have come, gone, or have other content.
    Files,
    /// The graph says something else.
    Plan(Box<Plan>),
    /// What failed should be tried again.
    Retry,
}

/// What comes to the coordinating thread.
pub(crate) enum Mail {
    /// A job of the cells that were made in `generation` tells something.
    Result {
        generation: u64,
        /// The number of the task that it belongs to.
        task: Option<u64>,
        message: Message,
    },
    Change(Change),
}

/// Where changes are told to an engine, from any thread.
#[derive(Debug, Clone)]
pub struct Changes(Sender<Mail>);

impl Changes {
    /// Tells a change; a cook that runs takes it in, else the next one.
    pub fn tell(&self, change: Change) {
        // Nobody cooks any more where the engine is gone.
        let _ = self.0.send(Mail::Change(change));
    }
}

/// The files that a graph was seen to depend on.
#[derive(Debug, Clone, Default)]
pub struct Seen {
    /// Patterns whose matches are items.
    pub patterns: BTreeSet<PathBuf>,
    /// Single files, those beside them that were read included.
    pub files: BTreeSet<PathBuf>,
}

/// Plan nodes that `options` ask for, in their order.
pub(super) fn wanted(plan: &Plan, options: &Options) -> Result<Vec<usize>, CookError> {
    let mut named = Vec::new();
    for name in &options.only {
        let found = plan.find(name);
        if found.is_empty() {
            return Err(CookError::UnknownNode(Box::new(plan.unknown_node(name))));
        }
        named.extend(found);
    }
    let marked = plan.with_ancestors(&named);
    Ok((0..plan.nodes.len()).filter(|node| named.is_empty() || marked[*node]).collect())
}

/// The list outputs of plan nodes over which others repeat.
pub(super) fn list_origins(plan: &Plan) -> HashMap<usize, Vec<OriginId>> {
    let mut lists: HashMap<usize, Vec<OriginId>> = HashMap::new();
    for (index, origin) in plan.origins.iter().enumerate().filter(|(_, origin)| origin.port.is_some()) {
        lists.entry(origin.node).or_default().push(index);
    }
    lists
}

impl Engine {
    /// Where changes are told to this engine.
    pub fn changes(&self) -> Changes {
        Changes(self.shared.sender.clone())
    }

    /// How many changes were taken in so far.
    pub fn changes_taken(&self) -> u64 {
        self.changes_taken
    }

    pub(super) fn take_change(&mut self, change: Change) {
        self.changes_taken += 1;
        match change {
            Change::Files => {}
            Change::Plan(plan) => self.next_plan = Some(plan),
            Change::Retry => self.failures.clear(),
        }
        self.items_changed = true;
    }

    /// Takes in what was told since the last cook.
    pub(super) fn take_changes(&mut self) {
        while let Ok(mail) = self.receiver.try_recv() {
            if let Mail::Change(change) = mail {
                self.take_change(change);
            }
        }
    }

    /// Puts the plan that waits in the place of this one. Only between folding and unfolding.
    pub(super) fn replan(&mut self) -> Result<(), CookError> {
        let Some(plan) = self.next_plan.take() else { return Ok(()) };
        self.wanted = wanted(&plan, &self.options)?;
        self.list_origins = list_origins(&plan);
        self.of_plan = vec![Vec::new(); plan.nodes.len()];
        self.paths = plan.nodes.iter().enumerate().map(|(at, node)| (node.path.clone(), at)).collect();
        self.settings.clear();
        self.costs = Costs::of(&plan, self.options.keep_cheap);
        self.plan = *plan;
        Ok(())
    }

    /// The content of the file at `path`: as it is, or as it was when it was last let in.
    pub(super) fn content(&mut self, path: &Path) -> Result<Digest, String> {
        let Some(gate) = self.options.gate.clone() else {
            return self.shared.files.digest(path).map_err(|problem| format!("{}: {problem}", path.display()));
        };
        let free = |engine: &Self| gate.lets_in(path) || !gate.knows(path) && !engine.lists(path);
        if free(self) {
            let digest = self.shared.files.digest(path).map_err(|problem| format!("{}: {problem}", path.display()))?;
            // It may have been opened for writing while it was read.
            if free(self) {
                self.good.insert(path.to_owned(), digest);
                return Ok(digest);
            }
        }
        let good = self.good.get(path).copied();
        good.ok_or_else(|| format!("{} is still being written; it is cooked once it stands still", path.display()))
    }

    /// Whether the take that a cell reads is no longer as it arrived. That is no failure: it left, or is being written again, and
    /// it is an item again once it has arrived.
    pub(super) fn withdraws(&mut self, id: CellId) -> bool {
        let (Some(gate), Some(file)) = (&self.options.gate, &self.cells[id].file) else { return false };
        let of = |files: &BTreeMap<_, PathBuf>| files.values().any(|listed| listed == file);
        let is_match = self.listed.iter().any(|(pattern, files)| of(files) && Pattern::new(pattern).is_wild());
        if !is_match || gate.stands(file) {
            return false;
        }
        self.good.remove(file);
        self.items_changed = true;
        true
    }

    /// Whether a pattern matches the file at `path`.
    fn lists(&self, path: &Path) -> bool {
        let item = path.file_stem().unwrap_or_default().to_string_lossy();
        self.listed.values().any(|files| files.get(item.as_ref()).is_some_and(|file| file == path))
    }

    /// Whether the file at `path` is an item: it has arrived, now or before.
    pub(super) fn is_there(&self, path: &Path) -> bool {
        self.options.gate.as_ref().is_none_or(|gate| self.good.contains_key(path) || gate.lets_in(path))
    }

    /// The files that were seen to matter so far.
    pub fn seen(&self) -> Seen {
        let mut seen = Seen { patterns: self.listed.keys().cloned().collect(), files: BTreeSet::new() };
        for cell in &self.cells {
            let Some(file) = &cell.file else { continue };
            let folder = file.parent().unwrap_or(Path::new(""));
            seen.files.insert(file.clone());
            seen.files.extend(cell.reads.iter().map(|(name, _)| folder.join(name)));
        }
        seen
    }

    /// Remembers that a computation failed: whatever it was made of is in its key, so it would fail again.
    pub(super) fn note_failure(&mut self, id: CellId, key: Digest, problem: &str) {
        if self.options.resident && self.cells[id].file.is_none() {
            self.failures.insert(key, problem.to_owned());
        }
    }
}
