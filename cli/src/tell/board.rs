//! The board: what is known of a running cook, and the lines about it that wait to be shown.

use super::Wanted;
use super::failure::{Failure, block};
use crate::words::{count, duration, number, one_line, size};
use console::style;
use graph_core::cook::{Event, FILES};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// Columns of a node's name in a finished line.
const NAME: usize = 28;

/// A cell that is being computed.
#[derive(Debug, Clone)]
pub struct Running {
    /// Its place among all that were started.
    pub number: usize,
    /// When it was started.
    pub since: Instant,
    /// Fraction done, where it told.
    pub fraction: Option<f64>,
    /// Numbers such as a loss, as text.
    pub numbers: String,
}

/// How far a cook is at one moment.
#[derive(Debug)]
pub struct View {
    /// Cells known so far.
    pub planned: usize,
    /// Cells that are finished, well or not.
    pub done: usize,
    /// Cells that failed.
    pub failed: usize,
    /// Fraction of all cells that is done, cells in the making counted by their own fractions.
    pub fraction: f64,
    /// Some of the cells that are being computed, in the order in which they were started.
    pub running: Vec<(String, Running)>,
    /// How many more there are.
    pub more: usize,
}

/// What is known of a running cook.
#[derive(Debug, Default)]
pub struct Board {
    wanted: Wanted,
    /// Columns of the terminal; lines of finished cells are cut there.
    width: Option<usize>,
    planned: usize,
    done: usize,
    /// Cells that failed.
    pub failed: Vec<String>,
    running: BTreeMap<String, Running>,
    /// Files that were written.
    pub written: Vec<PathBuf>,
    lines: Vec<String>,
    started: usize,
}

impl Board {
    /// An empty board.
    pub fn new(wanted: Wanted, width: Option<usize>) -> Self {
        Self { wanted, width, ..Self::default() }
    }

    /// The lines that wait to be shown.
    pub fn take_lines(&mut self) -> Vec<String> {
        std::mem::take(&mut self.lines)
    }

    /// How far the cook is, with at most `most` running cells: first those that told how far they are, then those
    /// that run longest.
    pub fn view(&self, most: usize) -> View {
        let partly: f64 = self.running.values().filter_map(|running| running.fraction).sum();
        let mut running: Vec<_> = self.running.iter().collect();
        running.sort_by_key(|(_, running)| (running.fraction.is_none(), running.number));
        running.truncate(most);
        // Lines keep their order while cells come and go.
        running.sort_by_key(|(_, running)| running.number);
        View {
            planned: self.planned,
            done: self.done,
            failed: self.failed.len(),
            fraction: ((self.done as f64 + partly) / self.planned.max(1) as f64).min(1.0),
            more: self.running.len() - running.len(),
            running: running.into_iter().map(|(name, running)| (name.clone(), running.clone())).collect(),
        }
    }

    /// Takes what happened.
    pub fn take(&mut self, event: Event) {
        match event {
            Event::Planned { cells } => self.planned = cells,
            Event::Started { node, kind, because, .. } => {
                self.detail(|| format!("{} {node} ({kind}): {because}", style("▸").dim().for_stderr()));
                self.started += 1;
                let number = self.started;
                let running = Running { number, since: Instant::now(), fraction: None, numbers: String::new() };
                self.running.insert(node, running);
            }
            Event::Progress { node, fraction, numbers } => {
                if let Some(running) = self.running.get_mut(&node) {
                    running.fraction = Some(fraction.clamp(0.0, 1.0));
                    if !numbers.is_empty() {
                        running.numbers = shown(&numbers);
                    }
                }
            }
            Event::Cooked { node, seconds, blocks_cooked, blocks_cached, outputs, .. } => {
                self.finish(&node);
                let blocks = (blocks_cooked, blocks_cached);
                let line = || cooked(&node, seconds, blocks, &outputs);
                // A file tells of itself once it stands in its place.
                if outputs.keys().eq([FILES.name()]) { self.detail(line) } else { self.news(line) }
            }
            Event::Cached { node, kind, .. } => {
                self.finish(&node);
                self.detail(|| format!("{} {node} ({kind}): up to date", style("·").dim().for_stderr()));
            }
            Event::Remade { node, .. } => {
                self.detail(|| {
                    format!("{} {node}: made again, as the store does not keep it", style("↻").dim().for_stderr())
                });
            }
            Event::WouldCook { node, because, .. } => self.detail(|| format!("{node}: {because}")),
            Event::Failed { node, kind, error, place, inputs } => {
                self.finish(&node);
                self.lines.push(block(&Failure {
                    node: &node,
                    kind: &kind,
                    error: &error,
                    place: &place,
                    inputs: &inputs,
                }));
                self.failed.push(node);
            }
            Event::Skipped { node, because } => {
                self.finish(&node);
                self.detail(|| format!("{} {node}: skipped, as it needs {because}", style("-").yellow().for_stderr()));
            }
            Event::Wrote { path, bytes, .. } => {
                self.news(|| format!("{} {path}  {}", style("→").cyan().for_stderr(), size(bytes as u64)));
                self.written.push(path.into());
            }
            Event::Notice { about, message } => {
                self.lines.push(format!("{} {about}: {message}", style("!").yellow().bold().for_stderr()));
            }
            Event::Summary(_) => self.running.clear(),
        }
    }

