//! Carrying computations over: when cells are made anew while jobs run, what runs goes on, and the new cell that asks for the
//! same key takes it. What no cell asks for any more is stopped.

use super::cell::{CellId, Made};
use super::engine::Engine;
use super::results::Message;
use super::tasks::Task;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::Ordering;
use wire::Digest;

/// Computations that were begun for cells which are gone.
#[derive(Default)]
pub(crate) struct Carried {
    /// Those that no cell of today asked for so far, by the task's number.
    tasks: BTreeMap<u64, Orphan>,
    /// The cells of today that went on with one, by the task's number.
    adopted: HashMap<u64, CellId>,
}

struct Orphan {
    task: Task,
    key: Digest,
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

    fn is_stopped(&self) -> bool {
        self.task.stale.load(Ordering::Relaxed)
    }

    fn stop(&self) {
        self.task.stale.store(true, Ordering::Relaxed);
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
            let Some(key) = task.key().filter(|_| task.can_be_carried()) else { continue };
            let name = self.cells[id].name.clone();
            self.carried.tasks.insert(task.number, Orphan { task, key, name, messages: Vec::new() });
        }
        self.carried.adopted.clear();
        self.generation += 1;
    }

    /// Whether nothing was carried over that a cell could still ask for.
    pub(super) fn carries_nothing(&self) -> bool {
        self.carried.tasks.is_empty()
    }

    /// Whether a computation under the cell's key was carried over; the cell then goes on with it.
    pub(super) fn adopts(&mut self, id: CellId, made: &Made) -> bool {
        let name = &self.cells[id].name;
        let tasks = &mut self.carried.tasks;
        tasks.values().filter(|orphan| orphan.key != made.key && orphan.name == *name).for_each(Orphan::stop);
        let fitting = tasks.iter().find(|(_, orphan)| orphan.key == made.key && !orphan.is_stopped());
        let Some(orphan) = fitting.map(|(number, _)| *number).and_then(|number| tasks.remove(&number)) else {
            return false;
        };
        self.carried.adopted.insert(orphan.task.number, id);
        self.making.insert(made.key, id);
        self.unsettle(id);
        self.tasks.insert(id, orphan.task);
        for message in orphan.messages {
            self.receive(message.of(id));
        }
        true
    }

    /// The message as the cells of today tell it; none where its cell is gone, and the message waits for another.
    pub(super) fn addressed(&mut self, generation: u64, task: Option<u64>, message: Message) -> Option<Message> {
        if generation == self.generation {
            return Some(message);
        }
        let task = task?;
        if let Some(orphan) = self.carried.tasks.get_mut(&task) {
            orphan.messages.push(message);
            return None;
        }
        self.carried.adopted.get(&task).map(|id| message.of(*id))
    }

    /// Where nothing runs but what no cell asked for: stops it. Whether nothing runs at all.
    pub(super) fn stops_orphans(&mut self) -> bool {
        if self.running == 0 {
            self.carried.tasks.clear();
            return true;
        }
        if !self.items_changed && self.running == self.orphans_running() {
            self.carried.tasks.values().for_each(Orphan::stop);
        }
        false
    }
}
