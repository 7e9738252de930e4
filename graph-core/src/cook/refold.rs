//! Making all cells anew, where a list that cells repeat over has other items than before. What the engine knows goes over
//! into the new cells, as it would from one process to the next, but with the values that are in memory.

use super::cell::{Cell, Directory, KnownItems, LostLists, Slots};
use super::engine::Engine;
use super::options::CookError;
use wire::Digest;

/// What is known of a cell that is about to be made anew, beside its record.
pub(crate) struct Stood {
    key: Digest,
    slots: Slots,
    changed_run: u64,
    again_s: f64,
}

impl Stood {
    /// Hands everything to the new cell, where that has the same key.
    pub fn take_over(self, cell: &mut Cell, key: &Digest, slots: &mut Slots) {
        if self.key == *key {
            *slots = self.slots;
            (cell.changed_run, cell.again_s) = (self.changed_run, self.again_s);
        }
    }
}

impl Engine {
    /// Folds all nodes, and makes those cells anew whose items are known.
    pub(super) fn refold(&mut self) -> Result<(), CookError> {
        self.session = self.knowledge();
        self.carry();
        // A file that goes and comes again is a new one.
        self.good.retain(|path, _| path.exists());
        self.turns.clear();
        for cell in std::mem::take(&mut self.cells) {
            if let Some(slots) = cell.slots().cloned() {
                let (key, changed_run, again_s) = (cell.key(), cell.changed_run, cell.again_s);
                self.stood.insert(cell.name, Stood { key, slots, changed_run, again_s });
            }
        }
        self.of_plan.iter_mut().for_each(Vec::clear);
        (self.directory, self.known_items, self.lost_lists) = (Directory::new(), KnownItems::new(), LostLists::new());
        self.line.clear();
        self.tasks.clear();
        self.making.clear();
        self.twins.clear();
        self.stands.clear();
        self.failed.clear();
        // Told anew by the cells that are made anew.
        (self.summary.failed, self.summary.skipped, self.summary.blocks_cached) = (0, 0, 0);
        self.listed.clear();
        self.replan()?;
        self.folded.clone_from(&self.wanted);
        self.unfold();
        Ok(())
    }
}
