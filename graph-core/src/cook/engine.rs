//! The engine: a plan in memory, cooked as often as something changes. One thread coordinates; computations that take time
//! run on the threads of a crew.
//!
//! What changed is pushed, not searched for: a dirty cell is looked at, and only where its result differs do the cells behind
//! it become dirty. Cells are looked at in the order of the plan. While a cell is in the making, everything that depends on
//! it is unsettled and waits; when it is done, what it did not change settles unseen.

use super::carry::Carried;
use super::cell::{Cell, CellId, Directory, KnownItems, LostLists, Settings};
use super::cost::Costs;
use super::crew::Crew;
use super::event::{Event, Summary};
use super::live::{Mail, list_origins, wanted};
use super::memory::Memory;
use super::options::{CookError, Options};
use super::refold::Stood;
use super::results::Message;
use super::session::{Session, session_name};
use super::shared::Shared;
use super::tasks::Task;
use super::turn::{Line, Turn};
use super::writer::Writer;
use crate::document::Override;
use crate::files::{Fingerprints, Signature};
use crate::plan::{OriginId, Plan};
use crate::store::Store;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use wire::Digest;

/// Takes what a cook tells.
pub type Tell = dyn Fn(Event) + Send + Sync;

/// Brings every cell of `plan` up to date once, or tells what would be cooked.
///
/// Nodes that fail are told by events and counted in the summary; branches that do not need them go on.
///
/// # Errors
/// Where the cook could not run: an unknown name in `only`, a store that cannot be written.
pub fn cook(
    plan: Plan,
    overrides: &[Override],
    store: Arc<Store>,
    options: &Options,
    cancel: Arc<AtomicBool>,
    tell: &(dyn Fn(Event) + Sync),
) -> Result<Summary, CookError> {
    cook_and((plan, overrides), store, options, cancel, tell, |_, _| ()).map(|(summary, ())| summary)
}

/// The same, after which `look` may look at what was cooked.
///
/// # Errors
/// As [`cook`].
pub fn cook_and<T>(
    (plan, overrides): (Plan, &[Override]),
    store: Arc<Store>,
    options: &Options,
    cancel: Arc<AtomicBool>,
    tell: &(dyn Fn(Event) + Sync),
    look: impl FnOnce(&mut Engine, &Summary) -> T,
) -> Result<(Summary, T), CookError> {
    let (sender, events) = channel();
    std::thread::scope(|scope| {
        // Events are told on a thread of their own, in their order: who listens slowly does not slow the cook.
        scope.spawn(move || events.into_iter().for_each(tell));
        let noticed = Arc::new(AtomicBool::new(false));
        let notice = Arc::clone(&noticed);
        let tell: Arc<Tell> = Arc::new(move |event| {
            notice.fetch_or(matches!(event, Event::Notice { .. }), Ordering::Relaxed);
            drop(sender.send(event));
        });
        let mut engine = Engine::new(plan, overrides, store, options.clone(), cancel, Some(tell))?;
        let summary = engine.cook()?;
        engine.remember()?;
        // What people should notice is told again in the next cook.
        let usual = !options.dry && options.publish && options.session.is_none();
        if usual && !noticed.load(Ordering::Relaxed) {
            engine.come_to_rest()?;
        }
        engine.tell(|| Event::Summary(summary.clone()));
        let seen = look(&mut engine, &summary);
        Ok((summary, seen))
    })
}

