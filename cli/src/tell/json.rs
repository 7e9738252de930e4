//! Events as JSON, one a line, each written at once.

use crate::exit::Trouble;
use crate::output::json_line;
use graph_core::cook::Event;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Prints events on standard output. Where they cannot be written, since their reader went away, the cook is cancelled.
#[derive(Debug)]
pub struct JsonLines<'a> {
    cancel: &'a AtomicBool,
    problem: Mutex<Option<io::Error>>,
}

impl<'a> JsonLines<'a> {
    /// Printing that raises `cancel` once nobody reads it.
    pub fn new(cancel: &'a AtomicBool) -> Self {
        Self { cancel, problem: Mutex::new(None) }
    }

    /// Prints one event.
    pub fn tell(&self, event: &Event) {
        // Held while writing, so that the order of lines is the order of events.
        let mut problem = self.problem.lock().unwrap_or_else(PoisonError::into_inner);
        if problem.is_some() {
            return;
        }
        let write = || {
            let line = json_line(event)?;
            let mut out = io::stdout().lock();
            out.write_all(line.as_bytes())?;
            out.flush()
        };
        if let Err(error) = write() {
            *problem = Some(error);
            self.cancel.store(true, Ordering::Relaxed);
        }
    }

    /// Ends the printing.
    ///
    /// # Errors
    /// What kept events from being written.
    pub fn finish(self) -> Result<(), Trouble> {
        let problem = self.problem.into_inner().unwrap_or_else(PoisonError::into_inner);
        problem.map_or(Ok(()), |error| Err(error.into()))
    }
}
