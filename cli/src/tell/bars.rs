//! Bars on a terminal: one for the whole cook, and one for each cell in the making.

use super::board::View;
use super::screen::Screen;
use crate::words::{duration, one_line};
use console::Term;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle, TermLike};
use std::fmt::Write;
use std::io;

/// Cells in the making that are shown at once, at most.
const SHOWN: usize = 8;
/// Columns of a cell's name beside its bar.
const NAME: usize = 28;

/// A terminal whose cursor waits at the left. indicatif leaves it at the right end of the last line, where the `^C` that
/// a terminal writes itself would go to the next line, and bars would no longer be cleared away.
#[derive(Debug)]
struct CursorAtLeft(Term);

impl TermLike for CursorAtLeft {
    fn width(&self) -> u16 {
        self.0.size().1
    }

    fn height(&self) -> u16 {
        self.0.size().0
    }

    fn move_cursor_up(&self, rows: usize) -> io::Result<()> {
        self.0.move_cursor_up(rows)
    }

    fn move_cursor_down(&self, rows: usize) -> io::Result<()> {
        self.0.move_cursor_down(rows)
    }

    fn move_cursor_right(&self, columns: usize) -> io::Result<()> {
        self.0.move_cursor_right(columns)
    }

    fn move_cursor_left(&self, columns: usize) -> io::Result<()> {
        self.0.move_cursor_left(columns)
    }

    fn write_line(&self, line: &str) -> io::Result<()> {
        self.0.write_line(line)
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        self.0.write_str(text)
    }

    fn clear_line(&self) -> io::Result<()> {
        self.0.clear_line()
    }

    fn flush(&self) -> io::Result<()> {
        self.0.write_str("\r")?;
        self.0.flush()
    }
}

/// The bars.
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
        let terminal = CursorAtLeft(Term::buffered_stderr());
        let all = MultiProgress::with_draw_target(ProgressDrawTarget::term_like_with_hz(Box::new(terminal), 20));
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
        let rows = Term::stderr().size_checked().map_or(24, |(rows, _)| usize::from(rows));
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
