//! What comes back from the pool: results and troubles of jobs, and the tasks that they end or start anew.

use super::cell::{CellId, Inputs, Made, SlotSet, Slots, State};
use super::engine::Engine;
use super::event::Event;
use super::job::{Finished, JobError};
use super::join::Join;
use super::session::Reason;
use super::stretch::BlockResult;
use crate::node::{NodeError, PortFacts};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// What a job tells the coordinator.
pub(crate) enum Message {
    /// Neighbouring blocks from `first` on, those before the trouble where there was one.
    Blocks {
        cell: CellId,
        first: usize,
        results: Vec<BlockResult>,
        trouble: Option<JobError>,
    },
    Whole {
        cell: CellId,
        result: Result<Finished, JobError>,
    },
    Joined {
        cell: CellId,
        result: Result<Finished, JobError>,
    },
    Published {
        cell: CellId,
        result: Result<super::publish::Written, JobError>,
    },
}

impl Message {
    /// The same of another cell.
    pub fn of(mut self, id: CellId) -> Self {
        match &mut self {
            Self::Blocks { cell, .. }
            | Self::Whole { cell, .. }
            | Self::Joined { cell, .. }
            | Self::Published { cell, .. } => *cell = id,
        }
        self
    }
}

impl Engine {
    /// Takes what a job tells.
    pub(super) fn receive(&mut self, message: Message) {
        match message {
            Message::Blocks { cell, first, results, trouble } => self.received(cell, first, results, trouble),
            Message::Whole { cell, result } | Message::Joined { cell, result } => {
                if let Some(task) = self.tasks.get_mut(&cell) {
                    task.jobs -= 1;
                }
                match result {
                    Ok(finished) => self.served(cell, finished),
                    Err(error) => self.trouble(cell, error),
                }
            }
            Message::Published { cell, result } => self.published(cell, result),
        }
    }

    /// A job has ended that computed blocks of a cell, from `first` on.
    fn received(&mut self, cell: CellId, first: usize, results: Vec<BlockResult>, trouble: Option<JobError>) {
        let Some(task) = self.tasks.get_mut(&cell) else { return };
        task.jobs -= 1;
        for (block, BlockResult { blocks, seconds, frames, frame_key }) in (first..).zip(results) {
            task.seconds += seconds;
            if let Some(blocks) = blocks {
                task.done.insert(block, blocks);
                task.computed.insert(block, frames);
            } else {
                task.blocks.remove(&block);
                task.kept.insert(block, block);
            }
            let keys = task.fresh.as_mut().map(|(made, _)| &mut made.frame_keys);
            if let (Some(key), Some(place)) = (frame_key, keys.and_then(|keys| keys.get_mut(block))) {
                *place = key;
            }
        }
        if let Some(trouble) = trouble {
            return self.trouble(cell, trouble);
        }
        let (done, all, idle) = (task.done.len(), task.blocks.len(), task.jobs == 0);
        self.tell(|| Event::Progress {
            node: self.cells[cell].name.clone(),
            fraction: done as f64 / all.max(1) as f64,
            numbers: BTreeMap::new(),
        });
        if done == all {
            self.join(cell);
        } else if idle {
            self.ensure(cell);
        }
    }

    /// Joins a per-frame cell's blocks, those just computed and those kept from the last cook.
    pub(super) fn join(&mut self, id: CellId) {
        let before_s = self.before_s(id);
        let Some(task) = self.tasks.get_mut(&id) else { return };
        let Some(frames) = task.frames.clone() else { return };
        let computed = std::mem::take(&mut task.computed);
        let frames_done = computed.values().map(Range::len).sum::<usize>();
        let join = Join {
            ports: self.cells[id].card.outputs.clone(),
            key: task.fresh.as_ref().map(|(made, _)| made.key),
            done: std::mem::take(&mut task.done),
            kept: task.kept.clone(),
            before: task.last.take().map(|last| last.action),
            seconds: task.seconds,
            again_s: (frames.count <= 4 * frames_done)
                .then(|| before_s + task.seconds * frames.count as f64 / frames_done as f64),
            run: self.session.run,
            computed,
            frames,
            held: self.cells[id].slots().cloned(),
        };
        task.jobs += 1;
        task.joining = true;
        self.spawn(id, move |shared| Message::Joined { cell: id, result: join.run(shared) });
    }

    /// A task has its values.
    fn served(&mut self, id: CellId, finished: Finished) {
        let Some(task) = self.tasks.remove(&id) else { return };
        let name = self.cells[id].name.clone();
        let remade = task.fresh.is_none();
        if let Some((made, reason)) = task.fresh {
            let key = made.key;
            let blocks = (task.blocks.len(), task.kept.len());
            self.costs.learn(self.cells[id].plan, finished.seconds);
            self.cooked(id, made, reason, finished, blocks);
            self.release_twins(&key);
        } else {
            self.summary.remade += 1;
            self.tell(|| Event::Remade { node: name.clone(), blocks: task.blocks.len() });
            let same = self.cells[id].slots().is_some_and(|known| take_over(known, &finished.slots));
            if !same {
                let problem = "gave another result for the same inputs; it is not a pure function of them";
                let message = format!("{name} (kind `{}`) {problem}", self.kind(id));
                self.tell(|| Event::Notice { about: name, message });
                // Those who wait get the new values: computing on is better than waiting for ever.
                self.cells[id].state = State::Done(finished.slots);
            }
            if self.cells[id].writes.is_some() {
                self.publish(id);
            }
        }
        self.wake(task.waiters);
        if remade {
            // What it was computed from was held for it, though no cell behind that is in the making.
            for index in 0..self.turns[id].producers.len() {
                self.let_go(self.turns[id].producers[index]);
            }
        }
    }

