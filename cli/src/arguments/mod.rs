//! What may be written on the command line. Each command's help ends with examples.

mod cache;
mod edit;
mod edit_key;
#[cfg(feature = "plugins")]
mod plugin;
mod shell;
mod snapshot;
mod watch;

pub use cache::{Cache, CacheCommand, CacheGc, CachePin, CachePlace, CacheStat, CacheVerify};
pub use edit::Edit;
pub use edit_key::{EditKey, Way};
#[cfg(feature = "plugins")]
pub use plugin::{
    Language, New, NewCommand, NewPlugin, Plugin, PluginAccept, PluginCommand, PluginFolder, PluginInspect, PluginList,
};
pub use shell::{Completions, Config, ConfigCommand, ConfigExplain, Man};
pub use snapshot::{Report, Snapshot, SnapshotCommand, SnapshotOf};
pub use watch::Watch;

use crate::colours::When;
use crate::logs::Level;
use crate::words::Size;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// The whole command line.
#[derive(Debug, Parser)]
#[command(
    name = "grimace",
    version,
    about = "Cooks graphs of facial performance work, and recomputes only what a change touches",
    after_help = "Exit codes: 0 fine, 1 the graph is wrong, 2 the command line is wrong, 3 nodes failed, 130 cancelled.\n\
                  Settings: GRIMACE_STORE, GRIMACE_JOBS, GRIMACE_COLOR, GRIMACE_LOG, GRIMACE_LOG_FILE and files called \
                  grimace.ron, see `grimace config explain`; NO_COLOR turns colours off.",
    subcommand_required = true,
    arg_required_else_help = true,
    disable_help_subcommand = true,
    max_term_width = 110
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// What every command takes.
    #[command(flatten)]
    pub global: Global,
}

/// What every command takes.
#[derive(Debug, Args)]
pub struct Global {
    /// When to write in colours: auto, always or never
    #[arg(long, global = true, value_name = "WHEN", value_enum, hide_possible_values = true)]
    pub color: Option<When>,
    /// Write a log, with everything up to this level: off, error, warn, info, debug or trace [default: off]
    #[arg(long, global = true, value_name = "LEVEL", value_enum, hide_possible_values = true)]
    pub log: Option<Level>,
    /// Where the log goes, as JSON where the name ends in .json or .jsonl [default: standard error]
    #[arg(long, global = true, value_name = "FILE")]
    pub log_file: Option<PathBuf>,
    /// Only show what went wrong
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Show more: why each cell is cooked, and which were up to date
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Cook a graph: compute what changed, and write its files
    Run(Run),
    /// Cook a graph, and again whenever its files change
    Watch(Watch),
    /// Find every mistake in a graph, without cooking it
    Check(Check),
    /// Say what a cook would compute, and why
    Plan(Plan),
    /// Edit a graph in the terminal, cook it and look at its values
    Edit(Edit),
    /// Set a key over a solved curve, or take one out
    EditKey(EditKey),
    /// Say why a node was cooked
    Why(Why),
    /// List the kinds of nodes, or describe one
    Nodes(Nodes),
    /// Draw a graph in the DOT language of Graphviz
    Dot(Dot),
    /// Say what files hold: markers, curves, rigs, meshes, images
    Inspect(Inspect),
    /// Keep what a graph gives as text beside it, or compare with what was kept
    Snapshot(Snapshot),
    /// Cook a graph and write a page about it, to be read in a browser
    Report(Report),
    /// List, build, inspect and try plugins: nodes from outside
    #[cfg(feature = "plugins")]
    Plugin(Plugin),
    /// Begin something new: a plugin
    #[cfg(feature = "plugins")]
    New(New),
    /// Look after the store of results
    Cache(Cache),
    /// Say what settings there are, and what set them
    Config(Config),
    /// Print a script that completes commands and options in a shell
    Completions(Completions),
    /// Print manual pages, or write them into a folder
    Man(Man),
}

impl Command {
    /// The graph that the command is about, where it is about one.
    pub fn graph(&mut self) -> Option<&PathBuf> {
        match self {
            Self::Run(Run { graph, .. })
            | Self::Watch(Watch { graph, .. })
            | Self::Check(Check { graph, .. })
            | Self::Plan(Plan { graph, .. })
            | Self::Edit(Edit { graph, .. })
            | Self::Dot(Dot { graph }) => Some(&graph.graph),
            Self::Why(why) => Some(&why.graph),
            Self::Snapshot(snapshot) => Some(&snapshot.command.of().graph.graph),
            Self::Report(report) => Some(&report.graph),
            Self::Cache(cache) => cache.command.place().0,
            Self::Config(Config { command: ConfigCommand::Explain(explain) }) => explain.graph.as_ref(),
            #[cfg(feature = "plugins")]
            Self::Plugin(_) | Self::New(_) => None,
            Self::EditKey(_) | Self::Nodes(_) | Self::Inspect(_) | Self::Completions(_) | Self::Man(_) => None,
        }
    }

