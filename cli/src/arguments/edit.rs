//! The arguments of `grimace edit`.

use super::{CookArguments, GraphArguments, StoreArguments};
use clap::Args;
use std::path::PathBuf;

/// `grimace edit`
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  grimace edit graphs/fdls\n  grimace edit graph.ron --set epochs=3 --keys keys.ron\n\n\
                        Press ? in the editor for its keys."
)]
pub struct Edit {
    /// The graph.
    #[command(flatten)]
    pub graph: GraphArguments,
    /// How to cook.
    #[command(flatten)]
    pub cook: CookArguments,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
    /// Keys of your own: a RON file of those that differ
    #[arg(long, value_name = "FILE")]
    pub keys: Option<PathBuf>,
    /// Write into a file how long opening took, keys to the screen, and edited keys to curves, in milliseconds
    #[arg(long, value_name = "FILE", hide = true)]
    pub timings: Option<PathBuf>,
}
