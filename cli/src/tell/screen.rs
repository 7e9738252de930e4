//! Screens: where a board is shown. Bars on a terminal, plain lines in a log.

use super::board::View;
use crate::output::say;
use crate::words::{duration, one_line};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Write;
use std::time::{Duration, Instant};

/// Cells in the making that are shown at once, at most.
const SHOWN: usize = 8;
/// Columns of a cell's name beside its bar.
const NAME: usize = 28;
/// Time between two lines of progress in a log.
const LOG_INTERVAL: Duration = Duration::from_secs(5);

/// Where a board is shown.
pub trait Screen {
    /// How many running cells there is room for.
    fn room(&self) -> usize;

    /// Shows `lines` for good, and `view` for now.
    fn show(&mut self, lines: &[String], view: &View);

    /// Takes away what was shown for now.
    fn clear(&mut self);
}

/// Lines only, for logs: what is done, and every few seconds how far the cook is.
#[derive(Debug)]
pub struct Log {
    progress: bool,
    last: Instant,
}

impl Log {
    /// A log, with lines of progress or without.
    pub fn new(progress: bool) -> Self {
        Self { progress, last: Instant::now() }
    }
}

impl Screen for Log {
    fn room(&self) -> usize {
        3
    }

    fn show(&mut self, lines: &[String], view: &View) {
        if !lines.is_empty() {
            say(&lines.join("\n"));
        }
        if self.progress && self.last.elapsed() >= LOG_INTERVAL && view.planned > 0 {
            self.last = Instant::now();
            say(&progress_line(view));
        }
    }

    fn clear(&mut self) {}
}

/// `PROGRESS: 42%  17 of 40 cells; train 61% loss 0.01230`, in the form that render farms read.
fn progress_line(view: &View) -> String {
    let percent = |fraction: f64| format!("{:.0}%", (fraction * 100.0).floor());
    let mut line = format!("PROGRESS: {}  {} of {} cells", percent(view.fraction), view.done, view.planned);
    for (name, running) in &view.running {
        let _ = write!(line, "; {name}");
        if let Some(fraction) = running.fraction {
            let _ = write!(line, " {}", percent(fraction));
        }
        if !running.numbers.is_empty() {
            let _ = write!(line, " {}", running.numbers);
        }
    }
    if view.more > 0 {
        let _ = write!(line, " and {} more", view.more);
    }
    line
}

/// Bars on a terminal: one for the whole cook, and one for each cell in the making.
pub struct Bars {
    all: MultiProgress,
    overall: ProgressBar,
    cells: Vec<ProgressBar>,
    more: Option<ProgressBar>,
    style: Styles,
}

struct Styles {
    bar: ProgressStyle,
    spinner: ProgressStyle,
}

/// Steps of a bar, finer than a terminal can show.
const STEPS: u64 = 10_000;
const BAR_SIGNS: &str = "━╸─";
const SPINNER_SIGNS: &str = "⠋⠙⠹⠸⠼⠴⠦⠧⠇⠏ ";

fn styled(template: &str) -> ProgressStyle {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    style.progress_chars(BAR_SIGNS).tick_chars(SPINNER_SIGNS)
}

impl Bars {
    /// Bars on the terminal of standard error.
    pub fn new() -> Self {
        let all = MultiProgress::with_draw_target(ProgressDrawTarget::stderr_with_hz(20));
        let overall = all.add(ProgressBar::new(STEPS).with_style(styled("{bar:30.cyan/dim}  {wide_msg}")));
        let style = Styles {
            bar: styled("  {spinner:.cyan} {prefix} {bar:20.green/dim} {percent:>3}%  {wide_msg:.dim}"),
            spinner: styled("  {spinner:.cyan} {prefix} {wide_msg:.dim}"),
        };
        Self { all, overall, cells: Vec::new(), more: None, style }
    }

    /// As many lines for cells as there are cells to show.
    fn make_room(&mut self, lines: usize) {
        while self.cells.len() > lines {
            if let Some(bar) = self.cells.pop() {
                self.all.remove(&bar);
            }
        }
        while self.cells.len() < lines {
            let bar = ProgressBar::new(STEPS).with_style(self.style.spinner.clone());
            let above = self.cells.last().unwrap_or(&self.overall);
            let bar = self.all.insert_after(above, bar);
            self.cells.push(bar);
        }
    }

    /// The line below the cells: how many more there are.
    fn tell_more(&mut self, more: usize) {
        if more == 0 {
            if let Some(line) = self.more.take() {
                self.all.remove(&line);
            }
            return;
        }
        let line = self
            .more
            .get_or_insert_with(|| self.all.add(ProgressBar::new(STEPS).with_style(styled("    {wide_msg:.dim}"))));
        line.set_message(format!("and {more} more"));
    }
}

fn steps(fraction: f64) -> u64 {
    (fraction * STEPS as f64) as u64
}

impl Screen for Bars {
    fn room(&self) -> usize {
        let rows = console::Term::stderr().size_checked().map_or(24, |(rows, _)| usize::from(rows));
        SHOWN.min(rows.saturating_sub(4).max(1))
    }

    fn show(&mut self, lines: &[String], view: &View) {
        if !lines.is_empty() {
            // Standard error that cannot be written is no trouble of the cook.
            let _ = self.all.println(lines.join("\n"));
        }
        let time = duration(self.overall.elapsed().as_secs_f64());
        let mut message = format!("{}/{} cells  {time}", view.done, view.planned);
        if view.failed > 0 {
            let _ = write!(message, "  {} failed", view.failed);
        }
        if crate::signals::came() {
            message += "  cancelling …";
        }
        self.overall.set_message(message);
        self.overall.set_position(steps(view.fraction));
        self.make_room(view.running.len());
        for (bar, (name, running)) in self.cells.iter().zip(&view.running) {
            let name = one_line(name, NAME);
            let pad = NAME.saturating_sub(console::measure_text_width(&name));
            bar.set_prefix(format!("{name}{}", " ".repeat(pad)));
            let since = duration(running.since.elapsed().as_secs_f64());
            bar.set_message(format!("{since}  {}", running.numbers));
            let style = if running.fraction.is_some() { &self.style.bar } else { &self.style.spinner };
            bar.set_style(style.clone());
            bar.set_position(steps(running.fraction.unwrap_or(0.0)));
            bar.tick();
        }
        self.tell_more(view.more);
    }

    fn clear(&mut self) {
        let _ = self.all.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::progress_line;
    use crate::tell::Wanted;
    use crate::tell::board::Board;
    use graph_core::cook::Event;
    use std::collections::BTreeMap;

    #[test]
    fn farms_read_how_far_it_is() {
        let mut board = Board::new(Wanted::default(), None);
        board.take(Event::Planned { cells: 4 });
        for node in ["rig", "train", "a", "b", "c"] {
            let (node, kind, because) = (node.to_owned(), "kind".to_owned(), "it is new".to_owned());
            board.take(Event::Started { node, kind, because, blocks: 0 });
        }
        let numbers = BTreeMap::from([("loss".to_owned(), 0.0123)]);
        board.take(Event::Progress { node: "train".into(), fraction: 0.616, numbers });
        assert_eq!(
            progress_line(&board.view(3)),
            "PROGRESS: 15%  0 of 4 cells; rig; train 61% loss 0.01230; a and 2 more"
        );
    }
}
