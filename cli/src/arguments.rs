//! What may be written on the command line. Each command's help ends with examples.

use crate::colours::When;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// The whole command line.
#[derive(Debug, Parser)]
#[command(
    name = "grimace",
    version,
    about = "Cooks graphs of facial performance work, and recomputes only what a change touches",
    after_help = "Exit codes: 0 fine, 1 the graph is wrong, 2 the command line is wrong, 3 nodes failed, 130 cancelled.\n\
                  Environment: GRIMACE_STORE is where results are kept; NO_COLOR turns colours off.",
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
    #[arg(long, global = true, value_name = "WHEN", value_enum, default_value_t, hide_possible_values = true)]
    pub color: When,
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
    /// Find every mistake in a graph, without cooking it
    Check(Check),
    /// Say what a cook would compute, and why
    Plan(Plan),
    /// Say why a node was cooked
    Why(Why),
    /// List the kinds of nodes, or describe one
    Nodes(Nodes),
    /// Draw a graph in the DOT language of Graphviz
    Dot(Dot),
    /// Say what files hold: markers, curves, rigs, meshes, images
    Inspect(Inspect),
    /// Look after the store of results
    Cache(Cache),
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
    #[arg(long, value_name = "DIR", env = "GRIMACE_STORE", hide_env_values = true)]
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

/// `grimace cache`
#[derive(Debug, Args)]
pub struct Cache {
    /// What to do with the store.
    #[command(subcommand)]
    pub command: CacheCommand,
}

/// The commands of `grimace cache`.
#[derive(Debug, Subcommand)]
pub enum CacheCommand {
    /// Say how much the store holds
    Stat(CacheStat),
}

/// `grimace cache stat`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace cache stat graph.ron\n  grimace cache stat --store /shows/store --json")]
pub struct CacheStat {
    /// The graph whose store is meant [default: the store in this folder]
    #[arg(value_name = "GRAPH")]
    pub graph: Option<PathBuf>,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
    /// Print the counts as JSON
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
