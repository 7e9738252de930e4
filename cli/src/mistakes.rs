//! Mistakes in graphs, shown to people or printed as JSON.

use crate::exit::{Exit, Trouble};
use crate::{colours, output};
use graph_core::document::{Diagnostics, render, to_json};
use serde::Serialize;
use serde_json::Value;

/// Shows `mistakes` to people, and makes them the trouble that ends the command.
pub fn tell(mistakes: Diagnostics) -> Trouble {
    let width = usize::from(console::Term::stderr().size_checked().map_or(100, |(_, columns)| columns)).min(120);
    output::say(render(&mistakes, colours::on_stderr(), width).trim_end());
    Trouble::Graph(mistakes)
}

/// One mistake as a line of JSON.
#[derive(Serialize)]
struct Line {
    event: &'static str,
    #[serde(flatten)]
    facts: Value,
}

/// Prints `mistakes` as JSON, one a line: `{"event":"diagnostic","code":…,"message":…}`.
///
/// # Errors
/// Where standard output cannot be written.
pub fn print_json(mistakes: &Diagnostics) -> Result<(), Trouble> {
    let Value::Array(all) = to_json(mistakes) else { return Ok(()) };
    all.into_iter().try_for_each(|facts| output::print_json(&Line { event: "diagnostic", facts }))
}

/// The exit code for `mistakes`: where all of them are of the command line's `--set`, no graph is wrong.
pub fn exit(mistakes: &Diagnostics) -> Exit {
    let is_of_command_line = |message: &str| message.starts_with("`--set ") || message.starts_with("`--out ");
    let outside = mistakes.0.iter().all(|mistake| mistake.place.is_none() && is_of_command_line(&mistake.message));
    if outside { Exit::CommandLine } else { Exit::Wrong }
}
