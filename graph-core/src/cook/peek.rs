//! Looking at values between cooks: what stands on an output, from memory or the store, or computed again where it was not kept.

use super::cell::{SlotSet, State};
use super::engine::Engine;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use wire::Value;

/// Why a value cannot be looked at.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PeekError {
    /// The cell is not in the graph, or has no such output.
    #[error("there is no output `{0}`")]
    Unknown(String),
    /// The cell has no result.
    #[error("`{0}` has no result yet; cook it first")]
    NotCooked(String),
    /// The result is known, but its value is neither in memory nor in the store.
    #[error("the value of `{0}` was not kept, since it is quick to compute; cook to have it again")]
    NotKept(String),
}

impl Engine {
    /// What stands on the output `port` of the cell called `cell` (`node` or `node@item`): values by item for a list, else one
    /// under the empty name. Values that were not kept are computed again, unless this engine only plans.
    ///
    /// # Errors
    /// Where there is no such output, or no value on it.
    pub fn peek(&mut self, cell: &str, port: &str) -> Result<BTreeMap<String, Arc<dyn Value>>, PeekError> {
        let name = || format!("{cell}.{port}");
        let path = cell.split_once('@').map_or(cell, |(path, _)| path);
        let of_plan = self.paths.get(path).map_or(&[][..], |at| &self.of_plan[*at]);
        let id = of_plan.iter().copied().find(|id| self.cells[*id].name == cell);
        let id = id.ok_or_else(|| PeekError::NotCooked(cell.to_owned()))?;
        let at = self.cells[id].card.outputs.iter().position(|known| known.name == port);
        let at = at.ok_or_else(|| PeekError::Unknown(name()))?;
        let State::Done(slots) = &self.cells[id].state else { return Err(PeekError::NotCooked(cell.to_owned())) };
        let slots = Arc::clone(slots);
        let set = slots.get(at).ok_or_else(|| PeekError::Unknown(name()))?;
        let items: Vec<_> = match set {
            SlotSet::One(slot) => vec![(String::new(), slot)],
            SlotSet::List(items) => items.iter().map(|(item, slot)| (item.clone(), slot)).collect(),
        };
        let store = Arc::clone(&self.shared);
        let absent: BTreeSet<usize> =
            items.iter().flat_map(|(_, slot)| slot.absent(&store.store, slot.blocks_of(None))).collect();
        if !absent.is_empty() && !self.options.dry && !self.tasks.contains_key(&id) {
            self.remake(id, absent);
            self.work();
        }
        let read = |slot: &super::slot::Slot| slot.whole(&store.store).map_err(|_| PeekError::NotKept(name()));
        items.into_iter().map(|(item, slot)| Ok((item, read(slot)?))).collect()
    }
}
