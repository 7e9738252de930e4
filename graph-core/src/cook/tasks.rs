//! Tasks: cells that are being computed, whole or block by block.
//!
//! A task first ensures that the values it needs are at hand: in memory or in the store. What is neither is remade by
//! a task of its producer, which this one waits for. Then its jobs run, and their results are joined.

use super::cell::{CellId, SlotSet, State, Wire};
use super::event::Event;
use super::job::{BlockResult, Finished, Job, JobError, JobInput};
use super::join::Join;
use super::key::{Frames, Part};
use super::kitchen::{Counter, Kitchen};
use super::session::Cause;
use super::slot::{CookedBlock, Slot};
use super::why::told;
use crate::node::NodeError;
use crate::store::OutputRecord;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};
use wire::Digest;

/// A cell in the making.
pub(crate) struct Task {
    /// Why it is cooked, and what its key is made of; `None` where a known value is only remade.
    fresh: Option<(Vec<Part>, Cause)>,
    /// How it is cut into blocks, for a cell that works per frame.
    frames: Option<Frames>,
    /// Blocks to compute; empty for a whole cell.
    blocks: BTreeSet<usize>,
    /// Blocks of the last cook that are still right: their position there.
    kept: BTreeMap<usize, usize>,
    done: BTreeMap<usize, Vec<CookedBlock>>,
    seconds: f64,
    /// Tasks of producers that this one waits for.
    waits: usize,
    waiters: Vec<CellId>,
    jobs: usize,
    /// How often values were found missing; a few times is bad luck, more is a broken disk.
    tries: usize,
}

/// What a job tells the coordinator.
pub(crate) enum Message {
    Block { cell: CellId, block: usize, result: Result<BlockResult, JobError> },
    Whole { cell: CellId, result: Result<Finished, JobError> },
    Joined { cell: CellId, result: Result<Finished, JobError> },
    Published { cell: CellId, result: Result<super::publish::Written, JobError> },
}

