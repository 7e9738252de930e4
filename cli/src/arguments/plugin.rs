//! What may be written after `grimace plugin` and `grimace new`.

use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// `grimace plugin`
#[derive(Debug, Args)]
pub struct Plugin {
    /// What to do with plugins.
    #[command(subcommand)]
    pub command: PluginCommand,
}

/// The commands of `grimace plugin`.
#[derive(Debug, Subcommand)]
pub enum PluginCommand {
    /// List the plugins that are found, and which of them count
    List(PluginList),
    /// Compile a plugin's source into the component beside its plugin.ron
    Build(PluginFolder),
    /// Say what a plugin is: its nodes, imports, size and digest
    Inspect(PluginInspect),
    /// Run a plugin's nodes on made-up values: twice, in blocks and whole, and with inputs that nobody expects
    Test(PluginInspect),
    /// Pin the plugins that a graph uses as they are now
    Accept(PluginAccept),
}

/// `grimace plugin list`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace plugin list\n  grimace plugin list graph.ron --json")]
pub struct PluginList {
    /// The graph whose plugins are meant, with those of everywhere [default: those of everywhere]
    #[arg(value_name = "GRAPH")]
    pub graph: Option<PathBuf>,
    /// Print one JSON object a plugin
    #[arg(long)]
    pub json: bool,
}

/// A plugin's folder.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace plugin build plugins/smoothing\n  grimace plugin build")]
pub struct PluginFolder {
    /// The folder of its plugin.ron
    #[arg(value_name = "FOLDER", default_value = ".")]
    pub folder: PathBuf,
}

/// `grimace plugin inspect`, `grimace plugin test`
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  grimace plugin inspect plugins/smoothing\n  grimace plugin test plugins/smoothing --json"
)]
pub struct PluginInspect {
    /// The folder of its plugin.ron
    #[arg(value_name = "FOLDER", default_value = ".")]
    pub folder: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `grimace plugin accept`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace plugin accept graph.ron")]
pub struct PluginAccept {
    /// The graph beside which plugins.lock is written
    #[arg(value_name = "GRAPH")]
    pub graph: PathBuf,
}

/// `grimace new`
#[derive(Debug, Args)]
pub struct New {
    /// What to begin.
    #[command(subcommand)]
    pub command: NewCommand,
}

/// The commands of `grimace new`.
#[derive(Debug, Subcommand)]
pub enum NewCommand {
    /// Begin a plugin: a folder with a node that works, and its plugin.ron
    Plugin(NewPlugin),
}

/// `grimace new plugin`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace new plugin plugins/calm\n  grimace new plugin calm --lang c")]
pub struct NewPlugin {
    /// The folder to make; its name is the plugin's id
    #[arg(value_name = "NAME")]
    pub name: PathBuf,
    /// The language: rust, c, zig, assemblyscript or wat
    #[arg(long, value_name = "LANGUAGE", value_enum, default_value = "rust", hide_possible_values = true)]
    pub lang: Language,
    /// Where the Rust SDK lies, plugins/sdk of grimace's sources; without it, a copy comes along
    #[arg(long, value_name = "FOLDER")]
    pub sdk: Option<PathBuf>,
}

/// A language that plugins are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// Rust
    Rust,
    /// C
    C,
    /// Zig
    Zig,
    /// `AssemblyScript`
    #[value(name = "assemblyscript")]
    AssemblyScript,
    /// WebAssembly text
    Wat,
}
