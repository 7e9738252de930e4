//! Edits of a plan in memory: a node with other parameters, source files with other content.

use super::cell::Settings;
use super::engine::Engine;
use crate::document::Diagnostic;
use crate::node::Node;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Why a node in memory could not be exchanged.
#[derive(Debug, thiserror::Error)]
pub enum EditError {
    /// There is no such node.
    #[error("{}", .0.message)]
    UnknownNode(Box<Diagnostic>),
    /// The new node has other ports, files or use of time, so the graph has to be planned anew.
    #[error("`{0}` would have other ports or files; load the graph again")]
    OtherCard(String),
}

impl Engine {
    /// Puts `node` in the place of the one at `path`, of the same kind with other parameters. What depends on them is dirty.
    ///
    /// # Errors
    /// Where there is no such node, or the new one has other ports, files or use of time.
    pub fn exchange(&mut self, path: &str, node: &Arc<dyn Node>) -> Result<(), EditError> {
        let Some(at) = self.paths.get(path).copied() else {
            return Err(EditError::UnknownNode(Box::new(self.plan.unknown_node(path))));
        };
        let card = node.card();
        let standing = &mut self.plan.nodes[at];
        let same = *standing.card == card && card.reads.is_none() && card.writes.is_none();
        if !same || standing.node.typetag_name() != node.typetag_name() || standing.template.mentions_item {
            return Err(EditError::OtherCard(path.to_owned()));
        }
        standing.node = Arc::clone(node);
        let settings = Arc::new(Settings::of(node.as_ref(), &standing.card));
        self.settings.insert(at, Arc::clone(&settings));
        for index in 0..self.of_plan[at].len() {
            let id = self.of_plan[at][index];
            self.cells[id].node = Arc::clone(node);
            self.cells[id].set_settings(&settings);
            self.mark(id);
        }
        Ok(())
    }

    /// Has exactly these source files count as holding this text, whatever is on disk: they are being edited and not saved yet.
    /// Where cells are there already, [`rescan`](Self::rescan) finds those that it changes.
    pub fn hold(&mut self, texts: &BTreeMap<PathBuf, String>) {
        self.shared.files.hold(texts);
    }

    /// Looks at the source files of all cells again; those whose content changed are dirty.
    pub fn rescan(&mut self) {
        for id in 0..self.cells.len() {
            let has_file = self.cells[id].file.is_some();
            if has_file && (self.file_content(id) != Ok(self.cells[id].made.file) || !self.reads_still_true(id)) {
                self.mark(id);
            }
        }
    }
}
