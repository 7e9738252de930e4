//! What comes back from the pool: results and troubles of jobs, and the tasks that they end or start anew.

use super::cell::{CellId, SlotSet, State};
use super::event::Event;
use super::job::{BlockResult, Finished, JobError};
use super::join::Join;
use super::kitchen::{Counter, Kitchen};
use crate::node::NodeError;
use crate::store::OutputRecord;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a job tells the coordinator.
pub(crate) enum Message {
    Block { cell: CellId, block: usize, result: Result<BlockResult, JobError> },
    Whole { cell: CellId, result: Result<Finished, JobError> },
    Joined { cell: CellId, result: Result<Finished, JobError> },
    Published { cell: CellId, result: Result<super::publish::Written, JobError> },
}

impl<'a> Kitchen<'a> {
    /// Takes what a job tells.
    pub fn receive<'scope>(&mut self, message: Message, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        match message {
            Message::Block { cell, block, result } => {
                let Some(task) = self.tasks.get_mut(&cell) else { return };
                task.jobs -= 1;
                match result {
                    Ok(BlockResult { blocks, seconds, frame_key }) => {
                        task.seconds += seconds;
                        if let Some(blocks) = blocks {
                            task.done.insert(block, blocks);
                        } else {
                            task.blocks.remove(&block);
                            task.kept.insert(block, block);
                        }
                        if let (Some(key), Some(place)) = (frame_key, self.cells[cell].frame_keys.get_mut(block)) {
                            *place = key;
                        }
                        let (done, all, idle) = (task.done.len(), task.blocks.len(), task.jobs == 0);
                        let node = self.cells[cell].name.clone();
                        (self.tell)(Event::Progress {
                            node,
                            fraction: done as f64 / all.max(1) as f64,
                            numbers: BTreeMap::new(),
                        });
                        if done == all {
                            self.join(cell, counter);
                        } else if idle {
                            self.ensure(cell, counter);
                        }
                    }
                    Err(error) => self.trouble(cell, error, counter),
                }
            }
            Message::Whole { cell, result } | Message::Joined { cell, result } => {
                if let Some(task) = self.tasks.get_mut(&cell) {
                    task.jobs -= 1;
                }
                match result {
                    Ok(finished) => self.served(cell, finished, counter),
                    Err(error) => self.trouble(cell, error, counter),
                }
            }
            Message::Published { cell, result } => self.published(cell, result, counter),
        }
    }

    /// Joins a per-frame cell's blocks, those just computed and those kept from the last cook.
    pub fn join<'scope>(&mut self, id: CellId, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        let Some(task) = self.tasks.get_mut(&id) else { return };
        let Some(frames) = task.frames.clone() else { return };
        let join = Join {
            ports: self.cells[id].card.outputs.clone(),
            key: self.cells[id].key,
            done: std::mem::take(&mut task.done),
            kept: task.kept.clone(),
            before: self.session.cells.get(&self.cells[id].name).map(|before| before.action.clone()),
            seconds: task.seconds,
            frames,
            known: self.cells[id].slots().cloned(),
        };
        task.jobs += 1;
        self.running += 1;
        let (sender, store) = (counter.sender.clone(), self.store);
        counter.scope.spawn(move |_| {
            let _ = sender.send(Message::Joined { cell: id, result: join.run(store) });
        });
    }

    /// A task has its values.
    fn served<'scope>(&mut self, id: CellId, finished: Finished, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        let Some(task) = self.tasks.remove(&id) else { return };
        let name = self.cells[id].name.clone();
        if let Some((parts, cause)) = task.fresh {
            let (cooked, kept) = (task.blocks.len(), task.kept.len());
            let outputs =
                finished.action.outputs.iter().map(|(port, record)| (port.clone(), outline(record))).collect();
            let seconds = finished.action.seconds;
            let run = self.session.run;
            self.note(id, &parts, finished.action, Some((run, cause)));
            self.summary.cooked += 1;
            self.summary.blocks_cooked += cooked;
            self.summary.blocks_cached += kept;
            let kind = self.kind(id);
            (self.tell)(Event::Cooked {
                node: name,
                kind,
                seconds,
                blocks_cooked: cooked,
                blocks_cached: kept,
                outputs,
            });
            self.finish(id, State::Done(Arc::new(finished.slots)));
            self.publish(id, counter);
        } else {
            self.summary.remade += 1;
            (self.tell)(Event::Remade { node: name, blocks: task.blocks.len() });
            let same = self.cells[id].slots().is_some_and(|known| take_over(known, &finished.slots));
            if !same {
                let problem = "gave another result for the same inputs; it is not a pure function of them";
                let (name, kind) = (self.cells[id].name.clone(), self.kind(id));
                let message = format!("{name} (kind `{kind}`) {problem}");
                (self.tell)(Event::Notice { about: name, message });
                // Those who wait get the new values: computing on is better than waiting for ever.
                self.cells[id].state = State::Done(Arc::new(finished.slots));
            }
            if self.cells[id].writes.is_some() {
                self.publish(id, counter);
            }
        }
        self.wake(task.waiters, counter);
    }

    fn wake<'scope>(&mut self, waiters: Vec<CellId>, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        for waiter in waiters {
            let Some(task) = self.tasks.get_mut(&waiter) else { continue };
            task.waits -= 1;
            if task.waits == 0 && !self.cancelled() {
                self.ensure(waiter, counter);
            }
        }
    }

    /// A job of a task gave no result.
    fn trouble<'scope>(&mut self, id: CellId, error: JobError, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        let name = self.cells[id].name.clone();
        let problem = match error {
            JobError::Absent(absent) => {
                if absent.damaged {
                    let message = "a stored value was damaged; it was dropped and is computed again".to_owned();
                    (self.tell)(Event::Notice { about: name.clone(), message });
                }
                let Some(task) = self.tasks.get_mut(&id) else { return };
                task.tries += 1;
                if task.tries <= 5 {
                    if task.jobs == 0 {
                        self.ensure(id, counter);
                    }
                    return;
                }
                "its inputs could not be kept: the store loses what is written to it".to_owned()
            }
            JobError::Store(error) => {
                self.cancel.store(true, std::sync::atomic::Ordering::Relaxed);
                self.broken_store.get_or_insert(error);
                return;
            }
            JobError::Node(NodeError::Cancelled) if self.cancelled() => return,
            JobError::Node(error) => error.to_string(),
        };
        let Some(task) = self.tasks.remove(&id) else { return };
        if task.fresh.is_some() {
            self.fail(id, &problem);
        } else {
            (self.tell)(Event::Notice { about: name.clone(), message: format!("could not be remade: {problem}") });
        }
        for waiter in task.waiters {
            if self.tasks.remove(&waiter).is_some_and(|waiting| waiting.fresh.is_some()) {
                self.fail(waiter, &format!("its input from {name} could not be remade: {problem}"));
            }
        }
    }
}

/// An output in one line.
fn outline(record: &OutputRecord) -> String {
    match record {
        OutputRecord::One(value) => value.summary.clone(),
        OutputRecord::List(items) => {
            let names: Vec<String> = items.keys().cloned().collect();
            format!("{} items: {}", items.len(), super::cell::some_of(&names))
        }
    }
}

/// Hands remade values to the slots that are already known; whether they are the same.
fn take_over(known: &BTreeMap<String, SlotSet>, made: &BTreeMap<String, SlotSet>) -> bool {
    known.iter().all(|(port, set)| {
        let Some(other) = made.get(port) else { return false };
        let (ours, theirs) = (set.slots(), other.slots());
        ours.len() == theirs.len()
            && ours.iter().zip(theirs).all(|(ours, theirs)| {
                let same = ours.record.digest == theirs.record.digest;
                if same && !Arc::ptr_eq(ours, theirs) {
                    ours.take_from(theirs);
                }
                same
            })
    })
}
