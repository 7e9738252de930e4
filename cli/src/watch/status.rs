//! A watch as people see it: one line a take when it is done, and on a terminal a last line that says what goes on.

use super::tell::WatchEvent;
use crate::colours;
use crate::output::say;
use crate::words::{count, duration, one_line, size};
use console::{Term, style};
use graph_core::cook::{Event, Summary};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Columns of a take's name.
const NAME: usize = 24;
/// Takes and computations that are named in the last line, of each sort.
const NAMED: usize = 3;
/// A take of which nothing was heard for so long is done, though the cook may go on with others.
const QUIET: Duration = Duration::from_secs(1);

/// What a cook did for one take, or for what all takes share.
#[derive(Debug, Default)]
struct Row {
    cooked: usize,
    seconds: f64,
    wrote: Vec<String>,
    error: Option<String>,
    /// When something was last heard of it.
    heard: Option<Instant>,
}

/// What is shown, and what is known for it.
#[derive(Debug)]
pub struct Status {
    quiet: bool,
    verbose: bool,
    /// A terminal whose last line can be written again.
    term: Option<Term>,
    shown: String,
    rows: BTreeMap<String, Row>,
    /// When a take that is not cooked yet was complete.
    arrived: BTreeMap<String, Instant>,
    /// Errors that were told, by take: each is told once.
    told: BTreeMap<String, String>,
    /// Takes that failed as they stand.
    failing: BTreeSet<String>,
    /// Computations that run, with the fraction of them that is done where they tell it.
    running: BTreeMap<String, Option<f64>>,
}

impl Status {
    /// Nothing is known yet.
    pub fn new(quiet: bool, verbose: bool) -> Self {
        let term = Some(Term::stderr()).filter(|term| term.is_term() && !colours::dumb() && !quiet);
        Self {
            quiet,
            verbose,
            term,
            shown: String::new(),
            rows: BTreeMap::new(),
            arrived: BTreeMap::new(),
            told: BTreeMap::new(),
            failing: BTreeSet::new(),
            running: BTreeMap::new(),
        }
    }

    /// Takes an event of the watch.
    pub fn watch(&mut self, event: &WatchEvent) {
        match event {
            WatchEvent::Settling { item, bytes, .. } => {
                self.detail(|| format!("… {item:<NAME$} being written, {}", size(*bytes)));
            }
            WatchEvent::Arrived { item, bytes, .. } => {
                self.arrived.insert(item.clone(), Instant::now());
                self.detail(|| format!("+ {item:<NAME$} complete, {}", size(*bytes)));
            }
            WatchEvent::Left { item, .. } => {
                self.told.remove(item);
                self.failing.remove(item);
                self.line(&format!("{} {item:<NAME$} left", style("-").yellow().for_stderr()));
            }
            WatchEvent::Waiting { files, polling, broken, .. } => {
                let how = if *polling { ", looking again and again" } else { "" };
                let which = if *broken { "; the graph is wrong, its last good version was cooked" } else { "" };
                self.detail(|| format!("waiting for changes of {}{how}{which}", count(*files, "file")));
            }
            WatchEvent::Rescan { because } => self.detail(|| format!("looking at everything: {because}")),
        }
    }

    /// Takes an event of a cook.
    pub fn event(&mut self, event: &Event) {
        let item = |node: &str| node.split_once('@').map_or_else(|| node.to_owned(), |(_, item)| item.to_owned());
        match event {
            Event::Started { node, .. } => drop(self.running.insert(node.clone(), None)),
            Event::Progress { node, fraction, .. } => {
                self.running.entry(node.clone()).and_modify(|done| *done = Some(*fraction));
            }
            Event::Cooked { node, seconds, .. } => {
                self.running.remove(node);
                let row = self.row(item(node));
                (row.cooked, row.seconds) = (row.cooked + 1, row.seconds + seconds);
            }
            Event::Wrote { node, path, .. } => self.row(item(node)).wrote.push(path.clone()),
            Event::Failed { node, error, place, .. } => {
                self.running.remove(node);
                let row = self.row(item(node));
                row.error.get_or_insert_with(|| format!("{node} ({place}): {error}"));
            }
            Event::Notice { about, message } => self.notice(about, message),
            Event::Summary(summary) => self.end(summary),
            _ => {}
        }
    }

    fn row(&mut self, item: String) -> &mut Row {
        let row = self.rows.entry(item).or_default();
        row.heard = Some(Instant::now());
        row
    }

    /// Tells what is worth knowing, once.
    fn notice(&mut self, about: &str, message: &str) {
        let before = self.told.insert(about.to_owned(), message.to_owned());
        if before.as_deref() != Some(message) {
            self.line(&format!("{} {about}: {message}", style("!").yellow().bold().for_stderr()));
        }
    }