    fn finish(&mut self, node: &str) {
        self.running.remove(node);
        self.done += 1;
    }

    /// A line that is shown unless people want quiet. On a terminal it is cut to one row, unless they want all.
    fn news(&mut self, line: impl FnOnce() -> String) {
        if !self.wanted.quiet {
            let line = line();
            let cut = self.width.filter(|_| !self.wanted.verbose);
            self.lines
                .push(cut.map_or_else(|| line.clone(), |width| console::truncate_str(&line, width, "…").into_owned()));
        }
    }

    /// A line that is shown where people want to see more.
    fn detail(&mut self, line: impl FnOnce() -> String) {
        if self.wanted.verbose {
            self.lines.push(line());
        }
    }
}

/// `✓ train                         2m13s  7 networks`.
fn cooked(node: &str, seconds: f64, (cooked, kept): (usize, usize), outputs: &BTreeMap<String, String>) -> String {
    let told = match outputs.values().collect::<Vec<_>>().as_slice() {
        [only] => (*only).clone(),
        _ => outputs.iter().map(|(port, summary)| format!("{port}: {summary}")).collect::<Vec<_>>().join("; "),
    };
    let blocks = if kept > 0 { format!("{cooked} of {}; ", count(cooked + kept, "block")) } else { String::new() };
    let tick = style("✓").green().for_stderr();
    let took = style(format!("{:>7}", duration(seconds))).dim().for_stderr();
    let line = format!("{tick} {node:<NAME$} {took}  {blocks}{}", one_line(&told, usize::MAX));
    line.trim_end().to_owned()
}

fn shown(numbers: &BTreeMap<String, f64>) -> String {
    numbers.iter().map(|(name, value)| format!("{name} {}", number(*value))).collect::<Vec<_>>().join("  ")
}

#[cfg(test)]
mod tests {
    use super::{Board, Wanted};
    use graph_core::cook::Event;
    use std::collections::BTreeMap;

    fn started(node: &str) -> Event {
        Event::Started { node: node.into(), kind: "kind".into(), because: "it is new".into(), blocks: 0 }
    }

    fn cooked(node: &str) -> Event {
        let outputs = BTreeMap::from([("rig".to_owned(), "53 channels,\n2 parts".to_owned())]);
        let (node, kind) = (node.into(), "kind".into());
        Event::Cooked { node, kind, seconds: 133.0, blocks_cooked: 1, blocks_cached: 3, outputs }
    }

    #[test]
    fn cells_count_by_their_fractions() {
        let mut board = Board::new(Wanted::default(), None);
        assert!(board.view(9).fraction.abs() < 1e-12);
        board.take(Event::Planned { cells: 4 });
        board.take(started("a"));
        board.take(started("b"));
        let numbers = BTreeMap::from([("loss".to_owned(), 0.25)]);
        board.take(Event::Progress { node: "a".into(), fraction: 0.5, numbers });
        assert!((board.view(9).fraction - 0.125).abs() < 1e-12);
        assert_eq!(board.running["a"].numbers, "loss 0.2500");
        board.take(cooked("b"));
        let view = board.view(0);
        assert!((view.fraction - 0.375).abs() < 1e-12);
        assert_eq!((view.done, view.planned, view.running.len(), view.more), (1, 4, 0, 1));
    }

    #[test]
    fn lines_are_as_long_as_wanted() {
        let lines = |quiet, verbose, width| {
            let mut board = Board::new(Wanted { quiet, verbose, plain: false }, width);
            board.take(started("train"));
            board.take(cooked("train"));
            board.take(Event::Notice { about: "train".into(), message: "is slow".into() });
            board.take_lines()
        };
        let finished = "✓ train                          2m13s  1 of 4 blocks; 53 channels, 2 parts";
        assert_eq!(lines(false, false, None), [finished, "! train: is slow"]);
        assert_eq!(lines(true, false, None), ["! train: is slow"]);
        assert_eq!(lines(false, true, Some(20)), ["▸ train (kind): it is new", finished, "! train: is slow"]);
        assert_eq!(console::measure_text_width(&lines(false, false, Some(50))[0]), 50);
    }
}