    /// The store that the command uses, and how it cooks.
    pub fn settable(&mut self) -> (Option<&mut StoreArguments>, Option<&mut CookArguments>) {
        match self {
            Self::Run(Run { store, cook, .. })
            | Self::Watch(Watch { store, cook, .. })
            | Self::Plan(Plan { store, cook, .. }) => (Some(store), Some(cook)),
            Self::Edit(edit) => (Some(&mut edit.store), Some(&mut edit.cook)),
            Self::Why(why) => (Some(&mut why.store), None),
            Self::Snapshot(snapshot) => {
                let of = snapshot.command.of();
                (Some(&mut of.store), Some(&mut of.cook))
            }
            Self::Report(report) => (Some(&mut report.store), Some(&mut report.cook)),
            Self::Cache(cache) => (Some(cache.command.place().1), None),
            _ => (None, None),
        }
    }
}

/// The graph of a command.
#[derive(Debug, Args)]
pub struct GraphArguments {
    /// A graph file, or a folder that holds a graph.ron
    #[arg(value_name = "GRAPH")]
    pub graph: PathBuf,
    /// Set a parameter of the graph, or one of a node with NODE.PARAM=VALUE; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Short for --set out=DIR
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// The store of a command.
#[derive(Debug, Args)]
pub struct StoreArguments {
    /// Where results are kept [default: .grimace beside the graph]
    #[arg(long, value_name = "DIR")]
    pub store: Option<PathBuf>,
}

/// How to cook.
#[derive(Debug, Args)]
pub struct CookArguments {
    /// Only these nodes and what they need, separated by commas
    #[arg(long, value_name = "NODE,…", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Threads [default: one for each core]
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Memory that the cook may take, such as 16GB [default: four fifths of the machine's]
    #[arg(long, value_name = "SIZE")]
    pub memory: Option<Size>,
}

/// `grimace run`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    grimace run graphs/solve_day\n  \
    grimace run graph.ron --set 'takes=~/shoot/day_3/*.c3d' --set train.steps=2000 --out out/day_3\n  \
    grimace run graph.ron --only train,rig --jobs 4\n  \
    grimace run graph.ron --json > cook.jsonl")]
pub struct Run {
    /// The graph.
    #[command(flatten)]
    pub graph: GraphArguments,
    /// What to cook.
    #[command(flatten)]
    pub cook: CookArguments,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
    /// Print what happens as JSON, one event a line; the last is the summary
    #[arg(long)]
    pub json: bool,
    /// Write what each thread did when, as a trace for Chrome or Perfetto
    #[arg(long, value_name = "FILE")]
    pub profile: Option<PathBuf>,
}

/// `grimace check`
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  grimace check graph.ron\n  grimace check graphs/solve_day --set actor=other.glb --json"
)]
pub struct Check {
    /// The graph.
    #[command(flatten)]
    pub graph: GraphArguments,
    /// Print mistakes as JSON, one a line
    #[arg(long)]
    pub json: bool,
}

/// `grimace plan`
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  grimace plan graph.ron\n  grimace plan graph.ron --set train.steps=2000 --only train"
)]
pub struct Plan {
    /// The graph.
    #[command(flatten)]
    pub graph: GraphArguments,
    /// What to cook.
    #[command(flatten)]
    pub cook: CookArguments,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
    /// Print the plan as JSON, one event a line; the last is the summary
    #[arg(long)]
    pub json: bool,
}

/// `grimace why`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace why graph.ron train\n  grimace why graph.ron solve/curves@smile_2")]
pub struct Why {
    /// A graph file, or a folder that holds a graph.ron
    #[arg(value_name = "GRAPH")]
    pub graph: PathBuf,
    /// The node, with the item where the node is cooked once an item
    #[arg(value_name = "NODE[@ITEM]")]
    pub node: String,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
}

/// `grimace nodes`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace nodes\n  grimace nodes smooth_curves\n  grimace nodes --json | jq .name")]
pub struct Nodes {
    /// The kind to describe; all are listed without it
    #[arg(value_name = "KIND")]
    pub kind: Option<String>,
    /// Print full descriptions as JSON, one kind a line
    #[arg(long)]
    pub json: bool,
}

/// `grimace dot`
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  grimace dot graph.ron | dot -Tsvg > graph.svg")]
pub struct Dot {
    /// The graph.
    #[command(flatten)]
    pub graph: GraphArguments,
}

/// `grimace inspect`
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  grimace inspect take_1.c3d actor.glb\n  grimace inspect --json takes/*.c3d | jq .missing"
)]
pub struct Inspect {
    /// The files
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Print what was found as JSON, one file a line
    #[arg(long)]
    pub json: bool,
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::{CommandFactory, Parser};

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn lists_and_repeats() {
        let line = ["grimace", "run", "g.ron", "--only", "a,b/c", "--set", "x=1", "--set", "y=a,b", "-j", "2"];
        let super::Command::Run(run) = Cli::try_parse_from(line).unwrap().command else { panic!("not run") };
        assert_eq!(run.cook.only, ["a", "b/c"]);
        assert_eq!(run.graph.set, ["x=1", "y=a,b"]);
        assert_eq!(run.cook.jobs, Some(2));
    }
}
