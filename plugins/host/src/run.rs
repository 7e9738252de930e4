//! One evaluation: a fresh store with its limits, what the plugin may ask of the host meanwhile, and what became of it.

use crate::engine::{TABLE_ENTRIES, TICK, Ticking, engine};
use crate::fault::RunError;
use crate::kernel::Lent;
use crate::manifest::Limits;
use graph_core::node::Context;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use wasmtime::{ResourceLimiter, Store, Trap, UpdateDeadline, WasmBacktrace};

/// Frames of a backtrace that a message shows.
const SHOWN_FRAMES: usize = 8;
/// Letters of what a plugin says that are kept.
const SAID: usize = 2000;
/// Messages that one evaluation may log.
const MESSAGES: usize = 1000;

/// What a store holds: what the running plugin is allowed, and what was noted of it.
pub(crate) struct State {
    plugin: Arc<str>,
    limits: Limits,
    lent: Arc<Lent>,
    memory_bytes: usize,
    messages: usize,
    notes: Arc<Mutex<Notes>>,
}

/// What was seen of one evaluation.
#[derive(Debug, Default, Clone)]
pub(crate) struct Notes {
    /// Why the host stopped it, where it did.
    stopped: Option<RunError>,
    /// What it said last before a trap.
    panic: Option<String>,
    /// The most memory that it had, in bytes.
    pub memory_bytes: usize,
}

impl State {
    fn stop(&self, error: RunError) -> wasmtime::Error {
        let text = error.to_string();
        self.notes.lock().unwrap_or_else(PoisonError::into_inner).stopped = Some(error);
        wasmtime::Error::msg(text)
    }

    /// A message of the plugin for the log.
    pub fn log(&mut self, level: Level, message: &str) {
        self.messages += 1;
        let message: String = message.chars().take(SAID).collect();
        let plugin = &*self.plugin;
        match level {
            Level::Panic => self.notes.lock().unwrap_or_else(PoisonError::into_inner).panic = Some(message),
            _ if self.messages > MESSAGES => {}
            Level::Warning => tracing::warn!(target: "plugin", plugin, "{message}"),
            Level::Info => tracing::info!(target: "plugin", plugin, "{message}"),
            Level::Debug => tracing::debug!(target: "plugin", plugin, "{message}"),
        }
    }

    /// Progress of the plugin; answers whether it should stop.
    pub fn progress(&self, fraction: f64, numbers: &[(String, f64)]) -> bool {
        let named: Vec<(&str, f64)> = numbers.iter().map(|(name, number)| (name.as_str(), *number)).collect();
        let fraction = if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.0 };
        let stop = self.lent.with(|context| {
            context.progress(fraction, &named);
            context.cancelled()
        });
        stop.unwrap_or(false)
    }
}

/// How a message is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Level {
    Debug,
    Info,
    Warning,
    Panic,
}

impl ResourceLimiter for State {
    fn memory_growing(&mut self, current: usize, desired: usize, _: Option<usize>) -> wasmtime::Result<bool> {
        let all = self.memory_bytes.saturating_add(desired.saturating_sub(current));
        let limit_mb = u64::from(self.limits.memory_mb);
        if all as u64 > limit_mb << 20 {
            let mib = |bytes: usize| (bytes as u64).div_ceil(1 << 20);
            let (wanted_mb, had_mb) = (mib(all), mib(self.memory_bytes));
            let plugin = self.plugin.to_string();
            return Err(self.stop(RunError::Memory { plugin, wanted_mb, had_mb, limit_mb }));
        }
        self.memory_bytes = all;
        let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.memory_bytes = notes.memory_bytes.max(all);
        Ok(true)
    }

    fn table_growing(&mut self, _: usize, desired: usize, _: Option<usize>) -> wasmtime::Result<bool> {
        if desired > TABLE_ENTRIES {
            let plugin = self.plugin.to_string();
            return Err(self.stop(RunError::Table { plugin, wanted: desired, limit: TABLE_ENTRIES }));
        }
        Ok(true)
    }

    fn instances(&self) -> usize {
        1000
    }

    fn tables(&self) -> usize {
        1000
    }

    fn memories(&self) -> usize {
        100
    }
}

