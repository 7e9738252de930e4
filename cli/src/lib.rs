//! The command line of grimace: arguments in, commands out.
//!
//! [`arguments`] says what may be written, one module a command does it, [`tell`] shows a running cook to people or
//! prints it as JSON, [`logs`] writes it down, `settings` fill in what the
//! command line leaves open, [`exit`] gives the codes that scripts read. Results go to standard output; everything for people
//! goes to standard error.

// Nodes are known to a program only where their crate is linked.
use nodes as _;
#[cfg(feature = "plugins")]
use plugin_host as _;

pub mod arguments;
mod cache;
mod check;
mod colours;
mod cooking;
mod dot;
mod edit;
mod edit_key;
pub mod exit;
mod graph;
mod inspect;
pub mod logs;
mod mistakes;
mod nodes_command;
mod output;
mod plan;
#[cfg(feature = "plugins")]
mod plugin;
mod report_command;
mod run;
mod settings;
mod shell;
mod signals;
mod snapshot;
pub mod tell;
mod watch;
mod why;
pub mod words;

use arguments::{Cli, Command, ConfigCommand};
use clap::Parser;
use exit::{Exit, Trouble};
use settings::Settings;
use std::process::ExitCode;

/// Reads the command line, does what it says, and gives the exit code.
pub fn main() -> ExitCode {
    // Wrong arguments leave here, with code 2.
    let mut cli = Cli::parse();
    // Mistakes in settings are told in the colours that the command line asks for.
    colours::choose(cli.global.color.unwrap_or_default());
    let done = Settings::gather(&mut cli).and_then(|settings| {
        colours::choose(cli.global.color.unwrap_or_default());
        dispatch(&cli, &settings)
    });
    done.unwrap_or_else(|trouble: Trouble| trouble.tell()).into()
}

fn dispatch(cli: &Cli, settings: &Settings) -> Result<Exit, Trouble> {
    if !matches!(cli.command, Command::Run(_)) {
        logs::begin(&cli.global, None)?;
    }
    match &cli.command {
        Command::Run(arguments) => run::run(arguments, &cli.global),
        Command::Watch(arguments) => watch::watch(arguments, &cli.global),
        Command::Check(arguments) => check::check(arguments),
        Command::Plan(arguments) => plan::plan(arguments),
        Command::Edit(arguments) => edit::edit(arguments, &cli.global),
        Command::EditKey(arguments) => edit_key::edit_key(arguments),
        Command::Why(arguments) => why::why(arguments),
        Command::Nodes(arguments) => nodes_command::nodes(arguments),
        Command::Dot(arguments) => dot::dot(arguments),
        Command::Inspect(arguments) => inspect::inspect(arguments),
        Command::Snapshot(arguments) => snapshot::snapshot(&arguments.command, &cli.global),
        Command::Report(arguments) => report_command::report(arguments, &cli.global),
        #[cfg(feature = "plugins")]
        Command::Plugin(arguments) => plugin::plugin(&arguments.command),
        #[cfg(feature = "plugins")]
        Command::New(arguments) => plugin::new(arguments),
        Command::Cache(arguments) => cache::cache(&arguments.command, &cli.global),
        Command::Config(arguments) => match &arguments.command {
            ConfigCommand::Explain(arguments) => settings::explain(arguments, settings),
        },
        Command::Completions(arguments) => shell::completions(arguments),
        Command::Man(arguments) => shell::man(arguments),
    }
}
