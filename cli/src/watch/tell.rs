//! Telling how a watch goes: events as JSON, or one line a take for people.

use super::status::Status;
use crate::arguments::Global;
use crate::exit::Trouble;
use crate::{mistakes, output};
use graph_core::cook::Event;
use graph_core::document::Diagnostics;
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a watch tells beside the events of its cooks.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum WatchEvent {
    /// A file is new, or differs; it is cooked once it stands still.
    Settling {
        /// The item that it is, where it is one.
        item: String,
        /// The file.
        path: String,
        /// Its size by now.
        bytes: u64,
    },
    /// A file is complete.
    Arrived {
        /// The item that it is, where it is one.
        item: String,
        /// The file.
        path: String,
        /// Its size.
        bytes: u64,
    },
    /// A file is no longer there.
    Left {
        /// The item that it was, where it was one.
        item: String,
        /// The file.
        path: String,
    },
    /// All is cooked; the watch waits for changes.
    Waiting {
        /// Source files that are complete.
        files: usize,
        /// Source files that are being written.
        settling: usize,
        /// Whether files are looked at again and again, since the system does not tell of changes.
        polling: bool,
        /// Whether the graph is wrong as it stands; its last good version is what was cooked.
        broken: bool,
    },
    /// Everything is looked at.
    Rescan {
        /// Why.
        because: String,
    },
}

/// Where a watch is told.
#[derive(Debug)]
pub struct Teller {
    json: bool,
    status: Mutex<Status>,
    /// Raised once nobody reads what is printed.
    stop: Arc<AtomicBool>,
    problem: Mutex<Option<Trouble>>,
}

impl Teller {
    /// Telling in JSON or to people. Raises `stop` once nobody reads it.
    pub fn new(json: bool, global: &Global, stop: Arc<AtomicBool>) -> Self {
        Self { json, status: Mutex::new(Status::new(global.quiet, global.verbose)), stop, problem: Mutex::new(None) }
    }

    fn status(&self) -> MutexGuard<'_, Status> {
        self.status.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn print(&self, object: &impl Serialize) {
        if let Err(problem) = output::print_json(object) {
            self.problem.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(problem);
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    /// Tells an event of a cook.
    pub fn event(&self, event: &Event) {
        if self.json { self.print(event) } else { self.status().event(event) }
    }

    /// Tells an event of the watch.
    pub fn watch(&self, event: &WatchEvent) {
        if self.json { self.print(event) } else { self.status().watch(event) }
    }

    /// Tells what is wrong with the graph.
    pub fn mistakes(&self, found: Diagnostics) {
        if !self.json {
            self.status().aside(|| drop(mistakes::tell(found)));
        } else if let Err(problem) = mistakes::print_json(&found) {
            self.problem.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(problem);
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    /// Tells what keeps the watch from its work for now.
    pub fn trouble(&self, message: &str) {
        if self.json {
            self.print(&json!({ "event": "diagnostic", "code": "watch", "message": message }));
        } else {
            self.status().aside(|| output::error(message, None));
        }
    }

    /// Shows, on a terminal, what goes on now.
    pub fn tick(&self, settling: &[(PathBuf, u64)], cooking: bool, broken: bool) {
        if !self.json {
            self.status().show(settling, cooking, broken);
        }
    }

    /// Takes away what was shown for now.
    pub fn end(&self) {
        self.status().clear();
    }

    /// What kept events from being printed.
    ///
    /// # Errors
    /// That.
    pub fn problem(&self) -> Result<(), Trouble> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }
}
