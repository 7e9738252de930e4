//! `grimace plugin` and `grimace new plugin`: nodes from outside, for those who use them and those who write them.

mod accept;
mod build;
mod inspect;
mod list;
mod test;

use crate::arguments::{New, NewCommand, PluginCommand};
use crate::exit::{Exit, Trouble};
use plugin_host::{Manifest, Plugin};
use std::path::{Path, PathBuf};

/// Does what was asked for.
pub fn plugin(command: &PluginCommand) -> Result<Exit, Trouble> {
    match command {
        PluginCommand::List(arguments) => list::list(arguments),
        PluginCommand::Build(arguments) => build::build(arguments),
        PluginCommand::Inspect(arguments) => inspect::inspect(arguments),
        PluginCommand::Test(arguments) => test::test(arguments),
        PluginCommand::Accept(arguments) => accept::accept(arguments),
    }
}

/// Begins something new.
pub fn new(arguments: &New) -> Result<Exit, Trouble> {
    match &arguments.command {
        NewCommand::Plugin(arguments) => build::new(arguments),
    }
}

/// The manifest of the plugin in `folder`; the manifest itself may be named too.
fn manifest_file(folder: &Path) -> PathBuf {
    if folder.is_file() { folder.to_owned() } else { folder.join("plugin.ron") }
}

/// Loads the plugin in `folder`.
fn load(folder: &Path) -> Result<Plugin, Trouble> {
    let file = manifest_file(folder);
    let manifest = Manifest::load(&file).map_err(Trouble::plugin)?;
    Plugin::load(&file, manifest).map_err(Trouble::plugin)
}

/// The value of a variable of the environment.
fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok()
}
