//! Whether to write in colours: only on a terminal, unless the command line says otherwise.

use clap::ValueEnum;
use std::io::{self, IsTerminal};

/// When to write in colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum When {
    /// On a terminal, unless `NO_COLOR` is set
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// Sets the choice for both output streams.
pub fn choose(when: When) {
    let on = |terminal: bool| match when {
        When::Always => true,
        When::Never => false,
        When::Auto => terminal && !refused(),
    };
    console::set_colors_enabled(on(io::stdout().is_terminal()));
    console::set_colors_enabled_stderr(on(io::stderr().is_terminal()));
}

/// Whether standard error is written in colours.
pub fn on_stderr() -> bool {
    console::colors_enabled_stderr()
}

fn refused() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    set("NO_COLOR") || dumb()
}

/// Whether the terminal can only print lines.
pub fn dumb() -> bool {
    std::env::var_os("TERM").is_none_or(|term| term.is_empty() || term == "dumb")
}
