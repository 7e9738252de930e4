//! How changes are pushed: which cells are dirty, which wait for others, and whose memory may go.

use super::cell::{CellId, SlotSet};
use super::engine::Engine;
use smallvec::{SmallVec, smallvec};

impl Engine {
    /// Says that something that a cell depends on changed.
    pub(super) fn mark(&mut self, id: CellId) {
        self.turns[id].dirty = true;
        if self.turns[id].pending == 0 {
            self.mark_later(id);
        }
    }

    /// Puts a dirty cell into the order in which cells are looked at.
    pub(super) fn mark_later(&mut self, id: CellId) {
        let turn = &mut self.turns[id];
        if !std::mem::replace(&mut turn.queued, true) {
            self.line.push(turn.plan, id);
        }
    }

    /// A cell has its result; `changed` says whether it differs from what its consumers saw.
    pub(super) fn settle(&mut self, id: CellId, changed: bool) {
        let mut open: SmallVec<[(CellId, bool); 4]> = smallvec![(id, changed)];
        while let Some((id, changed)) = open.pop() {
            let was_settled = std::mem::replace(&mut self.turns[id].settled, true);
            if was_settled && !changed {
                continue;
            }
            for index in 0..self.turns[id].consumers.len() {
                let consumer = self.turns[id].consumers[index];
                let turn = &mut self.turns[consumer];
                turn.pending -= u32::from(!was_settled);
                turn.dirty |= changed;
                match (turn.pending, turn.dirty, turn.settled) {
                    (0, true, _) => self.mark_later(consumer),
                    (0, false, false) => open.push((consumer, false)),
                    _ => {}
                }
            }
            if !was_settled {
                self.count_consumer(id, -1);
            }
            self.let_go(id);
        }
    }

    /// A cell is in the making, so everything behind it waits.
    pub(super) fn unsettle(&mut self, id: CellId) {
        let mut open: SmallVec<[CellId; 8]> = smallvec![id];
        while let Some(id) = open.pop() {
            if !std::mem::replace(&mut self.turns[id].settled, false) {
                continue;
            }
            self.count_consumer(id, 1);
            for index in 0..self.turns[id].consumers.len() {
                let consumer = self.turns[id].consumers[index];
                self.turns[consumer].pending += 1;
                if self.turns[consumer].settled {
                    open.push(consumer);
                }
            }
        }
    }

    /// Tells the producers of a cell whether one more of their consumers is not settled.
    fn count_consumer(&mut self, id: CellId, by: i32) {
        for index in 0..self.turns[id].producers.len() {
            let producer = self.turns[id].producers[index];
            let open = &mut self.turns[producer].open_consumers;
            *open = open.saturating_add_signed(by);
            if *open == 0 {
                self.let_go(producer);
            }
        }
    }

    /// Whether a cell in the making, or its own making, asks for what stands on its outputs.
    pub(super) fn is_wanted(&self, id: CellId) -> bool {
        let in_the_making = |id: &CellId| self.tasks.contains_key(id);
        self.turns[id].open_consumers > 0
            || !self.tasks.is_empty() && (in_the_making(&id) || self.turns[id].consumers.iter().any(in_the_making))
    }

    /// Releases the memory of a cell that nothing will ask any more in this cook.
    pub(super) fn let_go(&mut self, id: CellId) {
        if self.options.resident || self.is_wanted(id) {
            return;
        }
        let cell = &self.cells[id];
        let waited_for = self.folded.iter().any(|node| {
            self.plan.nodes[*node].inputs.iter().flat_map(|input| &input.sources).any(|source| source.node == cell.plan)
        });
        if !waited_for {
            let sets = cell.slots().into_iter().flat_map(|slots| slots.iter());
            sets.flat_map(SlotSet::slots).for_each(|slot| slot.release());
        }
    }
}
