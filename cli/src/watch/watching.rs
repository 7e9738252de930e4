//! What is watched: looks at files, decides what arrived, and tells the kitchen.

use super::hints::{Hint, Hints};
use super::kitchen::{Cooked, Kitchen};
use super::tell::{Teller, WatchEvent};
use crate::graph::Asked;
use graph_core::cook::{Change, CookError, Seen};
use graph_core::document::{Diagnostic, Diagnostics};
use graph_core::files::{Gate, Pattern, Signature};
use graph_core::watch::{Arrivals, Change as Became, News, Renamed, Wanted, look};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

/// A graph file that an editor saves in several steps stands still for longer than this.
const GRAPH_SETTLE: Duration = Duration::from_millis(150);
/// Files that were last changed longer ago than this when the watch begins are taken as complete.
const OLD: Duration = Duration::from_mins(1);
/// Time between two looks where the system tells of changes, in case it does not.
const SAFETY: Duration = Duration::from_secs(30);

/// The watched graph.
pub struct Watching {
    asked: Asked,
    gate: Arc<Gate>,
    settle: Duration,
    hints: Hints,
    kitchen: Kitchen,
    teller: Arc<Teller>,
    begun: Instant,
    wanted: Wanted,
    /// What the last cook saw.
    seen: Seen,
    /// Files renamed into place since the last look.
    renamed: BTreeSet<PathBuf>,
    graphs: Arrivals,
    sources: Arrivals,
    /// Whether the graph was found wrong when it was last read.
    broken: bool,
    problems: BTreeSet<String>,
    /// Why nothing can be cooked at all.
    refused: Option<CookError>,
}

impl Watching {
    /// A watch that has not looked yet.
    pub fn new(
        asked: Asked,
        gate: Arc<Gate>,
        settle: Duration,
        hints: Hints,
        kitchen: Kitchen,
        teller: &Arc<Teller>,
    ) -> Self {
        let wanted = Wanted { graphs: [asked.path.clone()].into(), sources: BTreeSet::new() };
        Self {
            asked,
            gate,
            settle,
            hints,
            kitchen,
            teller: Arc::clone(teller),
            begun: Instant::now(),
            wanted,
            seen: Seen::default(),
            renamed: BTreeSet::new(),
            graphs: Arrivals::default(),
            sources: Arrivals::default(),
            broken: false,
            problems: BTreeSet::new(),
            refused: None,
        }
    }

    /// The first look: the graph is read, and old files are taken as complete.
    pub fn start(&mut self) {
        self.teller.watch(&WatchEvent::Rescan { because: "the watch begins".to_owned() });
        self.read_graph();
        self.look();
    }

    /// Looks at everything, and tries again what failed.
    pub fn retry(&mut self) {
        self.kitchen.tell(Change::Retry);
        self.read_graph();
        self.look();
    }

    /// How long to wait between two looks.
    pub fn pause(&self) -> Duration {
        if self.graphs.settling().next().is_some() {
            return GRAPH_SETTLE / 4;
        }
        if self.sources.settling().next().is_some() {
            return (self.settle / 8).clamp(Duration::from_millis(10), Duration::from_millis(500));
        }
        if self.hints.polling { self.settle.clamp(Duration::from_millis(100), Duration::from_secs(1)) } else { SAFETY }
    }

    /// Takes what the system said.
    pub fn take_hint(&mut self, hint: Hint) {
        self.renamed.extend(hint.renamed);
        if let Some(because) = hint.lost {
            self.teller.watch(&WatchEvent::Rescan { because });
        }
    }

    /// Takes the end of a cook. Whether it showed files that were not looked at so far.
    pub fn cooked(&mut self, cooked: Cooked) -> bool {
        self.kitchen.take(&cooked);
        let before = self.all_wanted();
        self.seen = cooked.seen;
        if !self.kitchen.cooking {
            self.wait();
        }
        self.all_wanted() != before
    }

    fn wait(&self) {
        let settling = self.sources.settling().count();
        self.teller.watch(&WatchEvent::Waiting {
            files: self.sources.arrived().len(),
            settling,
            polling: self.hints.polling,
            broken: self.broken,
        });
    }

    /// Files that are being written, with their sizes in bytes.
    pub fn settling(&self) -> Vec<(PathBuf, u64)> {
        self.sources.settling().map(|(path, bytes)| (path.to_owned(), bytes)).collect()
    }

    /// Why nothing can be cooked at all: the store cannot be used, or the command line names no node.
    pub fn refused(&mut self) -> Option<CookError> {
        self.refused.take()
    }

    /// Whether a cook runs.
    pub fn is_cooking(&self) -> bool {
        self.kitchen.cooking
    }

