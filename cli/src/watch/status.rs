//! A watch as people see it: one line a take when it is done, and on a terminal a last line that says what goes on.

use super::tell::WatchEvent;
use crate::colours;
use crate::output::say;
use crate::words::{count, duration, one_line, size};
use console::{Term, style};
use graph_core::cook::{Event, Summary};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// Columns of a take's name.
const NAME: usize = 24;
/// Takes that are named in the last line.
const NAMED: usize = 4;

/// What a cook did for one take, or for what all takes share.
#[derive(Debug, Default)]
struct Row {
    cooked: usize,
    seconds: f64,
    wrote: Vec<String>,
    error: Option<String>,
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
    running: usize,
}

impl Status {
    /// Nothing is known yet.
    pub fn new(quiet: bool, verbose: bool) -> Self {
        let term = Some(Term::stderr()).filter(|term| term.is_term() && !colours::dumb() && !quiet);
        let (rows, arrived, told) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        Self { quiet, verbose, term, shown: String::new(), rows, arrived, told, running: 0 }
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
            Event::Started { .. } => self.running += 1,
            Event::Cooked { node, seconds, .. } => {
                self.running = self.running.saturating_sub(1);
                let row = self.rows.entry(item(node)).or_default();
                (row.cooked, row.seconds) = (row.cooked + 1, row.seconds + seconds);
            }
            Event::Wrote { node, path, .. } => self.rows.entry(item(node)).or_default().wrote.push(path.clone()),
            Event::Failed { node, error, place, .. } => {
                let row = self.rows.entry(item(node)).or_default();
                row.error.get_or_insert_with(|| format!("{node} ({place}): {error}"));
            }
            Event::Notice { about, message } => self.notice(about, message),
            Event::Summary(summary) => self.end(summary),
            _ => {}
        }
    }

    /// Tells what is worth knowing, once.
    fn notice(&mut self, about: &str, message: &str) {
        let before = self.told.insert(about.to_owned(), message.to_owned());
        if before.as_deref() != Some(message) {
            self.line(&format!("{} {about}: {message}", style("!").yellow().bold().for_stderr()));
        }
    }

    /// A cook is over: a line for each take that it did something for.
    fn end(&mut self, summary: &Summary) {
        self.running = 0;
        for (item, row) in std::mem::take(&mut self.rows) {
            let since = self.arrived.remove(&item);
            if let Some(error) = row.error {
                if self.told.insert(item.clone(), error.clone()).as_ref() != Some(&error) {
                    self.aside(|| say(&format!("{} {item:<NAME$} {error}", style("✗").red().bold().for_stderr())));
                }
                continue;
            }
            self.told.remove(&item);
            let took = since.map_or(row.seconds, |since| since.elapsed().as_secs_f64());
            let wrote = if row.wrote.is_empty() { String::new() } else { format!("  → {}", row.wrote.join(", ")) };
            let cells = count(row.cooked, "cell");
            let took = style(format!("{:>7}", duration(took))).dim().for_stderr();
            self.line(&format!("{} {item:<NAME$} {took}  {cells}{wrote}", style("✓").green().for_stderr()));
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
    pub fn show(&mut self, settling: &[(PathBuf, u64)], cooking: bool) {
        let Some(term) = &self.term else { return };
        let mut parts = Vec::new();
        if cooking {
            parts.push(format!("cooking {}", count(self.running, "cell")));
        }
        for (path, bytes) in settling.iter().take(NAMED) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            parts.push(format!("{name} is being written ({})", size(*bytes)));
        }
        if settling.len() > NAMED {
            parts.push(format!("and {} more", settling.len() - NAMED));
        }
        let line = if parts.is_empty() { "waiting".to_owned() } else { parts.join("; ") };
        let line = one_line(&line, usize::from(term.size().1).saturating_sub(1));
        if line != self.shown {
            let _ = term.clear_line().and_then(|()| term.write_str(&line));
            self.shown = line;
        }
    }
}
