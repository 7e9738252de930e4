//! What may be written after `grimace config`, `grimace completions` and `grimace man`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// `grimace config`
#[derive(Debug, Args)]
pub struct Config {
    /// What to do with the settings.
    #[command(subcommand)]
    pub command: ConfigCommand,
}

/// The commands of `grimace config`.
#[derive(Debug, Subcommand)]
pub enum ConfigCommand {
    /// Say of each setting what it is, and what set it
    Explain(ConfigExplain),
}

/// `grimace config explain`
#[derive(Debug, Args)]
#[command(
    after_help = "Settings are read from $XDG_CONFIG_HOME/grimace/grimace.ron, from every grimace.ron above the graph (the nearest \
                  counts most), from GRIMACE_* variables and from the command line; what comes later counts more.\n\n\
                  Examples:\n  grimace config explain\n  grimace config explain store --graph shots/sh010"
)]
pub struct ConfigExplain {
    /// The setting; all are explained without it
    #[arg(value_name = "KEY")]
    pub key: Option<String>,
    /// The graph for which the settings would be [default: one in this folder]
    #[arg(long, value_name = "GRAPH")]
    pub graph: Option<PathBuf>,
    /// Print the settings as JSON, one a line
    #[arg(long)]
    pub json: bool,
}

/// `grimace completions`
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  grimace completions bash > ~/.local/share/bash-completion/completions/grimace\n  \
                  grimace completions zsh > ~/.zfunc/_grimace\n  \
                  grimace completions fish > ~/.config/fish/completions/grimace.fish"
)]
pub struct Completions {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// `grimace man`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace man | man -l -\n  grimace man cache gc | man -l -\n  \
                        grimace man --into ~/.local/share/man/man1")]
pub struct Man {
    /// The command whose page is meant [default: the page of grimace itself]
    #[arg(value_name = "COMMAND")]
    pub command: Vec<String>,
    /// Write the pages of all commands into this folder
    #[arg(long, value_name = "DIR", conflicts_with = "command")]
    pub into: Option<PathBuf>,
}
