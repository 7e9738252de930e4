//! `grimace cache gc`: removes what was least recently needed, and says what.

use super::store;
use crate::arguments::{CacheGc, Global};
use crate::exit::{Exit, Trouble};
use crate::output;
use crate::words::{count, duration, size};
use graph_core::care::{self, Collected, Removed, Spared};
use graph_core::store::Part;
use serde::Serialize;
use std::fmt::Write;

/// A removed file as JSON.
#[derive(Serialize)]
struct Line<'a> {
    event: &'static str,
    #[serde(flatten)]
    removed: &'a Removed,
    unused_seconds: u64,
    dry_run: bool,
}

/// The last line of JSON.
#[derive(Serialize)]
struct Summary {
    event: &'static str,
    store: String,
    before_bytes: u64,
    after_bytes: u64,
    removed: usize,
    removed_bytes: u64,
    leftovers: usize,
    refused: usize,
    #[serde(flatten)]
    spared: Spared,
    dry_run: bool,
}

/// Collects garbage.
pub fn collect(arguments: &CacheGc, global: &Global) -> Result<Exit, Trouble> {
    let store = store(&arguments.place)?;
    let collected = care::collect(&store, arguments.keep.0, arguments.dry_run)?;
    if arguments.json {
        print_json(&store.root().display().to_string(), &collected, arguments.dry_run)?;
    } else {
        if global.verbose {
            for one in &collected.removed {
                let unused = duration(unused_seconds(one) as f64);
                output::say(&format!("{}  {}, not needed for {unused}", one.file.display(), size(one.bytes)));
            }
        }
        for (file, problem) in &collected.refused {
            output::say(&format!("! {} cannot be removed: {problem}", file.display()));
        }
        output::print(&report(&store.root().display().to_string(), &collected, arguments))?;
    }
    Ok(if collected.refused.is_empty() { Exit::Fine } else { Exit::Wrong })
}

fn unused_seconds(removed: &Removed) -> u64 {
    removed.last_needed.elapsed().map_or(0, |age| age.as_secs())
}

fn print_json(store: &str, collected: &Collected, dry_run: bool) -> Result<(), Trouble> {
    for removed in &collected.removed {
        output::print_json(&Line { event: "removed", removed, unused_seconds: unused_seconds(removed), dry_run })?;
    }
    output::print_json(&Summary {
        event: "collected",
        store: store.to_owned(),
        before_bytes: collected.before_bytes,
        after_bytes: collected.after_bytes,
        removed: collected.removed.len(),
        removed_bytes: collected.removed.iter().map(|one| one.bytes).sum(),
        leftovers: collected.swept.len(),
        refused: collected.refused.len(),
        spared: collected.spared,
        dry_run,
    })
}

fn report(store: &str, collected: &Collected, arguments: &CacheGc) -> String {
    let verb = if arguments.dry_run { "would remove" } else { "removed" };
    let mut out = String::new();
    for (part, what) in [
        (Part::Pack, "value"),
        (Part::Action, "result"),
        (Part::Checkpoint, "checkpoint"),
        (Part::Rest, "resting note"),
        (Part::Session, "session"),
    ] {
        let of: Vec<&Removed> = collected.removed.iter().filter(|one| one.part == part).collect();
        if !of.is_empty() {
            let bytes = of.iter().map(|one| one.bytes).sum();
            let _ = writeln!(out, "{verb} {}, {}", count(of.len(), what), size(bytes));
        }
    }
    if !collected.swept.is_empty() {
        let bytes = collected.swept.iter().map(|(_, bytes)| bytes).sum();
        let _ = writeln!(out, "{verb} {} of dead processes, {}", count(collected.swept.len(), "leftover"), size(bytes));
    }
    let Spared { pinned, pinned_bytes, running, running_bytes } = collected.spared;
    if collected.after_bytes > arguments.keep.0 && pinned > 0 {
        let _ =
            writeln!(out, "kept {}, {}, that pinned graphs need", count(pinned as usize, "file"), size(pinned_bytes));
    }
    if collected.after_bytes > arguments.keep.0 && running > 0 {
        let files = count(running as usize, "file");
        let _ = writeln!(out, "kept {files}, {}, that running cooks may need", size(running_bytes));
    }
    let now = if arguments.dry_run { "would then hold" } else { "now holds" };
    out + &format!("{store} {now} {} of {}\n", size(collected.after_bytes), size(collected.before_bytes))
}
