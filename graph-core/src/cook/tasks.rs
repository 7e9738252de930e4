//! Tasks: cells that are being computed, whole or block by block.
//!
//! A task first ensures that the values it needs are at hand: in memory or in the store. What is neither is remade by
//! a task of its producer, which this one waits for. Then its jobs run, and their results are joined.

use super::cell::{CellId, SlotSet, State, Wire};
use super::event::Event;
use super::job::{Job, JobInput};
use super::key::{Frames, Part};
use super::kitchen::{Counter, Kitchen};
use super::results::Message;
use super::session::Cause;
use super::slot::{CookedBlock, Slot};
use super::why::told;
use crate::node::NodeError;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};
use wire::Digest;

/// A cell in the making.
pub(crate) struct Task {
    /// Why it is cooked, and what its key is made of; `None` where a known value is only remade.
    pub fresh: Option<(Vec<Part>, Cause)>,
    /// How it is cut into blocks, for a cell that works per frame.
    pub frames: Option<Frames>,
    /// Blocks to compute; empty for a whole cell.
    pub blocks: BTreeSet<usize>,
    /// Blocks of the last cook that are still right: their position there.
    pub kept: BTreeMap<usize, usize>,
    pub done: BTreeMap<usize, Vec<CookedBlock>>,
    pub seconds: f64,
    /// Tasks of producers that this one waits for.
    pub waits: usize,
    pub waiters: Vec<CellId>,
    pub jobs: usize,
    /// How often values were found missing; a few times is bad luck, more is a broken disk.
    pub tries: usize,
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
