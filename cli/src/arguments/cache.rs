//! What may be written after `grimace cache`.

use super::StoreArguments;
use crate::words::Size;
use clap::{Args, Subcommand};
use std::path::PathBuf;

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
    /// Read every file of the store, and drop what is damaged
    Verify(CacheVerify),
    /// Remove what was least recently needed, until the rest fits
    Gc(CacheGc),
    /// Let nothing be removed that a graph needs
    Pin(CachePin),
    /// Take a graph's pin away
    Unpin(CachePin),
}

impl CacheCommand {
    /// The graph and the store that are meant.
    pub fn place(&mut self) -> (Option<&PathBuf>, &mut StoreArguments) {
        match self {
            Self::Stat(CacheStat { place, .. })
            | Self::Verify(CacheVerify { place, .. })
            | Self::Gc(CacheGc { place, .. }) => (place.graph.as_ref(), &mut place.store),
            Self::Pin(pin) | Self::Unpin(pin) => (Some(&pin.graph), &mut pin.store),
        }
    }
}

/// Which store is meant.
#[derive(Debug, Args)]
pub struct CachePlace {
    /// The graph whose store is meant [default: the store in this folder]
    #[arg(value_name = "GRAPH")]
    pub graph: Option<PathBuf>,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
}

/// `grimace cache stat`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  grimace cache stat graph.ron\n  grimace cache stat --store /shows/store --json")]
pub struct CacheStat {
    /// Which store.
    #[command(flatten)]
    pub place: CachePlace,
    /// Print the counts as JSON
    #[arg(long)]
    pub json: bool,
}

/// `grimace cache verify`
#[derive(Debug, Args)]
#[command(after_help = "Exit code: 0 where all is sound, 1 where something was damaged.\n\n\
                  Examples:\n  grimace cache verify graph.ron\n  grimace cache verify --store /shows/store --dry-run")]
pub struct CacheVerify {
    /// Which store.
    #[command(flatten)]
    pub place: CachePlace,
    /// Only say what is damaged
    #[arg(long)]
    pub dry_run: bool,
    /// Print what is damaged as JSON, one file a line; the last line counts
    #[arg(long)]
    pub json: bool,
}

/// `grimace cache gc`
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  grimace cache gc graph.ron --keep 20GB\n  grimace cache gc --store /shows/store --keep 500MB --dry-run\n  \
                  grimace cache gc --keep 0"
)]
pub struct CacheGc {
    /// Which store.
    #[command(flatten)]
    pub place: CachePlace,
    /// How much may stay: 20GB, 1.5TiB, 500MB, 0
    #[arg(long, value_name = "SIZE")]
    pub keep: Size,
    /// Only say what would be removed
    #[arg(long)]
    pub dry_run: bool,
    /// Print what is removed as JSON, one file a line; the last line counts
    #[arg(long)]
    pub json: bool,
}

/// `grimace cache pin` and `grimace cache unpin`
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  grimace cache pin shots/sh010/graph.ron\n  grimace cache unpin shots/sh010/graph.ron"
)]
pub struct CachePin {
    /// A graph file, or a folder that holds a graph.ron
    #[arg(value_name = "GRAPH")]
    pub graph: PathBuf,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
}
