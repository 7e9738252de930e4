//! The two cooks of a snapshot.

use crate::arguments::{Global, SnapshotOf};
use crate::exit::{Exit, Trouble};
use crate::graph::{self, Asked};
use crate::tell::{People, Wanted};
use crate::{cooking, mistakes, signals};
use graph_core::cook::{Engine, Event, Options, Summary, cook, cook_and, session_name};
use graph_core::document::Override;
use graph_core::plan::Plan;
use graph_core::snapshot::{Golden, Hits, chosen};
use graph_core::store::Store;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use wire::Digest;

/// A graph that a snapshot is of.
pub struct Work<'a> {
    of: &'a SnapshotOf,
    global: &'a Global,
    asked: Asked,
    /// What is set, as `--set` takes it.
    pub set: Vec<String>,
    /// The folder of the snapshot.
    pub folder: PathBuf,
    store: Arc<Store>,
    options: Options,
    cancel: Arc<AtomicBool>,
}

/// What a second cook did.
pub struct Again {
    pub hits: Hits,
    /// The cells that it computed.
    pub cooked: Vec<String>,
}

impl<'a> Work<'a> {
    /// Reads the arguments; what the snapshot that is `known` was taken with is set too, unless the command line says otherwise.
    pub fn new(of: &'a SnapshotOf, global: &'a Global, known: &[String]) -> Result<Self, Trouble> {
        if !of.cook.only.is_empty() {
            let help = "leave `--only` away, or make the branch a graph of its own";
            return Err(Trouble::command_line("a snapshot is of a whole graph", Some(help.to_owned())));
        }
        let mut asked = Asked::read(&of.graph)?;
        let mut set = Vec::new();
        let mut overrides = Vec::new();
        for text in known {
            let read = Override::parse(text).map_err(|mistake| Trouble::command_line(mistake.message, mistake.help))?;
            let replaced = asked.overrides.iter().any(|own| own.path == read.path && own.name == read.name);
            if !replaced {
                set.push(text.clone());
                overrides.push(read);
            }
        }
        set.extend(of.graph.set.iter().cloned());
        overrides.append(&mut asked.overrides);
        asked.overrides = overrides;
        let store = graph::store(&of.store, &asked.path);
        let session = Digest::of(format!("snapshot {}", session_name(&store, &asked.path)).as_bytes());
        let options = Options { publish: false, session: Some(session), ..cooking::options(&of.cook, false) };
        let folder = Golden::folder(&asked.path);
        let cancel = signals::cancelled_by_signals()?;
        Ok(Self { of, global, asked, set, folder, store: Arc::new(store), options, cancel })
    }

    /// The folder of the snapshot that the arguments mean.
    pub fn folder_of(of: &SnapshotOf) -> PathBuf {
        Golden::folder(&graph::file(&of.graph.graph))
    }

    fn plan(&self) -> Result<Plan, Trouble> {
        if !self.of.json {
            return self.asked.load_or_tell();
        }
        self.asked.load().map_err(|found| mistakes::print_json(&found).err().unwrap_or(Trouble::Graph(found)))
    }

    /// Cooks, lets `look` look at the result, and cooks again. The exit code is that of a cook that did not go well.
    pub fn cook<T>(
        &self,
        look: impl FnOnce(&mut Engine) -> Result<T, Trouble>,
    ) -> Result<Result<(T, Again), Exit>, Trouble> {
        let plan = self.plan()?;
        if chosen(&plan).is_empty() {
            let help = "give the graph `outputs: { \"name\": \"node.port\" }`, or a node that writes a file";
            let problem = format!("there is nothing in {} that a snapshot would hold", self.asked.path.display());
            return Err(Trouble::command_line(problem, Some(help.to_owned())));
        }
        let lease = self.store.lease(&self.options.session.unwrap_or_default())?;
        let mut seen = None;
        let first = |tell: &(dyn Fn(Event) + Sync)| -> Result<Summary, Trouble> {
            let look =
                |engine: &mut Engine, summary: &Summary| (cooking::exit(summary) == Exit::Fine).then(|| look(engine));
            let (store, cancel) = (Arc::clone(&self.store), Arc::clone(&self.cancel));
            let (summary, found) = cook_and((plan, &self.asked.overrides), store, &self.options, cancel, tell, look)?;
            seen = found.transpose()?;
            Ok(summary)
        };
        let summary = if self.of.json {
            first(&|_| {})?
        } else {
            let wanted = Wanted { quiet: self.global.quiet, verbose: self.global.verbose, plain: false };
            People::new(wanted).during(|people| first(&|event| people.tell(event)))?
        };
        let Some(seen) = seen else { return Ok(Err(cooking::exit(&summary))) };
        let again = self.again()?;
        drop(lease);
        Ok(Ok((seen, again)))
    }

    fn again(&self) -> Result<Again, Trouble> {
        let cooked = Mutex::new(Vec::new());
        let (store, cancel) = (Arc::clone(&self.store), Arc::clone(&self.cancel));
        let summary = cook(self.plan()?, &self.asked.overrides, store, &self.options, cancel, &|event| {
            if let Event::Cooked { node, .. } = event {
                cooked.lock().unwrap_or_else(PoisonError::into_inner).push(node);
            }
        })?;
        let mut cooked = cooked.into_inner().unwrap_or_else(PoisonError::into_inner);
        // In what order cells end depends on the threads.
        cooked.sort();
        Ok(Again { hits: Hits { cooked: summary.cooked, cached: summary.cached }, cooked })
    }
}
