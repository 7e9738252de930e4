//! How long things take, for who measures: `open` is from the start to the first screen, `key` from a key to the screen that
//! shows it, `curves` from a key that edits keys to the screen with the curves cooked anew.

use crate::model::State;
use std::path::PathBuf;
use std::time::Instant;

/// Times that are taken where a file for them is named.
#[derive(Debug, Default)]
pub struct Timings {
    file: Option<PathBuf>,
    taken: Vec<(&'static str, f64)>,
    edited: Option<Instant>,
}

impl Timings {
    /// Times that end in `file`, or none.
    pub fn for_file(file: Option<PathBuf>) -> Self {
        Self { file, ..Self::default() }
    }

    fn take(&mut self, what: &'static str, since: Instant) {
        if self.file.is_some() {
            self.taken.push((what, since.elapsed().as_secs_f64() * 1e3));
        }
    }

    /// The first screen shows.
    pub fn opened(&mut self, begun: Instant) {
        self.take("open", begun);
    }

    /// A key that was pressed at this time edited keys.
    pub fn edited(&mut self, pressed: Instant) {
        self.edited.get_or_insert(pressed);
    }

    /// The screen shows what keys did that were pressed at these times.
    pub fn drawn(&mut self, pressed: &[Instant], state: &State) {
        for at in pressed {
            self.take("key", *at);
        }
        let fresh = state.work.as_ref().is_some_and(|work| work.made_of == state.texts.revision);
        if let Some(at) = self.edited.take_if(|_| fresh) {
            self.take("curves", at);
        }
    }

    /// Writes all of them.
    pub fn write(&self) {
        if let Some(file) = &self.file {
            let lines: Vec<String> = self.taken.iter().map(|(what, time)| format!("{what} {time:.3}\n")).collect();
            // Who measures sees that the file is not there.
            drop(std::fs::write(file, lines.concat()));
        }
    }
}
