//! What a cook told, as far as a page needs it.

use graph_core::cook::{Event, Summary};

/// What a cook told.
#[derive(Debug, Clone, Default)]
pub struct Told {
    /// What it did.
    pub summary: Summary,
    /// Cells that failed: name, what was wrong, and the place of the node.
    pub failed: Vec<(String, String, String)>,
    /// What people should notice: what it is about, and the message.
    pub notices: Vec<(String, String)>,
}

impl Told {
    /// Takes what happened.
    pub fn take(&mut self, event: &Event) {
        match event {
            Event::Failed { node, error, place, .. } => self.failed.push((node.clone(), error.clone(), place.clone())),
            Event::Notice { about, message } => self.notices.push((about.clone(), message.clone())),
            Event::Summary(summary) => self.summary = summary.clone(),
            _ => {}
        }
    }
}
