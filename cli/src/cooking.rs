//! A cook as commands start it: options from arguments, and its mistakes on the way.

use crate::arguments::{CookArguments, Global, StoreArguments};
use crate::exit::{Exit, Trouble};
use crate::graph::{self, Asked};
use crate::logs::{self, Profile};
use crate::mistakes;
use crate::words::Size;
use graph_core::cook::{CookError, Event, Options, Rest, Summary, cook, session_name};
use graph_core::document::Diagnostics;
use graph_core::plan::Plan;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What there is to cook.
#[derive(Debug)]
pub enum Work {
    /// Nothing: the graph is as its last cook left it, and was not even read.
    None(Box<Rest>),
    /// What the graph says.
    Plan(Plan),
}

/// What there is to cook of the graph that was asked for. With `json`, its mistakes are printed and followed by a summary in
/// which nothing happened, since a summary is the last line that readers wait for.
///
/// # Errors
/// Where the graph is wrong.
pub fn find(asked: &Asked, store: &StoreArguments, options: &Options, json: bool) -> Result<Work, Trouble> {
    let found = graph::store(store, &asked.path);
    if let Some(rest) = Rest::find(&found, &asked.path, &asked.overrides, options) {
        return Ok(Work::None(Box::new(rest)));
    }
    if !json {
        return asked.load_or_tell().map(Work::Plan);
    }
    asked.load().map(Work::Plan).map_err(|found: Diagnostics| {
        let printed =
            mistakes::print_json(&found).and_then(|()| crate::output::print_json(&Event::Summary(Summary::default())));
        printed.err().unwrap_or(Trouble::Graph(found))
    })
}

/// Options of a cook.
pub fn options(arguments: &CookArguments, dry: bool) -> Options {
    let jobs = arguments.jobs.map_or(0, usize::from);
    let memory_bytes = arguments.memory.map(|Size(bytes)| bytes);
    Options { jobs, memory_bytes, only: arguments.only.clone(), dry, ..Options::default() }
}

/// Cooks what there is to cook, or in a dry run says what that would be.
///
/// # Errors
/// Where the cook could not run.
pub fn run(
    (asked, work): (&Asked, Work),
    store: &StoreArguments,
    options: &Options,
    cancel: &Arc<AtomicBool>,
    tell: &(dyn Fn(Event) + Sync),
) -> Result<Summary, Trouble> {
    let told = |event: Event| {
        logs::log(&event);
        tell(event);
    };
    let plan = match work {
        Work::None(rest) => return Ok(rest.tell(&told)),
        Work::Plan(plan) => plan,
    };
    let unknown = options.only.iter().find(|name| plan.find(name).is_empty());
    if let Some(name) = unknown {
        // Said before the store is made.
        return Err(CookError::UnknownNode(Box::new(plan.unknown_node(name))).into());
    }
    let store = Arc::new(graph::store(store, &asked.path));
    // Held for as long as the cook runs, so that nobody removes what it needs.
    let lease = if options.dry { None } else { Some(store.lease(&session_name(&store, &asked.path))?) };
    let cooked = cook(plan, &asked.overrides, Arc::clone(&store), options, Arc::clone(cancel), &told);
    drop(lease);
    Ok(cooked?)
}

/// Begins the log, and the profile that may be wanted.
///
/// # Errors
/// Where one of their files cannot be written.
pub fn begin_logs(global: &Global, profile: Option<&Path>) -> Result<Option<Profile>, Trouble> {
    let profile = profile.map(Profile::at).transpose()?;
    logs::begin(global, profile.as_ref())?;
    Ok(profile)
}

/// The exit code of a cook.
pub fn exit(summary: &Summary) -> Exit {
    match summary {
        Summary { cancelled: true, .. } => Exit::Cancelled,
        Summary { failed: 1.., .. } => Exit::NodesFailed,
        _ => Exit::Fine,
    }
}
