//! Cooking on a thread of its own. The engine stays in memory between cooks: where only parameters changed, nodes are
//! exchanged in it, so that a cook costs what the change touches.

use super::Asked;
use super::workbench::Bench;
use crate::model::Message;
use crate::preview::picture;
use graph_core::cook::{CookError, Engine, Options, Summary, session_name};
use graph_core::document::{Override, canonical_parameters};
use graph_core::plan::{Plan, load_texts};
use graph_core::store::Store;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;

pub type Texts = BTreeMap<PathBuf, String>;

enum Job {
    Cook(Texts, Vec<String>),
    Peek(Texts, String, String),
    Work(Ask),
    Forget,
}

/// Curves to be worked on.
pub struct Ask {
    /// What is unsaved.
    pub texts: Texts,
    /// The revision of all texts.
    pub revision: u64,
    /// That of the graphs among them.
    pub graphs_revision: u64,
    /// The cell and port at which the work began.
    pub of: (String, String),
}

/// Takes what is to be cooked or looked at.
pub struct Cooker {
    sender: Sender<Job>,
    cancel: Arc<AtomicBool>,
}

impl Cooker {
    /// Starts the thread.
    pub fn begin(asked: &Asked, root: &Path, store: &Arc<Store>, tell: &Sender<(Instant, Message)>) -> Self {
        let (sender, receiver) = channel();
        let cancel = Arc::new(AtomicBool::new(false));
        let kitchen = Kitchen {
            root: root.to_owned(),
            overrides: asked.overrides.clone(),
            options: asked.options.clone(),
            store: Arc::clone(store),
            cancel: Arc::clone(&cancel),
            tell: tell.clone(),
            standing: None,
            bench: None,
        };
        std::thread::spawn(move || kitchen.serve(&receiver));
        Self { sender, cancel }
    }

    /// Asks for a cook.
    pub fn cook(&self, texts: Texts, only: Vec<String>) {
        self.cancel.store(false, Ordering::Relaxed);
        // The thread lives as long as someone listens to it.
        drop(self.sender.send(Job::Cook(texts, only)));
    }

    /// Drops what stands in memory, once a cook that goes on is over.
    pub fn forget(&self) {
        drop(self.sender.send(Job::Forget));
    }

    /// Ends the cook.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Asks for curves to be worked on.
    pub fn work(&self, ask: Ask) {
        self.cancel.store(false, Ordering::Relaxed);
        drop(self.sender.send(Job::Work(ask)));
    }

    /// Asks for a value.
    pub fn peek(&self, texts: Texts, cell: String, port: String) {
        drop(self.sender.send(Job::Peek(texts, cell, port)));
    }
}

/// An engine in memory, with what tells whether another plan could stand in its place.
pub(super) struct Standing {
    engine: Engine,
    shape: String,
    parameters: BTreeMap<String, BTreeMap<String, String>>,
    dry: bool,
}

pub(super) struct Kitchen {
    pub root: PathBuf,
    pub overrides: Vec<Override>,
    options: Options,
    pub store: Arc<Store>,
    pub cancel: Arc<AtomicBool>,
    tell: Sender<(Instant, Message)>,
    pub standing: Option<Standing>,
    /// What stands for work on curves, and only for that.
    pub bench: Option<Bench>,
}

impl Kitchen {
    fn serve(mut self, jobs: &Receiver<Job>) {
        while let Ok(job) = jobs.recv() {
            let message = match job {
                Job::Cook(texts, only) => {
                    self.bench = None;
                    self.say(Message::CookBegan);
                    let cooked = catch_unwind(AssertUnwindSafe(|| self.cook(&texts, only)));
                    Message::CookEnded(cooked.unwrap_or_else(|_| {
                        // An engine that panicked is not to be trusted.
                        self.standing = None;
                        Err("the cook broke off; what was done is kept".to_owned())
                    }))
                }
                Job::Work(ask) => {
                    self.say(Message::CookBegan);
                    let worked = catch_unwind(AssertUnwindSafe(|| self.work(&ask)));
                    Message::CookEnded(worked.unwrap_or_else(|_| {
                        self.bench = None;
                        Err("the cook broke off; what was done is kept".to_owned())
                    }))
                }
                Job::Forget => {
                    (self.standing, self.bench) = (None, None);
                    continue;
                }
                Job::Peek(texts, cell, port) => {
                    self.bench = None;
                    let value = catch_unwind(AssertUnwindSafe(|| self.peek(&texts, &cell, &port)));
                    let value = value.unwrap_or_else(|_| Err("this value cannot be shown".to_owned()));
                    Message::Peeked { of: (cell, port), value }
                }
            };
            if !self.say(message) {
                return;
            }
        }
    }

    pub fn say(&self, message: Message) -> bool {
        self.tell.send((Instant::now(), message)).is_ok()
    }

