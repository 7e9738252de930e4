//! `grimace watch`: its arguments.

use super::{CookArguments, GraphArguments, StoreArguments};
use clap::Args;

/// `grimace watch`
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    grimace watch graphs/solve_day\n  \
    grimace watch graph.ron --set 'takes=/mnt/shoot/day_3/*.c3d' --settle 5 --poll\n  \
    grimace watch graph.ron --json | jq -c 'select(.event == \"summary\")'\n\n\
    Ctrl-C ends the watch, SIGHUP looks at everything again. Exit codes: 0 where no cook was cut short, else 130.")]
pub struct Watch {
    /// The graph.
    #[command(flatten)]
    pub graph: GraphArguments,
    /// What to cook.
    #[command(flatten)]
    pub cook: CookArguments,
    /// The store.
    #[command(flatten)]
    pub store: StoreArguments,
    /// Print what happens as JSON, one event a line; each cook ends in its summary
    #[arg(long)]
    pub json: bool,
    /// How long a file must stand still before it counts as complete, unless it was renamed into place
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = seconds)]
    pub settle: f64,
    /// Look at files again and again, where the system does not tell of changes; found out by itself for network disks
    #[arg(long)]
    pub poll: bool,
}

/// A time that can be waited for.
fn seconds(text: &str) -> Result<f64, String> {
    let range = 0.01..=3600.0;
    text.parse().ok().filter(|seconds| range.contains(seconds)).ok_or_else(|| "give 0.01 to 3600 seconds".to_owned())
}
