//! Carrying computations over: when cells are made anew while jobs run, what runs goes on, and the new cell that asks for the
//! same key takes it. What no cell asks for any more is stopped.

use super::cell::{CellId, Made};
use super::engine::Engine;
use super::results::Message;
use super::tasks::Task;
use std::collections::{BTreeSet, HashMap};
use std::sync::atomic::Ordering;
use wire::Digest;

/// Computations whose cells are gone.
#[derive(Default)]
pub(crate) struct Carried {
    /// By key.
    tasks: HashMap<Digest, Orphan>,
    /// The keys of carried tasks, by the generation and number of the cells that began them.
    begun: HashMap<(u64, CellId), Digest>,
}

struct Orphan {
    task: Task,
    /// The name of the cell that began it.
    name: String,
    /// What its jobs told meanwhile.
    messages: Vec<Message>,
}

impl Orphan {
    /// Jobs that still run.
    fn running(&self) -> usize {
        self.task.jobs.saturating_sub(self.messages.len())
    }
}

impl Task {
    /// Whether it can go on without its cell.
    fn can_be_carried(&self) -> bool {
        self.fresh.is_some() && self.jobs > 0 && self.waits == 0 && self.waiters.is_empty() && !self.joining
    }
}

impl Engine {
    /// Whether cells can be made anew now: all that runs can be carried over.
    pub(super) fn may_refold(&self) -> bool {
        let own: usize = self.tasks.values().filter(|task| task.can_be_carried()).map(|task| task.jobs).sum();
        self.running == own + self.orphans_running()
    }

    fn orphans_running(&self) -> usize {
        self.carried.tasks.values().map(Orphan::running).sum()
    }

    /// Takes the tasks that run out of cells that are about to go.
    pub(super) fn carry(&mut self) {
        for (id, task) in std::mem::take(&mut self.tasks) {
            let Some((made, _)) = task.fresh.as_ref().filter(|_| task.can_be_carried()) else { continue };
            let key = made.key;
            self.carried.begun.insert((self.generation, id), key);
            let name = self.cells[id].name.clone();
            self.carried.tasks.insert(key, Orphan { task, name, messages: Vec::new() });
        }
        self.generation += 1;
    }

    /// Whether a computation under the cell's key was carried over; the cell then goes on with it.
    pub(super) fn adopts(&mut self, id: CellId, made: &Made) -> bool {
        let name = &self.cells[id].name;
        for (_, other) in self.carried.tasks.iter().filter(|(key, orphan)| **key != made.key && orphan.name == *name) {
            other.task.stale.store(true, Ordering::Relaxed);
        }
        let stopped = |orphan: &Orphan| orphan.task.stale.load(Ordering::Relaxed);
        if self.carried.tasks.get(&made.key).is_none_or(stopped) {
            return false;
        }
        let Some(orphan) = self.carried.tasks.remove(&made.key) else { return false };
        self.making.insert(made.key, id);
        self.unsettle(id);
        self.tasks.insert(id, orphan.task);
        for message in orphan.messages {
            self.receive(message.of(id));
        }
        true
    }

    /// The message as the cells of today tell it; none where its cell is gone, and the message waits for another.
    pub(super) fn addressed(&mut self, generation: u64, message: Message) -> Option<Message> {
        if generation == self.generation {
            return Some(message);
        }
        let key = self.carried.begun.get(&(generation, message.cell()))?;
        if let Some(orphan) = self.carried.tasks.get_mut(key) {
            orphan.messages.push(message);
            return None;
        }
        self.making.get(key).map(|id| message.of(*id))
    }

    /// Where nothing runs but what no cell asked for: stops it. Whether nothing runs at all.
    pub(super) fn stops_orphans(&mut self) -> bool {
        if self.running == 0 {
            let left: BTreeSet<Digest> = self.tasks.values().filter_map(Task::key).collect();
            self.carried.tasks.clear();
            self.carried.begun.retain(|_, key| left.contains(key));
            return true;
        }
        if !self.items_changed && self.running == self.orphans_running() {
            self.carried.tasks.values().for_each(|orphan| orphan.task.stale.store(true, Ordering::Relaxed));
        }
        false
    }
}