    fn cook(&mut self, texts: &Texts, only: Vec<String>) -> Result<Summary, String> {
        let plan = self.plan(texts)?;
        let told = |problem: CookError| problem.to_string();
        let lease = self.store.lease(&session_name(&self.store, &self.root)).map_err(|problem| problem.to_string())?;
        if !only.is_empty() {
            // What is cooked in part leaves a session behind, from which a whole engine begins anew.
            self.standing = None;
            let mut engine = self.engine(plan, only).map_err(told)?;
            engine.hold(texts);
            let summary = engine.cook().map_err(told)?;
            engine.remember().map_err(told)?;
            return Ok(summary);
        }
        let (shape, parameters) = (shape(&plan), parameters(&plan));
        let fits = self
            .standing
            .as_mut()
            .is_some_and(|standing| !standing.dry && standing.shape == shape && exchange(standing, &plan, &parameters));
        if !fits {
            self.standing = None;
            let engine = self.engine(plan, Vec::new()).map_err(told)?;
            self.standing = Some(Standing { engine, shape, parameters: BTreeMap::new(), dry: false });
        }
        let Some(standing) = &mut self.standing else { return Ok(Summary::default()) };
        standing.parameters = parameters;
        standing.engine.hold(texts);
        standing.engine.rescan();
        let summary = standing.engine.cook();
        if summary.is_err() {
            self.standing = None;
        }
        let summary = summary.map_err(told)?;
        if let Some(standing) = &mut self.standing {
            standing.engine.remember().map_err(told)?;
        }
        drop(lease);
        Ok(summary)
    }

    pub fn plan(&self, texts: &Texts) -> Result<Plan, String> {
        load_texts(&self.root, &self.overrides, texts.clone())
            .map_err(|mistakes| mistakes.0.first().map_or_else(String::new, |mistake| mistake.message.clone()))
    }

    pub fn engine(&self, plan: Plan, only: Vec<String>) -> Result<Engine, CookError> {
        let tell = self.tell.clone();
        let told = Arc::new(move |event| drop(tell.send((Instant::now(), Message::Cook(event)))));
        let options = Options { resident: true, dry: false, only, ..self.options.clone() };
        let (store, cancel) = (Arc::clone(&self.store), Arc::clone(&self.cancel));
        Engine::new(plan, &self.overrides, store, options, cancel, Some(told))
    }

    fn peek(&mut self, texts: &Texts, cell: &str, port: &str) -> Result<Arc<crate::preview::Picture>, String> {
        if self.standing.is_none() {
            let plan = load_texts(&self.root, &self.overrides, texts.clone());
            let plan = plan.map_err(|_| "the graph has mistakes; mend them, then cook".to_owned())?;
            let options = Options { dry: true, only: Vec::new(), ..self.options.clone() };
            let cancel = Arc::new(AtomicBool::new(false));
            let (shape, parameters) = (shape(&plan), parameters(&plan));
            let engine = Engine::new(plan, &self.overrides, Arc::clone(&self.store), options, cancel, None);
            let mut engine = engine.map_err(|problem| problem.to_string())?;
            engine.hold(texts);
            engine.cook().map_err(|problem| problem.to_string())?;
            self.standing = Some(Standing { engine, shape, parameters, dry: true });
        }
        let Some(standing) = &mut self.standing else { return Err(String::new()) };
        self.cancel.store(false, Ordering::Relaxed);
        let values = standing.engine.values(cell, port).map_err(|problem| problem.to_string())?;
        Ok(Arc::new(picture(&values)))
    }
}

/// Everything of a plan but parameters, as text; the code of plugins too.
fn shape(plan: &Plan) -> String {
    use std::fmt::Write;
    let mut shape = String::new();
    for node in &plan.nodes {
        let inputs: Vec<_> = node.inputs.iter().map(|input| (input.port.name, &input.sources)).collect();
        let files = (&node.reads, &node.writes, plan.kinds().get(&node.kind).map(|kind| kind.card().code));
        // Writing into a text cannot fail.
        let _ = writeln!(shape, "{} {} {:?} {inputs:?} {files:?}", node.path, node.kind, node.scope);
    }
    shape
}

fn parameters(plan: &Plan) -> BTreeMap<String, BTreeMap<String, String>> {
    plan.nodes.iter().map(|node| (node.path.clone(), canonical_parameters(node.node.as_ref(), &[]))).collect()
}

/// Puts the nodes with other parameters into the engine; whether all of them could be.
fn exchange(standing: &mut Standing, plan: &Plan, parameters: &BTreeMap<String, BTreeMap<String, String>>) -> bool {
    let changed = plan.nodes.iter().filter(|node| standing.parameters.get(&node.path) != parameters.get(&node.path));
    let changed: Vec<_> = changed.collect();
    changed.iter().all(|node| standing.engine.exchange(&node.path, &node.node).is_ok())
}