    /// What was done for a take, or for what all takes share.
    fn done(&mut self, item: &str, row: Row) {
        let since = self.arrived.remove(item);
        if let Some(error) = row.error {
            self.failing.insert(item.to_owned());
            if self.told.insert(item.to_owned(), error.clone()).as_ref() != Some(&error) {
                self.aside(|| say(&format!("{} {item:<NAME$} {error}", style("✗").red().bold().for_stderr())));
            }
            return;
        }
        self.told.remove(item);
        self.failing.remove(item);
        let waited = since.zip(row.heard).map(|(since, heard)| heard.saturating_duration_since(since).as_secs_f64());
        let wrote = if row.wrote.is_empty() { String::new() } else { format!("  → {}", row.wrote.join(", ")) };
        let cells = count(row.cooked, "cell");
        let took = style(format!("{:>7}", duration(waited.unwrap_or(row.seconds)))).dim().for_stderr();
        self.line(&format!("{} {item:<NAME$} {took}  {cells}{wrote}", style("✓").green().for_stderr()));
    }

    /// Tells of takes that are done, while the cook goes on with others.
    fn tell_done(&mut self) {
        let is_quiet = |row: &Row| row.heard.is_some_and(|heard| heard.elapsed() >= QUIET);
        let ended = |row: &Row| row.error.is_some() || !row.wrote.is_empty();
        let works =
            |item: &str| self.running.keys().any(|node| node.split_once('@').is_some_and(|(_, own)| own == item));
        let done = self.rows.iter().filter(|(item, row)| is_quiet(row) && ended(row) && !works(item));
        let done: Vec<String> = done.map(|(item, _)| item.clone()).collect();
        for item in done {
            if let Some(row) = self.rows.remove(&item) {
                self.done(&item, row);
            }
        }
    }

    /// A cook is over: a line for each take that it did something for.
    fn end(&mut self, summary: &Summary) {
        self.running.clear();
        for (item, row) in std::mem::take(&mut self.rows) {
            self.done(&item, row);
        }
        let failed = if summary.failed > 0 { format!(", {} failed", summary.failed) } else { String::new() };
        let totals =
            format!("{} cooked, {} cached{failed} in {}", summary.cooked, summary.cached, duration(summary.seconds));
        self.detail(|| totals);
    }

    fn detail(&mut self, line: impl FnOnce() -> String) {
        if self.verbose {
            let line = line();
            self.line(&line);
        }
    }

    fn line(&mut self, line: &str) {
        if !self.quiet {
            self.aside(|| say(line));
        }
    }

    /// Writes something above the last line.
    pub fn aside(&mut self, write: impl FnOnce()) {
        self.clear();
        write();
    }

    /// Takes the last line away.
    pub fn clear(&mut self) {
        if let Some(term) = self.term.as_ref().filter(|_| !self.shown.is_empty()) {
            // Where the terminal is gone, nobody misses the line.
            let _ = term.clear_line();
        }
        self.shown.clear();
    }

    /// Shows what goes on now in the last line of the terminal.
    pub fn show(&mut self, settling: &[(PathBuf, u64)], cooking: bool, broken: bool) {
        self.tell_done();
        let Some(term) = &self.term else { return };
        let mut parts = Vec::new();
        if cooking {
            let running = self.running.iter().map(|(node, done)| match done {
                Some(done) => format!("{node} {:.0}%", done * 100.0),
                None => node.clone(),
            });
            parts.push(format!("cooking {}", some(running)).trim_end().to_owned());
        }
        if !settling.is_empty() {
            let files = settling.iter().map(|(path, bytes)| {
                format!("{} ({})", path.file_name().unwrap_or_default().to_string_lossy(), size(*bytes))
            });
            parts.push(format!("being written: {}", some(files)));
        }
        if parts.is_empty() {
            parts.push("waiting".to_owned());
        }
        if broken {
            parts.push("the graph is wrong".to_owned());
        }
        if !self.failing.is_empty() {
            parts.push(format!("failed: {}", some(self.failing.iter().cloned())));
        }
        let line = parts.join("; ");
        let line = one_line(&line, usize::from(term.size().1).saturating_sub(1));
        if line != self.shown {
            let _ = term.clear_line().and_then(|()| term.write_str(&line));
            self.shown = line;
        }
    }
}

/// The first of some, and how many more there are.
fn some(mut all: impl ExactSizeIterator<Item = String>) -> String {
    let first: Vec<String> = all.by_ref().take(NAMED).collect();
    let more = if all.len() > 0 { format!(" and {} more", all.len()) } else { String::new() };
    first.join(", ") + &more
}