/// A plan in memory, with everything that is known of its cells.
pub struct Engine {
    pub(super) plan: Plan,
    pub(super) overrides: Vec<Override>,
    pub(super) options: Options,
    pub(super) shared: Arc<Shared>,
    pub(super) receiver: Receiver<Mail>,
    crew: Option<Crew>,
    /// What the last cook of an earlier process knew; records move from here into cells.
    pub(super) session: Session,
    pub(super) published: BTreeMap<PathBuf, (Signature, Digest)>,
    pub(super) cells: Vec<Cell>,
    /// The cells of each plan node.
    pub(super) of_plan: Vec<Vec<CellId>>,
    pub(super) directory: Directory,
    pub(super) known_items: KnownItems,
    /// What patterns of files matched.
    pub(super) listed: BTreeMap<PathBuf, BTreeMap<String, PathBuf>>,
    /// Plan nodes that are cooked, in their order.
    pub(super) wanted: Vec<usize>,
    /// Those whose cells are not made yet.
    pub(super) folded: Vec<usize>,
    pub(super) lost_lists: LostLists,
    /// Whether a list has other items than those that cells were made for.
    pub(super) items_changed: bool,
    /// What is known of cells that are about to be made anew.
    pub(super) stood: HashMap<String, Stood>,
    /// The list outputs of plan nodes over which others repeat.
    pub(super) list_origins: HashMap<usize, Vec<OriginId>>,
    /// Settings by plan node, where no item enters them.
    pub(super) settings: HashMap<usize, Arc<Settings>>,
    /// Plan nodes by their path.
    pub(super) paths: HashMap<String, usize>,
    /// Where each cell stands in the order of work.
    pub(super) turns: Vec<Turn>,
    /// Dirty cells to be looked at.
    pub(super) line: Line,
    pub(super) failed: BTreeSet<CellId>,
    pub(super) tasks: HashMap<CellId, Task>,
    /// The cell that is computed under each key, and those that wait for its result since they have the same key.
    pub(super) making: HashMap<Digest, CellId>,
    pub(super) twins: HashMap<Digest, Vec<CellId>>,
    /// The cell that last came to stand under each key, but for plain ones.
    pub(super) stands: HashMap<Digest, CellId>,
    pub(super) running: usize,
    /// How often cells were made anew.
    pub(super) generation: u64,
    /// How many tasks were begun so far.
    pub(super) tasks_begun: u64,
    pub(super) carried: Carried,
    pub(super) next_plan: Option<Box<Plan>>,
    pub(super) changes_taken: u64,
    /// Content of files when they were last let in.
    pub(super) good: BTreeMap<PathBuf, Digest>,
    /// What failed under which key.
    pub(super) failures: HashMap<Digest, String>,
    pub(super) costs: Costs,
    /// Memory for encodings that are only hashed.
    pub(super) scratch: Vec<u8>,
    pub(super) summary: Summary,
    /// Why this cook cannot go on at all.
    pub(super) broken: Option<CookError>,
    /// Whether the store is known to take files.
    pub(super) prepared: bool,
}

impl Engine {
    /// An engine over `plan`, which starts from what the store's session of this graph knows.
    ///
    /// # Errors
    /// Where `options.only` names something that is not in the graph.
    pub fn new(
        plan: Plan,
        overrides: &[Override],
        store: Arc<Store>,
        options: Options,
        cancel: Arc<AtomicBool>,
        tell: Option<Arc<Tell>>,
    ) -> Result<Self, CookError> {
        let wanted = wanted(&plan, &options)?;
        let name = options.session.unwrap_or_else(|| session_name(&store, &plan.root().path));
        let mut session: Session = store.session(&name).unwrap_or_default();
        let known = session.files.iter().map(|(path, file)| (path.clone(), file.digest)).collect();
        let files = Fingerprints::new(std::mem::take(&mut session.files));
        let (sender, receiver) = channel();
        let (block_frames, keep_cheap) = (options.block_frames, options.keep_cheap);
        let memory = Arc::new(Memory::new(options.memory_bytes));
        let writer = Writer::new(Arc::clone(&store));
        let shared = Shared { store, writer, files, memory, cancel, tell, block_frames, keep_cheap, sender };
        Ok(Self {
            of_plan: vec![Vec::new(); plan.nodes.len()],
            overrides: overrides.to_vec(),
            shared: Arc::new(shared),
            receiver,
            crew: None,
            published: std::mem::take(&mut session.published),
            session,
            cells: Vec::new(),
            directory: Directory::new(),
            known_items: KnownItems::new(),
            listed: BTreeMap::new(),
            wanted: wanted.clone(),
            folded: wanted,
            lost_lists: LostLists::new(),
            items_changed: false,
            stood: HashMap::new(),
            list_origins: list_origins(&plan),
            settings: HashMap::new(),
            paths: plan.nodes.iter().enumerate().map(|(at, node)| (node.path.clone(), at)).collect(),
            turns: Vec::new(),
            line: Line::default(),
            failed: BTreeSet::new(),
            tasks: HashMap::new(),
            making: HashMap::new(),
            twins: HashMap::new(),
            stands: HashMap::new(),
            running: 0,
            generation: 0,
            tasks_begun: 0,
            carried: Carried::default(),
            next_plan: None,
            changes_taken: 0,
            good: known,
            failures: HashMap::new(),
            costs: Costs::of(&plan, options.keep_cheap),
            scratch: Vec::new(),
            summary: Summary::default(),
            broken: None,
            prepared: false,
            plan,
            options,
        })
    }

    /// Makes the cells of all nodes whose items are known, ahead of the first cook.
    pub fn unfold_now(&mut self) {
        if !self.folded.is_empty() {
            self.unfold();
        }
    }

