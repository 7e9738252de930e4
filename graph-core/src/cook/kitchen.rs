//! The kitchen: one cook from start to end. One thread coordinates; computations run on the pool.

use super::cell::{Cell, CellId, Directory, KnownItems, State};
use super::event::{Event, Summary};
use super::key::Part;
use super::results::Message;
use super::session::{CellRecord, Session, session_name};
use super::tasks::Task;
use crate::document::{Diagnostic, Override};
use crate::files::Fingerprints;
use crate::plan::{OriginId, Plan};
use crate::store::{Store, StoreError};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How to cook.
#[derive(Debug, Clone)]
pub struct Options {
    /// Threads; 0 means one for each core.
    pub jobs: usize,
    /// Frames in a block.
    pub block_frames: usize,
    /// Only these nodes and what they need; empty means all.
    pub only: Vec<String>,
    /// Only say what would be cooked.
    pub dry: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { jobs: 0, block_frames: super::BLOCK_FRAMES, only: Vec::new(), dry: false }
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

/// Brings every cell of `plan` up to date, or tells what would be cooked.
///
/// Nodes that fail are told by events and counted in the summary; branches that do not need them go on.
///
/// # Errors
/// Where the cook could not run: an unknown name in `only`, a store that cannot be written.
pub fn cook(
    plan: &Plan,
    overrides: &[Override],
    store: &Store,
    options: &Options,
    cancel: &AtomicBool,
    tell: &(dyn Fn(Event) + Sync),
) -> Result<Summary, CookError> {
    let start = Instant::now();
    let mut kitchen = Kitchen::new(plan, overrides, store, options, cancel, tell)?;
    let files = Fingerprints::new(kitchen.session.files.clone());
    let (sender, receiver) = channel();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.jobs).build()?;
    pool.in_place_scope(|scope| {
        let mut counter = Counter { scope, files: &files, sender: &sender };
        kitchen.run(&mut counter, &receiver);
    });
    if let Some(problem) = kitchen.broken_store.take() {
        return Err(problem.into());
    }
    if !options.dry {
        kitchen.remember(&files)?;
    }
    kitchen.summary.cancelled = cancel.load(Ordering::Relaxed);
    kitchen.summary.seconds = start.elapsed().as_secs_f64();
    (kitchen.tell)(Event::Summary(kitchen.summary.clone()));
    Ok(kitchen.summary)
}

/// Where jobs are handed over, and what they share.
pub(super) struct Counter<'s, 'scope> {
    pub scope: &'s rayon::Scope<'scope>,
    pub files: &'scope Fingerprints,
    pub sender: &'s Sender<Message>,
}

/// The state of one cook.
pub(super) struct Kitchen<'a> {
    pub plan: &'a Plan,
    pub overrides: &'a [Override],
    pub store: &'a Store,
    pub options: &'a Options,
    pub cancel: &'a AtomicBool,
    pub tell: &'a (dyn Fn(Event) + Sync),
    /// What the last cook knew.
    pub session: Session,
    /// What this cook knows.
    pub records: BTreeMap<String, CellRecord>,
    pub published: BTreeMap<std::path::PathBuf, (crate::files::Signature, wire::Digest)>,
    pub cells: Vec<Cell>,
    pub directory: Directory,
    pub known_items: KnownItems,
    /// Plan nodes whose cells are not made yet, in their order.
    pub folded: Vec<usize>,
    /// Lists whose items will never be known, with the cell that failed.
    pub lost_lists: BTreeMap<OriginId, String>,
    /// Parameter parts of keys by plan node, where no item enters them.
    pub own_parts: BTreeMap<usize, Vec<Part>>,
    pub ready: BTreeSet<CellId>,
    pub tasks: BTreeMap<CellId, Task>,
    pub running: usize,
    pub summary: Summary,
    pub broken_store: Option<StoreError>,
    /// Whether the store is known to take files.
    pub prepared: bool,
}

