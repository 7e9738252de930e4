//! What may be written after `grimace snapshot` and `grimace report`.

use super::{CookArguments, GraphArguments, StoreArguments};
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// `grimace snapshot`
#[derive(Debug, Args)]
pub struct Snapshot {
    /// What to do with the snapshot.
    #[command(subcommand)]
    pub command: SnapshotCommand,
}

/// The commands of `grimace snapshot`.
#[derive(Debug, Subcommand)]
pub enum SnapshotCommand {
    /// Cook the graph and keep what its outputs are, in the folder golden beside it
    Accept(SnapshotOf),
    /// Cook the graph and compare its outputs with the snapshot that was accepted
    Check(SnapshotOf),
}

impl SnapshotCommand {
    /// What is said of the graph.
    pub fn of(&mut self) -> &mut SnapshotOf {
        match self {
            Self::Accept(of) | Self::Check(of) => of,
        }
    }
}

/// The graph of a snapshot.
#[derive(Debug, Args)]
#[command(
    after_help = "A snapshot holds the `outputs` of the graph, and every value that a node takes which writes a file. No file \
                  of the graph is written. What is set when a snapshot is accepted is kept with it, and set again when it is checked.\n\n\
                  Examples:\n  grimace snapshot accept graphs/fdls --set epochs=1\n  grimace snapshot check graphs/fdls --json"
)]
pub struct SnapshotOf {
    /// The graph.
    #[command(flatten)]
    pub graph: GraphArguments,
    /// How to cook.
    #[command(flatten)]
    pub cook: CookArguments,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
    /// Print what became of each output as JSON, one a line
    #[arg(long)]
    pub json: bool,
}

/// `grimace report`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace report graphs/fdls\n  \
                  grimace report graph.ron --set takes='day_3/*.c3d' --set out=out/day_3 --out out/day_3.html")]
pub struct Report {
    /// A graph file, or a folder that holds a graph.ron
    #[arg(value_name = "GRAPH")]
    pub graph: PathBuf,
    /// Set a parameter of the graph, or one of a node with NODE.PARAM=VALUE; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Where the page is written [default: report.html beside the graph]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// How to cook.
    #[command(flatten)]
    pub cook: CookArguments,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
}