/// Runs `work` in a fresh store of the plugin `plugin` under `limits`, with `context` to ask for progress and cancellation.
pub(crate) fn run<R>(
    plugin: &Arc<str>,
    limits: Limits,
    context: Option<&Context<'_>>,
    work: impl FnOnce(&mut Store<State>) -> wasmtime::Result<R>,
) -> (Result<R, RunError>, Notes) {
    let notes = Arc::new(Mutex::new(Notes::default()));
    let lent = Arc::new(Lent::default());
    let done = {
        let run = || within(plugin, limits, &lent, &notes, work);
        match context {
            Some(context) => lent.lend(context, run),
            None => run(),
        }
    };
    let notes = notes.lock().unwrap_or_else(PoisonError::into_inner).clone();
    (done.map_err(|error| what(plugin, limits, &notes, &error)), notes)
}

fn within<R>(
    plugin: &Arc<str>,
    limits: Limits,
    lent: &Arc<Lent>,
    notes: &Arc<Mutex<Notes>>,
    work: impl FnOnce(&mut Store<State>) -> wasmtime::Result<R>,
) -> wasmtime::Result<R> {
    let ticking = Ticking::begin().ok_or_else(|| wasmtime::Error::msg("no thread for the clock could be started"))?;
    let state = State {
        plugin: Arc::clone(plugin),
        limits,
        lent: Arc::clone(lent),
        memory_bytes: 0,
        messages: 0,
        notes: Arc::clone(notes),
    };
    let mut store = Store::new(engine(), state);
    store.limiter(|state| state);
    // What may be copied out of the plugin: as much as it may have, and once more for what stands around the numbers.
    store.set_hostcall_fuel((limits.memory_mb as usize) << 21);
    store.set_epoch_deadline(1);
    let start = Instant::now();
    let time = Duration::from_secs_f64(limits.time_s);
    store.epoch_deadline_callback(move |store| {
        let state = store.data();
        #[allow(clippy::redundant_closure_for_method_calls, reason = "the method itself has one lifetime too few")]
        let cancelled = state.lent.with(|context| context.cancelled());
        if cancelled == Some(true) {
            return Err(state.stop(RunError::Cancelled));
        }
        if start.elapsed() > time.max(TICK) {
            let (plugin, frames) = (state.plugin.to_string(), String::new());
            return Err(state.stop(RunError::Time { plugin, seconds: state.limits.time_s, frames }));
        }
        Ok(UpdateDeadline::Continue(1))
    });
    let done = work(&mut store);
    drop(ticking);
    done
}

/// What an error of the engine means.
fn what(plugin: &Arc<str>, limits: Limits, notes: &Notes, error: &wasmtime::Error) -> RunError {
    let plugin = plugin.to_string();
    let frames = error.downcast_ref::<WasmBacktrace>().map(frames).unwrap_or_default();
    match (&notes.stopped, error.downcast_ref::<Trap>()) {
        (Some(RunError::Time { .. }), _) => RunError::Time { plugin, seconds: limits.time_s, frames },
        (Some(stopped), _) => stopped.clone(),
        (None, Some(Trap::StackOverflow)) => RunError::Stack { plugin, frames },
        (None, Some(trap)) => RunError::Trap { plugin, trap: trap.to_string(), panic: notes.panic.clone(), frames },
        (None, None) => {
            let problem = format!("{:#}", error.root_cause());
            if problem.contains("fuel") {
                let problem =
                    format!("more than {} MiB of values; raise `limits.memory_mb`, or give less", limits.memory_mb * 2);
                return RunError::Gave { plugin, problem };
            }
            if frames.is_empty() {
                return RunError::Gave { plugin, problem: format!("what cannot be read: {problem}") };
            }
            RunError::Engine { plugin, problem: format!("{problem}{frames}") }
        }
    }
}

/// What a language's own library calls its functions: they say how a panic came about, and not where.
const LIBRARY: [&str; 5] = ["__rustc::", "std::", "core::", "alloc::", "rust_"];

/// The plugin's own functions, innermost first.
fn frames(trace: &WasmBacktrace) -> String {
    let mut lines = Vec::new();
    for frame in trace.frames() {
        let readable = |name: &str| format!("{:#}", rustc_demangle::demangle(name));
        let name = frame.func_name().map_or_else(|| format!("function {}", frame.func_index()), readable);
        if lines.last() != Some(&name) {
            lines.push(name);
        }
    }
    let library = |line: &String| LIBRARY.iter().any(|start| line.starts_with(start));
    if !lines.iter().all(library) {
        lines.retain(|line| !library(line));
    }
    let more = lines.len().saturating_sub(SHOWN_FRAMES);
    lines.truncate(SHOWN_FRAMES);
    let more = if more > 0 { format!(", and {more} more") } else { String::new() };
    if lines.is_empty() { String::new() } else { format!("\n  in {}{more}", lines.join("\n  called by ")) }
}
