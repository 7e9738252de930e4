//! The command line of grimace: arguments in, commands out.
//!
//! [`arguments`] says what may be written, one module a command does it, [`tell`] shows a running cook to people or
//! prints it as JSON, [`exit`] gives the codes that scripts read. Results go to standard output; everything for people
//! goes to standard error.

// Nodes are known to a program only where their crate is linked.
use nodes as _;

pub mod arguments;
mod cache;
mod check;
mod colours;
mod cooking;
mod dot;
pub mod exit;
mod graph;
mod inspect;
mod mistakes;
mod nodes_command;
mod output;
mod plan;
mod run;
mod signals;
pub mod tell;
mod why;
mod words;

use arguments::{CacheCommand, Cli, Command};
use clap::Parser;
use exit::Trouble;
use std::process::ExitCode;

/// Reads the command line, does what it says, and gives the exit code.
pub fn main() -> ExitCode {
    // Wrong arguments leave here, with code 2.
    let cli = Cli::parse();
    colours::choose(cli.global.color);
    let done = match &cli.command {
        Command::Run(arguments) => run::run(arguments, &cli.global),
        Command::Check(arguments) => check::check(arguments),
        Command::Plan(arguments) => plan::plan(arguments),
        Command::Why(arguments) => why::why(arguments),
        Command::Nodes(arguments) => nodes_command::nodes(arguments),
        Command::Dot(arguments) => dot::dot(arguments),
        Command::Inspect(arguments) => inspect::inspect(arguments),
        Command::Cache(arguments) => match &arguments.command {
            CacheCommand::Stat(arguments) => cache::stat(arguments),
        },
    };
    done.unwrap_or_else(|trouble: Trouble| trouble.tell()).into()
}
