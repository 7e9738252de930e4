//! The preview of a value: what is shown of it, and how. [`picture()`] makes ready what a value holds, away from the screen.

mod picture;

pub use picture::{Body, Picture, Table, picture};

use std::sync::Arc;

/// What the preview shows, and how it is looked at.
#[derive(Debug, Clone)]
pub struct Preview {
    of: Option<(String, String)>,
    /// What there is to show, or why there is nothing; none while it is on its way.
    pub value: Option<Result<Arc<Picture>, String>>,
    /// The frame.
    pub frame: usize,
    /// The channel or row.
    pub row: usize,
    /// Whether frames go on by themselves.
    pub playing: bool,
    /// How far bodies are turned about the upright axis.
    pub yaw_rad: f32,
    /// How far they are tilted.
    pub pitch_rad: f32,
    /// How near they are.
    pub zoom: f32,
}

impl Default for Preview {
    fn default() -> Self {
        Self { of: None, value: None, frame: 0, row: 0, playing: false, yaw_rad: 0.45, pitch_rad: 0.12, zoom: 1.0 }
    }
}

impl Preview {
    /// The cell and port that are shown or on their way.
    pub fn of(&self) -> Option<&(String, String)> {
        self.of.as_ref()
    }

    /// Whether this output is shown, or on its way.
    pub fn is_of(&self, cell: &str, port: &str) -> bool {
        self.of.as_ref().is_some_and(|(known, output)| known == cell && output == port)
    }

    /// Says that an output's value was asked for.
    pub fn ask(&mut self, cell: &str, port: &str) {
        self.of = Some((cell.to_owned(), port.to_owned()));
        self.value = None;
    }

    /// Asks anew when next looked at; what is shown stays until then.
    pub fn forget(&mut self) {
        self.of = None;
    }

    /// Shows nothing.
    pub fn show_nothing(&mut self) {
        (self.of, self.value) = (None, None);
    }

    /// Takes a value that was asked for.
    pub fn shown(&mut self, of: &(String, String), value: Result<Arc<Picture>, String>) {
        if self.of.as_ref() == Some(of) {
            self.value = Some(value);
            let (frames, rows) = self.picture().map_or((0, 0), |picture| (picture.frames(), picture.rows()));
            self.frame = self.frame.min(frames.saturating_sub(1));
            self.row = self.row.min(rows.saturating_sub(1));
        }
    }

    /// What is shown.
    pub fn picture(&self) -> Option<&Picture> {
        self.value.as_ref()?.as_ref().ok().map(AsRef::as_ref)
    }

    /// Goes `by` frames on; past the last comes the first.
    pub fn scrub(&mut self, by: isize) {
        let frames = self.picture().map_or(0, Picture::frames).max(1);
        self.frame = (self.frame + frames).saturating_add_signed(by) % frames;
    }

    /// Goes `by` channels or rows on.
    pub fn step_row(&mut self, by: isize) {
        let rows = self.picture().map_or(0, Picture::rows).max(1);
        self.row = self.row.saturating_add_signed(by).min(rows - 1);
    }
}
