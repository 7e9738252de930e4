//! `grimace edit`: the editor in the terminal.

use crate::arguments::{Edit, Global};
use crate::cooking;
use crate::exit::{Exit, Trouble};
use crate::graph::{self, Asked};
use editor_tui::session;
use graph_core::plan::tidy;
use std::io::{IsTerminal, stdin, stdout};

/// Edits the graph until the person leaves.
pub fn edit(arguments: &Edit, global: &Global) -> Result<Exit, Trouble> {
    if !stdin().is_terminal() || !stdout().is_terminal() {
        let message = "`edit` needs a terminal: its input or output leads elsewhere";
        return Err(Trouble::command_line(message, Some("`grimace check`, `plan` and `run` do without one".into())));
    }
    if global.log.is_some() && global.log_file.is_none() {
        let message = "a log would be written over the editor";
        return Err(Trouble::command_line(message, Some("give it a file: --log-file FILE".into())));
    }
    let asked = Asked::read(&arguments.graph)?;
    let path = tidy(&asked.path);
    let done = session::edit(&session::Asked {
        store: graph::store_place(&arguments.store, &path),
        graph: path,
        overrides: asked.overrides,
        options: cooking::options(&arguments.cook, false),
        keys: arguments.keys.clone(),
        timings: arguments.timings.clone(),
    });
    done.map(|()| Exit::Fine).map_err(|problem| Trouble::command_line(problem.to_string(), None))
}
