//! Profiles in the trace format that Chrome and Perfetto show: a complete event for each cell or block that
//! was computed, on its thread, and counters beside them.

use crate::exit::Trouble;
use graph_core::cook::Event;
use serde_json::{Map, Value, json};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing_subscriber::Registry;
use tracing_subscriber::layer::{Context, Layer};

/// What is known of a cook over time.
#[derive(Debug, Clone)]
pub struct Profile {
    path: PathBuf,
    start: Instant,
    state: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    events: Vec<Value>,
    known: usize,
    done: usize,
    running: usize,
}

thread_local! {
    /// The number of this thread in the profile; 0 before it has one.
    static THREAD: Cell<u64> = const { Cell::new(0) };
}
static THREADS: AtomicU64 = AtomicU64::new(1);

/// What a span is called, and what else it says.
#[derive(Default)]
struct Told {
    name: String,
    facts: Map<String, Value>,
    /// When it was entered, in microseconds from the start.
    entered_us: f64,
}

impl Visit for Told {
    fn record_u64(&mut self, field: &Field, value: u64) {
        self.facts.insert(field.name().to_owned(), json!(value));
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        if field.name() == "cell" {
            value.clone_into(&mut self.name);
        } else {
            self.facts.insert(field.name().to_owned(), json!(value));
        }
    }

    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        self.facts.insert(field.name().to_owned(), json!(format!("{value:?}")));
    }
}

impl Profile {
    /// A profile that will stand at `path`, which must be a place for a file.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn at(path: &Path) -> Result<Self, Trouble> {
        let profile = Self { path: path.to_owned(), start: Instant::now(), state: Arc::default() };
        profile.write()?;
        Ok(profile)
    }

    /// What `tracing` tells of spans goes here.
    pub fn layer(&self) -> Spans {
        Spans(self.clone())
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now_us(&self) -> f64 {
        self.start.elapsed().as_secs_f64() * 1e6
    }

    /// The number of this thread, which is told when it is first asked.
    fn thread(&self) -> u64 {
        let known = THREAD.get();
        if known > 0 {
            return known;
        }
        let number = THREADS.fetch_add(1, Ordering::Relaxed);
        THREAD.set(number);
        let named = std::thread::current().name().map(ToOwned::to_owned);
        let name = named.unwrap_or_else(|| format!("worker {number}"));
        let told = json!({ "ph": "M", "name": "thread_name", "pid": 1, "tid": number, "args": { "name": name } });
        self.state().events.push(told);
        number
    }

    /// Takes what counters need from an event.
    pub fn take(&self, event: &Event) {
        let now_us = self.now_us();
        let mut state = self.state();
        match event {
            Event::Planned { cells } => state.known = *cells,
            Event::Started { .. } => state.running += 1,
            Event::Cooked { .. } => {
                state.running = state.running.saturating_sub(1);
                state.done += 1;
            }
            Event::Failed { node, error, .. } => {
                state.running = state.running.saturating_sub(1);
                state.done += 1;
                let facts = json!({ "error": error });
                let name = format!("{node} failed");
                state.events.push(
                    json!({ "ph": "i", "s": "g", "name": name, "pid": 1, "tid": 0, "ts": now_us, "args": facts }),
                );
            }
            Event::Cached { .. } | Event::Skipped { .. } => state.done += 1,
            Event::Progress { node, numbers, .. } if !numbers.is_empty() => {
                state.events.push(json!({ "ph": "C", "name": node, "pid": 1, "ts": now_us, "args": numbers }));
                return;
            }
            _ => return,
        }
        let counts =
            json!({ "waiting": state.known.saturating_sub(state.done + state.running), "running": state.running });
        state.events.push(json!({ "ph": "C", "name": "cells", "pid": 1, "ts": now_us, "args": counts }));
    }

    /// Writes the profile as it is now.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write(&self) -> Result<(), Trouble> {
        let state = self.state();
        let text = json!({ "displayTimeUnit": "ms", "traceEvents": state.events }).to_string();
        std::fs::write(&self.path, text).map_err(|problem| {
            let message = format!("the profile {} cannot be written: {problem}", self.path.display());
            Trouble::command_line(message, Some("name another file with --profile".to_owned()))
        })
    }
}

/// The spans of a profile, as `tracing` hands them over. A span that a thread takes up while it waits within another ends
/// before that one goes on, so that spans of one thread lie beside or within each other.
#[derive(Debug)]
pub struct Spans(Profile);

impl Layer<Registry> for Spans {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, Registry>) {
        let mut told = Told::default();
        attributes.record(&mut told);
        if told.name.is_empty() {
            attributes.metadata().name().clone_into(&mut told.name);
        }
        if let Some(span) = context.span(id) {
            span.extensions_mut().insert(told);
        }
    }

    fn on_enter(&self, id: &Id, context: Context<'_, Registry>) {
        self.0.thread();
        if let Some(span) = context.span(id)
            && let Some(told) = span.extensions_mut().get_mut::<Told>()
        {
            told.entered_us = self.0.now_us();
        }
    }

    fn on_exit(&self, id: &Id, context: Context<'_, Registry>) {
        let (now_us, thread) = (self.0.now_us(), self.0.thread());
        let Some(span) = context.span(id) else { return };
        let extensions = span.extensions();
        let Some(told) = extensions.get::<Told>() else { return };
        let event = json!({
            "ph": "X", "cat": span.name(), "name": told.name, "pid": 1, "tid": thread,
            "ts": told.entered_us, "dur": now_us - told.entered_us, "args": told.facts,
        });
        self.0.state().events.push(event);
    }
}