impl<'a> Kitchen<'a> {
    fn new(
        plan: &'a Plan,
        overrides: &'a [Override],
        store: &'a Store,
        options: &'a Options,
        cancel: &'a AtomicBool,
        tell: &'a (dyn Fn(Event) + Sync),
    ) -> Result<Self, CookError> {
        let mut wanted = Vec::new();
        for name in &options.only {
            let found = plan.find(name);
            if found.is_empty() {
                return Err(CookError::UnknownNode(Box::new(plan.unknown_node(name))));
            }
            wanted.extend(found);
        }
        let marked = plan.with_ancestors(&wanted);
        let folded = (0..plan.nodes.len()).filter(|node| wanted.is_empty() || marked[*node]).collect();
        let mut session = Session::load(store, &plan.root().path);
        session.run += 1;
        let published = session.published.clone();
        Ok(Self {
            plan,
            overrides,
            store,
            options,
            cancel,
            tell,
            session,
            records: BTreeMap::new(),
            published,
            cells: Vec::new(),
            directory: Directory::new(),
            known_items: KnownItems::new(),
            folded,
            lost_lists: BTreeMap::new(),
            own_parts: BTreeMap::new(),
            ready: BTreeSet::new(),
            tasks: BTreeMap::new(),
            running: 0,
            summary: Summary::default(),
            broken_store: None,
            prepared: false,
        })
    }

    pub fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// Works until nothing is ready and nothing runs.
    fn run<'scope>(&mut self, counter: &mut Counter<'_, 'scope>, receiver: &Receiver<Message>)
    where
        'a: 'scope,
    {
        self.unfold();
        loop {
            while let Some(cell) = self.ready.pop_first() {
                if self.cancelled() || self.broken_store.is_some() {
                    self.ready.clear();
                    break;
                }
                self.evaluate(cell, counter);
            }
            if self.running == 0 {
                return;
            }
            if let Ok(message) = receiver.recv_timeout(Duration::from_millis(100)) {
                self.running -= 1;
                self.receive(message, counter);
            }
        }
    }

    /// Marks a cell as finished, and lets its consumers go on.
    pub fn finish(&mut self, id: CellId, state: State) {
        self.cells[id].state = state;
        for consumer in self.cells[id].consumers.clone() {
            self.cells[consumer].pending -= 1;
            if self.cells[consumer].pending == 0 {
                self.ready.insert(consumer);
            }
        }
        self.learn_items(id);
        for producer in self.producers(id) {
            self.cells[producer].open_consumers -= 1;
            self.let_go(producer);
        }
        self.let_go(id);
    }

    /// The cells that a cell is wired to, each once.
    pub fn producers(&self, id: CellId) -> BTreeSet<CellId> {
        self.cells[id].links.iter().flat_map(|link| &link.wires).map(|wire| wire.cell).collect()
    }

    /// Releases the memory of a cell that nothing will ask any more.
    fn let_go(&mut self, id: CellId) {
        let cell = &self.cells[id];
        let waited_for = self.folded.iter().any(|node| {
            self.plan.nodes[*node].inputs.iter().flat_map(|input| &input.sources).any(|source| source.node == cell.plan)
        });
        if cell.open_consumers == 0 && !waited_for && !self.tasks.contains_key(&id) {
            for slot in cell.slots().iter().flat_map(|slots| slots.values()).flat_map(super::cell::SlotSet::slots) {
                slot.release();
            }
        }
    }

    /// Writes what this cook knows, and what earlier ones knew of cells that this one did not touch.
    fn remember(&mut self, files: &Fingerprints) -> Result<(), StoreError> {
        let mut session = std::mem::take(&mut self.session);
        let paths: BTreeSet<&str> = self.plan.nodes.iter().map(|node| node.path.as_str()).collect();
        let unfolded: BTreeSet<&str> = self
            .cells
            .iter()
            .filter(|cell| !matches!(cell.state, State::Failed(_) | State::Waiting | State::Cooking))
            .map(|cell| self.plan.nodes[cell.plan].path.as_str())
            .collect();
        session.cells.retain(|name, _| {
            let path = name.split_once('@').map_or(name.as_str(), |(path, _)| path);
            paths.contains(path) && (!unfolded.contains(path) || self.cells.iter().any(|cell| cell.name == *name))
        });
        session.cells.append(&mut self.records);
        session.published = std::mem::take(&mut self.published);
        session.files = files.all();
        session.time_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        self.store.put_session(&session_name(&self.plan.root().path), &session)
    }
}
