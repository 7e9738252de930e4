//! `grimace cache verify`: reads every file of the store, and drops what is damaged.

use super::store;
use crate::arguments::CacheVerify;
use crate::exit::{Exit, Trouble};
use crate::output;
use crate::words::{count, size};
use console::{Term, style};
use graph_core::care::{self, Finding};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

/// A damaged file as JSON.
#[derive(Serialize)]
struct Line<'a> {
    event: &'static str,
    #[serde(flatten)]
    finding: &'a Finding,
}

/// The last line of JSON.
#[derive(Serialize)]
struct Verified {
    event: &'static str,
    store: String,
    files: u64,
    bytes: u64,
    damaged: usize,
    dropped: usize,
    strangers: usize,
}

/// Verifies the store.
pub fn verify(arguments: &CacheVerify) -> Result<Exit, Trouble> {
    let store = store(&arguments.place)?;
    let bar = bar(care::statistics(&store).bytes());
    let verified = care::verify(&store, arguments.dry_run, &|bytes| bar.inc(bytes));
    bar.finish_and_clear();
    let (damaged, dropped) = (verified.findings.len(), verified.findings.iter().filter(|one| one.dropped).count());
    if arguments.json {
        for finding in &verified.findings {
            output::print_json(&Line { event: "damaged", finding })?;
        }
        let (files, bytes, strangers) = (verified.files, verified.bytes, verified.strangers.len());
        let store = store.root().display().to_string();
        output::print_json(&Verified { event: "verified", store, files, bytes, damaged, dropped, strangers })?;
    } else {
        for Finding { file, problem, dropped, .. } in &verified.findings {
            let fate = if *dropped { "; dropped, and made again when it is needed" } else { "" };
            output::say(&format!("{} {}: {problem}{fate}", style("✗").red().for_stderr(), file.display()));
        }
        for stranger in &verified.strangers {
            output::say(&format!("! {} is not of the store's making; it was left alone", stranger.display()));
        }
        let read = format!("{} of {} read", count(verified.files as usize, "file"), size(verified.bytes));
        let verdict = match (damaged, dropped) {
            (0, _) => "all sound".to_owned(),
            (damaged, 0) => format!("{damaged} damaged"),
            (damaged, dropped) => format!("{damaged} damaged, {dropped} of them dropped"),
        };
        output::print(&format!("{}: {read}, {verdict}\n", store.root().display()))?;
    }
    Ok(if damaged == 0 { Exit::Fine } else { Exit::Wrong })
}

/// A bar over bytes, on a terminal.
fn bar(bytes: u64) -> ProgressBar {
    let shown = Term::stderr().is_term() && !crate::colours::dumb();
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(bytes), target);
    let style = ProgressStyle::with_template("{bar:40} {bytes} of {total_bytes}, {eta} left");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}
