//! `grimace completions` and `grimace man`: what shells and `man` want to know of the command line, made from it.

use crate::arguments::{Cli, Completions, Man};
use crate::exit::{Exit, Trouble};
use crate::output;
use clap::{Command, CommandFactory};
use graph_core::document::did_you_mean;
use std::path::Path;

/// Prints the script that completes commands and options in a shell.
pub fn completions(arguments: &Completions) -> Result<Exit, Trouble> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "grimace", &mut script);
    output::print(&String::from_utf8_lossy(&script))?;
    Ok(Exit::Fine)
}

/// Prints one manual page, or writes all of them.
pub fn man(arguments: &Man) -> Result<Exit, Trouble> {
    let mut whole = Cli::command();
    whole.build();
    if let Some(folder) = &arguments.into {
        let written = std::fs::create_dir_all(folder).and_then(|()| write_all(&whole, folder));
        let count = written.map_err(|problem| {
            Trouble::command_line(format!("manual pages cannot be written to {}: {problem}", folder.display()), None)
        })?;
        output::say(&format!("wrote {count} manual pages to {}", folder.display()));
        return Ok(Exit::Fine);
    }
    let mut command = &whole;
    for name in &arguments.command {
        command = command.find_subcommand(name).ok_or_else(|| {
            let near = did_you_mean(name, command.get_subcommands().map(Command::get_name));
            let help = near.map(|near| format!("did you mean `{near}`?"));
            Trouble::command_line(format!("there is no command `{name}`"), help)
        })?;
    }
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut page)?;
    output::print(&String::from_utf8_lossy(&page))?;
    Ok(Exit::Fine)
}

/// Writes the pages of a command and of all below it; how many there are.
fn write_all(command: &Command, folder: &Path) -> std::io::Result<usize> {
    clap_mangen::Man::new(command.clone()).generate_to(folder)?;
    let below = command.get_subcommands().filter(|command| !command.is_hide_set());
    below.map(|command| write_all(command, folder)).sum::<std::io::Result<usize>>().map(|count| count + 1)
}
