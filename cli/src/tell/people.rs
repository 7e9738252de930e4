//! Showing a cook to people: events are put on the board as they come, and a thread shows it ten times a second.

use super::Wanted;
use super::bars::Bars;
use super::board::Board;
use super::ending::ending;
use super::screen::{Log, Screen};
use crate::exit::Trouble;
use crate::{colours, output, signals};
use console::Term;
use graph_core::cook::{Event, Summary};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Time between two looks at the board. Cooks that are shorter never draw a bar.
const INTERVAL: Duration = Duration::from_millis(100);

/// A cook as people see it.
#[derive(Debug)]
pub struct People {
    wanted: Wanted,
    /// Whether standard error is a terminal that can move its cursor.
    terminal: bool,
    state: Mutex<State>,
    over: Condvar,
}

#[derive(Debug)]
struct State {
    board: Board,
    over: bool,
}

/// Ends the showing, even where the cook panics.
struct EndsShowing<'a>(&'a People);

impl Drop for EndsShowing<'_> {
    fn drop(&mut self) {
        self.0.state().over = true;
        self.0.over.notify_all();
    }
}

impl People {
    /// A cook that nothing is known of yet.
    pub fn new(wanted: Wanted) -> Self {
        let term = Term::stderr();
        let terminal = term.is_term() && !colours::dumb() && !wanted.plain;
        let width = terminal.then(|| usize::from(term.size().1));
        let state = State { board: Board::new(wanted, width), over: false };
        Self { wanted, terminal, state: Mutex::new(state), over: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes what happened.
    pub fn tell(&self, event: Event) {
        self.state().board.take(event);
    }

    /// Shows the cook while `cook` runs it, and the totals afterwards.
    ///
    /// # Errors
    /// Those of `cook`.
    pub fn during(self, cook: impl FnOnce(&Self) -> Result<Summary, Trouble>) -> Result<Summary, Trouble> {
        let cooked = std::thread::scope(|scope| {
            scope.spawn(|| self.show());
            let _ends = EndsShowing(&self);
            cook(&self)
        });
        let state = self.state();
        if let Ok(summary) = &cooked
            && !(self.wanted.quiet && state.board.failed.is_empty())
        {
            output::say(&ending(&state.board, summary).join("\n"));
        }
        cooked
    }

    /// Shows the board until the cook is over.
    fn show(&self) {
        let mut screen: Box<dyn Screen> = match self {
            Self { wanted: Wanted { quiet: false, .. }, terminal: true, .. } => Box::new(Bars::new()),
            _ => Box::new(Log::new(!self.wanted.quiet)),
        };
        let mut told_of_signal = false;
        loop {
            let state = self.state();
            let waited = self.over.wait_timeout_while(state, INTERVAL, |state| !state.over);
            let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
            let (over, mut lines, view) = (state.over, state.board.take_lines(), state.board.view(screen.room()));
            // A slow terminal must not keep the cook waiting.
            drop(state);
            if signals::came() && !std::mem::replace(&mut told_of_signal, true) {
                lines.push("cancelling: running nodes are asked to stop; Ctrl-C again leaves at once".to_owned());
            }
            if over {
                screen.clear();
                if !lines.is_empty() {
                    output::say(&lines.join("\n"));
                }
                return;
            }
            screen.show(&lines, &view);
        }
    }
}
