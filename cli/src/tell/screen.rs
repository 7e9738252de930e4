//! Screens: where a board is shown. Bars on a terminal stand in `bars`, plain lines for logs here.

use super::board::View;
use crate::output::say;
use std::fmt::Write;
use std::time::{Duration, Instant};

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