    /// Brings every cell that something changed for up to date. What failed before is tried again.
    ///
    /// # Errors
    /// Where the store cannot be written or threads cannot be started.
    pub fn cook(&mut self) -> Result<Summary, CookError> {
        let start = Instant::now();
        self.summary = Summary::default();
        self.session.run += 1;
        // What a cancelled cook left in the making begins anew.
        for (id, task) in std::mem::take(&mut self.tasks) {
            if task.fresh.is_some() {
                self.mark(id);
            }
        }
        self.making.clear();
        for twin in std::mem::take(&mut self.twins).into_values().flatten() {
            self.mark(twin);
        }
        for id in std::mem::take(&mut self.failed) {
            self.mark(id);
        }
        self.take_changes();
        if !self.items_changed {
            self.unfold_now();
        }
        loop {
            if std::mem::take(&mut self.items_changed) {
                self.refold()?;
            }
            self.run();
            if !self.items_changed || self.cancelled() || self.broken.is_some() {
                break;
            }
        }
        self.stood.clear();
        self.shared.memory.look_again();
        self.make_room();
        for damage in self.shared.store.take_damages() {
            self.tell(|| Event::Notice { about: damage.file.display().to_string(), message: damage.message });
        }
        if let Some(problem) = self.broken.take() {
            return Err(problem);
        }
        self.summary.cancelled = self.cancelled();
        self.summary.cached = if self.summary.cancelled {
            let done = self
                .turns
                .iter()
                .zip(&self.cells)
                .filter(|(turn, cell)| turn.settled && !turn.dirty && cell.slots().is_some());
            done.count().saturating_sub(self.summary.cooked)
        } else {
            let others = self.summary.cooked + self.summary.failed + self.summary.skipped;
            self.cells.len().saturating_sub(others)
        };
        self.summary.seconds = start.elapsed().as_secs_f64();
        Ok(self.summary.clone())
    }

    /// Works until nothing is ready and nothing runs.
    pub(super) fn run(&mut self) {
        loop {
            while let Some(id) = self.line.pop() {
                self.turns[id].queued = false;
                if self.cancelled() || self.broken.is_some() || self.items_changed {
                    self.mark_later(id);
                    break;
                }
                if self.turns[id].pending == 0 && self.turns[id].dirty {
                    self.evaluate(id);
                }
            }
            // A result that is still asked for is not waited for where cells are about to be made anew.
            let over = self.stops_orphans() || self.items_changed && !self.cancelled() && self.may_refold();
            if over {
                self.shared.writer.finish();
            }
            if let Some(problem) = self.shared.writer.problem() {
                // What still runs would be lost.
                self.shared.cancel.store(true, Ordering::Relaxed);
                self.broken.get_or_insert(problem.into());
            }
            if over {
                return;
            }
            self.call_help();
            match self.receiver.recv_timeout(Duration::from_millis(100)) {
                Ok(Mail::Result { generation, task, message }) => {
                    self.running -= 1;
                    if let Some(message) = self.addressed(generation, task, message) {
                        self.receive(message);
                        self.make_room();
                    }
                }
                Ok(Mail::Change(change)) => self.take_change(change),
                Err(_) => {}
            }
        }
    }

    pub(super) fn cancelled(&self) -> bool {
        self.shared.cancel.load(Ordering::Relaxed)
    }

    /// Tells an event, which is only made where someone listens.
    pub(super) fn tell(&self, event: impl FnOnce() -> Event) {
        self.shared.tell(event);
    }

    /// Where results are kept for the next change, long jobs do not hold up what is soon done.
    fn call_help(&mut self) {
        let crew = self.crew.as_mut().filter(|_| self.options.resident);
        if let Some(Err(problem)) = crew.map(Crew::help) {
            self.broken.get_or_insert(problem.into());
        }
    }

    /// The crew, hired with the first job; `None` where threads cannot be started, which ends the cook.
    fn crew(&mut self) -> Option<&Crew> {
        if self.crew.is_none() {
            match Crew::new(self.options.jobs) {
                Ok(crew) => self.crew = Some(crew),
                Err(problem) => drop(self.broken.get_or_insert(problem.into())),
            }
        }
        self.crew.as_ref()
    }

    /// How many threads run jobs.
    pub(super) fn threads(&mut self) -> Option<usize> {
        self.crew().map(Crew::threads)
    }

    /// Runs `work` on the crew's threads; what it gives is received later.
    pub(super) fn spawn(&mut self, id: CellId, work: impl FnOnce(&Shared) -> Message + Send + 'static) {
        let (shared, generation) = (Arc::clone(&self.shared), self.generation);
        let task = self.tasks.get(&id).map(|task| task.number);
        let Some(crew) = self.crew() else { return };
        crew.spawn(move || {
            let message = shared.guarded(id, work);
            let mail = Mail::Result { generation, task, message };
            // Nobody waits any more where the engine is gone.
            let _ = shared.sender.send(mail);
        });
        self.running += 1;
    }

    /// Writes what this cook knows, and what earlier ones knew of cells that this one did not touch.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub fn remember(&mut self) -> Result<(), CookError> {
        if self.options.dry {
            return Ok(());
        }
        let session = self.knowledge();
        let store = &self.shared.store;
        let name = self.options.session.unwrap_or_else(|| session_name(store, &self.plan.root().path));
        store.put_session(&name, &session)?;
        Ok(())
    }
}