impl<'a> Kitchen<'a> {
    /// Begins to compute a cell whose result is not known.
    pub fn begin<'scope>(&mut self, id: CellId, parts: Vec<Part>, cause: Cause, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        if !self.prepared {
            self.prepared = true;
            if let Err(problem) = self.store.prepare() {
                self.broken_store = Some(problem);
                return;
            }
        }
        let frames = match self.frames(id).transpose() {
            Ok(frames) => frames.filter(|frames| frames.count > 0),
            Err(problem) => return self.fail(id, &problem),
        };
        let mut task = Task::new(frames);
        if let Some(frames) = &task.frames {
            let before = self.session.cells.get(&self.cells[id].name);
            let old: BTreeMap<_, _> = before
                .iter()
                .flat_map(|before| before.block_keys.iter().enumerate().map(|(at, key)| (*key, at)))
                .collect();
            let mut frame_keys = if frames.halo > 0 { vec![Digest::default(); frames.blocks()] } else { Vec::new() };
            for block in 0..frames.blocks() {
                match old.get(&self.cells[id].block_keys[block]) {
                    Some(at) => {
                        task.kept.insert(block, *at);
                        let known = before.and_then(|before| before.frame_keys.get(*at));
                        frame_keys.iter_mut().skip(block).take(1).zip(known).for_each(|(key, known)| *key = *known);
                    }
                    None => drop(task.blocks.insert(block)),
                }
            }
            self.cells[id].frame_keys = frame_keys;
        }
        task.fresh = Some((parts, cause));
        self.cells[id].state = State::Cooking;
        self.tasks.insert(id, task);
        self.ensure(id, counter);
    }

    /// Remakes values of a finished cell that are needed and no longer there.
    pub fn remake<'scope>(&mut self, id: CellId, blocks: BTreeSet<usize>, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        let frames = self.frames(id).and_then(Result::ok).filter(|frames| frames.count > 0);
        let mut task = Task::new(frames);
        if task.frames.is_some() {
            task.blocks = blocks;
        }
        self.tasks.insert(id, task);
        self.ensure(id, counter);
    }

    /// Sees to it that everything a task needs is at hand, then starts its jobs. Works through a list, not by
    /// recursion, since chains of values that are not kept can be long.
    pub fn ensure<'scope>(&mut self, id: CellId, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        let mut open = vec![id];
        while let Some(id) = open.pop() {
            let absent = self.absent(id);
            if absent.is_empty() {
                self.dispatch(id, counter);
                continue;
            }
            for (producer, blocks) in absent {
                if let Some(task) = self.tasks.get_mut(&id) {
                    task.waits += 1;
                }
                if let Some(task) = self.tasks.get_mut(&producer) {
                    task.waiters.push(id);
                    continue;
                }
                let frames = self.frames(producer).and_then(Result::ok).filter(|frames| frames.count > 0);
                let mut task = Task::new(frames);
                if task.frames.is_some() {
                    task.blocks = blocks;
                }
                task.waiters.push(id);
                self.tasks.insert(producer, task);
                open.push(producer);
            }
        }
    }

    /// What a task needs and is nowhere: blocks by producer.
    fn absent(&self, id: CellId) -> BTreeMap<CellId, BTreeSet<usize>> {
        let task = &self.tasks[&id];
        let mut absent: BTreeMap<CellId, BTreeSet<usize>> = BTreeMap::new();
        for link in &self.cells[id].links {
            let sliced = task.frames.is_some() && link.port.kind.framed && !link.port.still;
            for wire in &link.wires {
                for slot in self.wire_slots(wire) {
                    let mut needed = BTreeSet::new();
                    if let (true, Some(frames)) = (sliced, &task.frames) {
                        for block in task.blocks.iter().filter(|block| !task.done.contains_key(block)) {
                            needed.extend(slot.blocks_of(Some(&frames.with_halo(*block))));
                        }
                    } else {
                        needed.extend(slot.blocks_of(None));
                    }
                    let (Some(first), Some(last)) = (needed.first(), needed.last()) else { continue };
                    let missing = slot.absent(self.store, *first..*last + 1);
                    let missing: BTreeSet<_> = missing.into_iter().filter(|block| needed.contains(block)).collect();
                    if !missing.is_empty() {
                        absent.entry(wire.cell).or_default().extend(missing);
                    }
                }
            }
        }
        absent
    }

    fn wire_slots(&self, wire: &Wire) -> Vec<Arc<Slot>> {
        let set = self.cells[wire.cell].slots().and_then(|slots| slots.get(&wire.port));
        match (set, &wire.item) {
            (Some(SlotSet::List(items)), Some(item)) => items.get(item).into_iter().cloned().collect(),
            (Some(set), _) => set.slots().into_iter().cloned().collect(),
            (None, _) => Vec::new(),
        }
    }

    /// Hands the jobs of a task to the pool.
    fn dispatch<'scope>(&mut self, id: CellId, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        let blocks: Vec<usize> = {
            let task = &self.tasks[&id];
            task.blocks.iter().copied().filter(|block| !task.done.contains_key(block)).collect()
        };
        let job = Arc::new(self.job(id, counter));
        let Some(task) = self.tasks.get_mut(&id) else { return };
        let Some(frames) = task.frames.clone() else {
            task.jobs += 1;
            self.running += 1;
            let sender = counter.sender.clone();
            counter.scope.spawn(move |_| {
                let _ = sender.send(Message::Whole { cell: id, result: job.whole() });
            });
            return;
        };
        if blocks.is_empty() {
            return self.join(id, counter);
        }
        let before = self.session.cells.get(&self.cells[id].name).filter(|_| task.fresh.is_some());
        let before_keys = before.map(|before| before.frame_keys.as_slice()).unwrap_or_default();
        let frames_halo = frames.halo > 0;
        for block in blocks {
            task.jobs += 1;
            self.running += 1;
            let (sender, job) = (counter.sender.clone(), Arc::clone(&job));
            let before = before_keys.get(block).copied();
            let (own, needed) = (frames.of_block(block), frames.with_halo(block));
            counter.scope.spawn(move |_| {
                let result = if job.cancel.load(std::sync::atomic::Ordering::Relaxed) {
                    Err(NodeError::Cancelled.into())
                } else {
                    job.block(&own, &needed, frames_halo, before)
                };
                let _ = sender.send(Message::Block { cell: id, block, result });
            });
        }
    }

    fn job<'scope>(&self, id: CellId, counter: &Counter<'_, 'scope>) -> Job<'scope>
    where
        'a: 'scope,
    {
        let cell = &self.cells[id];
        let inputs = cell.links.iter().map(|link| JobInput { port: link.port, slots: self.slots_of(link) }).collect();
        let (tell, name) = (self.tell, cell.name.clone());
        let started = self.tasks[&id].fresh.as_ref().map(|(_, cause)| Event::Started {
            node: cell.name.clone(),
            kind: self.kind(id),
            because: told(cause),
            blocks: self.tasks[&id].blocks.len(),
        });
        let progress = Box::new(move |fraction: f64, numbers: &[(&str, f64)]| {
            let numbers = numbers.iter().map(|(name, number)| ((*name).to_owned(), *number)).collect();
            tell(Event::Progress { node: name.clone(), fraction, numbers });
        });
        Job {
            node: Arc::clone(&cell.node),
            card: Arc::clone(&cell.card),
            item: cell.item().to_owned(),
            key: cell.key,
            base_key: cell.base_key,
            file: cell.file.clone(),
            inputs,
            store: self.store,
            files: counter.files,
            cancel: self.cancel,
            started: Mutex::new(started),
            tell,
            progress,
            block_frames: self.options.block_frames,
        }
    }

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
    fn join<'scope>(&mut self, id: CellId, counter: &mut Counter<'_, 'scope>)
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

impl Task {
    fn new(frames: Option<Frames>) -> Self {
        Self {
            fresh: None,
            frames,
            blocks: BTreeSet::new(),
            kept: BTreeMap::new(),
            done: BTreeMap::new(),
            seconds: 0.0,
            waits: 0,
            waiters: Vec::new(),
            jobs: 0,
            tries: 0,
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