    /// A cell was computed.
    pub(super) fn cooked(
        &mut self,
        id: CellId,
        made: Made,
        reason: Reason,
        finished: Finished,
        blocks: (usize, usize),
    ) {
        self.summary.blocks_cooked += blocks.0;
        self.summary.blocks_cached += blocks.1;
        let slots = self.note_cooked(id, reason, finished, blocks);
        self.done(id, made, slots);
        self.publish(id);
    }

    /// A plain cell was computed.
    pub(super) fn plainly_cooked(&mut self, id: CellId, inputs: Inputs, reason: Reason, finished: Finished) {
        let slots = self.note_cooked(id, reason, finished, (0, 0));
        let cell = &mut self.cells[id];
        let changed =
            cell.slots().is_none_or(|seen| !seen.iter().map(SlotSet::digest).eq(slots.iter().map(SlotSet::digest)));
        if changed {
            cell.changed_run = self.session.run;
        }
        cell.made.inputs = inputs;
        cell.plainly_made = true;
        cell.state = State::Done(slots);
        self.settle(id, changed);
    }

    /// Notes that a cell was computed, and why, and tells so. What stands on its outputs.
    fn note_cooked(&mut self, id: CellId, reason: Reason, finished: Finished, blocks: (usize, usize)) -> Slots {
        self.summary.cooked += 1;
        let cell = &mut self.cells[id];
        cell.cooked = Some((self.session.run, reason));
        (cell.seconds, cell.again_s, cell.reads) = (finished.seconds, finished.again_s, finished.reads);
        let cell = &self.cells[id];
        self.tell(|| Event::Cooked {
            node: cell.name.clone(),
            kind: self.kind(id),
            seconds: finished.seconds,
            blocks_cooked: blocks.0,
            blocks_cached: blocks.1,
            outputs: cell.card.outputs.iter().zip(&*finished.slots).map(outline).collect(),
        });
        finished.slots
    }

    fn wake(&mut self, waiters: Vec<CellId>) {
        for waiter in waiters {
            let Some(task) = self.tasks.get_mut(&waiter) else { continue };
            task.waits -= 1;
            if task.waits == 0 && !self.cancelled() {
                self.ensure(waiter);
            }
        }
    }

    /// A job of a task gave no result.
    fn trouble(&mut self, id: CellId, error: JobError) {
        let name = self.cells[id].name.clone();
        let problem = match error {
            JobError::Absent(absent) => {
                if absent.damaged {
                    let message = "a stored value was damaged; it was dropped and is computed again".to_owned();
                    self.tell(|| Event::Notice { about: name.clone(), message });
                }
                let Some(task) = self.tasks.get_mut(&id) else { return };
                task.tries += 1;
                if task.tries <= 5 {
                    if task.jobs == 0 {
                        self.ensure(id);
                    }
                    return;
                }
                "its inputs could not be kept: the store loses what is written to it".to_owned()
            }
            JobError::Store(error) => {
                // What still runs would be lost.
                self.shared.cancel.store(true, std::sync::atomic::Ordering::Relaxed);
                self.broken.get_or_insert(error.into());
                return;
            }
            JobError::Node(NodeError::Cancelled) if self.cancelled() => return,
            JobError::Node(error) => error.to_string(),
        };
        let Some(task) = self.tasks.remove(&id) else { return };
        if self.withdraws(id) {
            // All cells are made anew, those that wait for this one too.
            return;
        }
        if let Some((made, _)) = &task.fresh {
            self.note_failure(id, made.key, &problem);
            self.fail(id, &problem);
            self.release_twins(&made.key);
        } else {
            self.tell(|| Event::Notice { about: name.clone(), message: format!("could not be remade: {problem}") });
        }
        for waiter in task.waiters {
            if let Some((made, _)) = self.tasks.remove(&waiter).and_then(|waiting| waiting.fresh) {
                self.fail(waiter, &format!("its input from {name} could not be remade: {problem}"));
                self.release_twins(&made.key);
            }
        }
    }
}

/// An output in one line, by its port.
fn outline((port, set): (&PortFacts, &SlotSet)) -> (String, String) {
    let line = match set {
        SlotSet::One(slot) => slot.record().summary.clone(),
        SlotSet::List(items) => {
            let names: Vec<String> = items.keys().cloned().collect();
            format!("{} items: {}", items.len(), super::cell::some_of(&names))
        }
    };
    (port.name.to_owned(), line)
}

/// Hands the values of other slots to those that are known; whether they are the same.
pub(super) fn take_over(known: &Slots, made: &Slots) -> bool {
    known.iter().zip(made.iter()).all(|(set, other)| {
        let (ours, theirs) = (set.slots(), other.slots());
        ours.len() == theirs.len()
            && ours.iter().zip(theirs).all(|(ours, theirs)| {
                let same = ours.digest == theirs.digest;
                if same && !Arc::ptr_eq(ours, theirs) {
                    ours.take_from(theirs);
                }
                same
            })
    })
}