    /// Whether the graph is wrong as it stands.
    pub fn is_broken(&self) -> bool {
        self.broken
    }

    /// Ends the watch. Whether that cut a cook short.
    pub fn end(&mut self) -> bool {
        self.kitchen.close()
    }

    fn all_wanted(&self) -> Wanted {
        let mut all = self.wanted.clone();
        all.sources.extend(self.seen.patterns.iter().chain(&self.seen.files).cloned());
        all
    }

    /// Looks at all files once, and tells the kitchen what changed.
    pub fn look(&mut self) {
        let mut found = look(&self.all_wanted());
        if self.hints.follow(&found.folders) {
            // What came between the look and the following was not told.
            found = look(&self.all_wanted());
        }
        let problems: BTreeSet<String> = found.problems.iter().map(ToString::to_string).collect();
        for problem in problems.difference(&self.problems) {
            self.teller.trouble(problem);
        }
        self.problems = problems;
        let now = self.begun.elapsed();
        let graph_settle = GRAPH_SETTLE.min(self.settle);
        let first = self.graphs.arrived().is_empty() && !self.broken;
        let known = if first { found.graphs.keys().cloned().collect() } else { Renamed::new() };
        let graph_news = self.graphs.take(now, &found.graphs, &known, |_| graph_settle);
        let source_news = self.sources.take(now, &found.sources, &self.complete(&found.sources), |_| self.settle);
        self.renamed.clear();
        self.gate.open_to(self.sources.arrived());
        self.tell_news(&source_news);
        let edited = !first && graph_news.iter().any(|news| news.change != Became::Settling);
        if edited || !self.kitchen.is_open() && !self.broken {
            self.read_graph();
        }
        if source_news.iter().any(|news| news.change != Became::Settling) {
            self.kitchen.tell(Change::Files);
        }
    }

    /// Files that need not stand still: those renamed into place, and at the start those that are old.
    fn complete(&self, found: &BTreeMap<PathBuf, Signature>) -> Renamed {
        let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let is_old = |signature: &Signature| {
            let newest = signature.modified_ns.max(signature.changed_ns);
            !self.kitchen.is_open() && since_1970.as_nanos() as i128 - newest > (OLD + self.settle).as_nanos() as i128
        };
        let complete = |(path, signature): &(&PathBuf, &Signature)| {
            is_old(signature) || !self.renamed.is_empty() && self.renamed.contains(&absolute(path))
        };
        found.iter().filter(complete).map(|(path, _)| path.clone()).collect()
    }

    fn tell_news(&self, news: &[News]) {
        for news in news {
            let item = news.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let (path, bytes) = (news.path.display().to_string(), news.bytes.unwrap_or_default());
            self.teller.watch(&match news.change {
                Became::Settling => WatchEvent::Settling { item, path, bytes },
                Became::Arrived => WatchEvent::Arrived { item, path, bytes },
                Became::Left => WatchEvent::Left { item, path },
            });
        }
    }

    /// Reads the graph, and gives it to the kitchen. One that is wrong is told, and the last good one stays.
    fn read_graph(&mut self) {
        match self.asked.load() {
            Ok(plan) => {
                self.broken = false;
                self.wanted = Wanted::of(&plan);
                if self.kitchen.is_open() {
                    self.kitchen.tell(Change::Plan(Box::new(plan)));
                } else if self.ready_to_open()
                    && let Err(problem) = self.kitchen.open(plan)
                {
                    self.refused = Some(problem);
                }
            }
            Err(mistakes) => {
                self.broken = true;
                self.wanted.graphs.extend(files_of(&mistakes));
                self.teller.mistakes(mistakes);
                if !self.kitchen.cooking {
                    self.wait();
                }
            }
        }
    }

    /// Whether the first cook may begin: files that are no takes are complete.
    fn ready_to_open(&mut self) -> bool {
        let found = look(&self.wanted);
        let complete = self.complete(&found.sources);
        let news = self.sources.take(self.begun.elapsed(), &found.sources, &complete, |_| self.settle);
        self.tell_news(&news);
        self.gate.open_to(self.sources.arrived());
        let single = |path: &Path| self.wanted.sources.contains(path) && !Pattern::new(path).is_wild();
        !self.sources.settling().any(|(path, _)| single(path))
    }
}

/// The graph files that have mistakes, or nest those that do.
fn files_of(mistakes: &Diagnostics) -> Vec<PathBuf> {
    let own = |mistake: &'_ Diagnostic| mistake.place.clone().map(|(place, _)| place);
    let places = mistakes.0.iter().flat_map(|mistake| own(mistake).into_iter().chain(mistake.through.clone()));
    places.map(|place| place.source.path.clone()).collect()
}
