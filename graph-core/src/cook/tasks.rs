//! Tasks: cells that are being computed, whole or block by block.
//!
//! A task first ensures that the values it needs are at hand: in memory or in the store. What is neither is remade by
//! a task of its producer, which this one waits for. Then its jobs run, and their results are joined.

use super::cell::{CellId, Made, SlotSet, State, Wire};
use super::engine::Engine;
use super::event::Event;
use super::job::{Job, JobInput};
use super::key::Frames;
use super::results::Message;
use super::session::Reason;
use super::slot::{CookedBlock, Slot};
use super::stretch::stretches;
use super::why::told;
use crate::store::Action;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize};
use std::sync::{Arc, Mutex};
use wire::Digest;

/// A cell in the making.
pub(crate) struct Task {
    /// By which messages of its jobs find it.
    pub number: u64,
    /// What its key is made of, and why it is computed; `None` where a known value is only remade.
    pub fresh: Option<(Made, Reason)>,
    /// How it is cut into blocks, for a cell that works per frame.
    pub frames: Option<Frames>,
    /// Blocks to compute; empty for a whole cell.
    pub blocks: BTreeSet<usize>,
    /// Blocks of the last cook that are still right: their position there.
    pub kept: BTreeMap<usize, usize>,
    /// What the last cook knew of the cell, for its kept blocks.
    pub last: Option<Last>,
    pub done: BTreeMap<usize, Vec<CookedBlock>>,
    pub seconds: f64,
    /// The frames that were computed in each block.
    pub computed: BTreeMap<usize, Range<usize>>,
    /// Tasks of producers that this one waits for.
    pub waits: usize,
    pub waiters: Vec<CellId>,
    pub jobs: usize,
    /// Whether its last job runs, which puts blocks together.
    pub joining: bool,
    /// Raised where no cell asks for its result any more.
    pub stale: Arc<AtomicBool>,
    /// How often values were found missing; a few times is bad luck, more is a broken disk.
    pub tries: usize,
}

/// What the last cook knew of a cell that works per frame.
pub(crate) struct Last {
    pub block_keys: Vec<Digest>,
    pub frame_keys: Vec<Digest>,
    pub action: Action,
}

impl Engine {
    /// Begins to compute a cell whose result is not known.
    pub(super) fn begin(&mut self, id: CellId, mut made: Made, reason: Reason) {
        if !std::mem::replace(&mut self.prepared, true)
            && let Err(problem) = self.shared.store.prepare()
        {
            self.broken = Some(problem.into());
            return;
        }
        let frames = match self.frames(id).transpose() {
            Ok(frames) => frames.filter(|frames| frames.count > 0),
            Err(problem) => return self.fail(id, &problem),
        };
        if frames.is_none() && self.costs.cheap(self.cells[id].plan) && !self.waits_for_values(id) {
            return self.compute_here(id, made, reason);
        }
        if self.follows_twin(id, &made.key) {
            return;
        }
        let mut task = Task::new(self.next_task(), frames);
        if let Some(frames) = &task.frames {
            task.last = self.last(id);
            let last = task.last.as_ref();
            let keys = last.map(|last| last.block_keys.as_slice()).unwrap_or_default();
            let old: HashMap<_, _> = keys.iter().enumerate().map(|(at, key)| (*key, at)).collect();
            let halo = frames.halo > 0;
            made.frame_keys = if halo { vec![Digest::default(); frames.blocks()] } else { Vec::new() };
            for block in 0..frames.blocks() {
                match old.get(&made.block_keys[block]) {
                    Some(at) => {
                        task.kept.insert(block, *at);
                        let known = last.and_then(|last| last.frame_keys.get(*at));
                        made.frame_keys
                            .iter_mut()
                            .skip(block)
                            .take(1)
                            .zip(known)
                            .for_each(|(key, known)| *key = *known);
                    }
                    None => drop(task.blocks.insert(block)),
                }
            }
        }
        // Jobs and other cells see the key that is in the making.
        task.fresh = Some((made, reason));
        self.unsettle(id);
        self.tasks.insert(id, task);
        self.ensure(id);
    }

    /// Whether another cell of the same key is in the making; this one is then looked at again when that is done.
    fn follows_twin(&mut self, id: CellId, key: &Digest) -> bool {
        let first = *self.making.entry(*key).or_insert(id);
        if first == id {
            return false;
        }
        self.unsettle(id);
        self.twins.entry(*key).or_default().push(id);
        true
    }

    /// The computation under `key` is over, however it went: cells of the same key look whether the store has its result.
    pub(super) fn release_twins(&mut self, key: &Digest) {
        self.making.remove(key);
        if self.twins.contains_key(key) {
            self.shared.writer.finish();
        }
        for twin in self.twins.remove(key).unwrap_or_default() {
            self.mark(twin);
        }
    }

    /// What is known of the cell's blocks, from this engine or an earlier process.
    fn last(&self, id: CellId) -> Option<Last> {
        let cell = &self.cells[id];
        if matches!(cell.state, State::Done(_)) {
            let (block_keys, frame_keys) = (cell.made.block_keys.clone(), cell.made.frame_keys.clone());
            return Some(Last { block_keys, frame_keys, action: cell.action() });
        }
        let before = cell.before.as_ref()?;
        let (block_keys, frame_keys) = (before.block_keys.clone(), before.frame_keys.clone());
        Some(Last { block_keys, frame_keys, action: before.action.clone() })
    }

    /// Seconds to have a cell's inputs again, where they are not kept: at least those of the dearest. (What several of them
    /// share would be counted twice in a sum.)
    pub(super) fn before_s(&self, id: CellId) -> f64 {
        self.turns[id].producers.iter().map(|producer| self.cells[*producer].again_s).fold(0.0, f64::max)
    }

    /// Whether a value that a whole cell needs is neither in memory nor known to be in the store.
    fn waits_for_values(&self, id: CellId) -> bool {
        let wires = self.cells[id].links.iter().flat_map(|link| &link.wires);
        wires.into_iter().any(|wire| match (self.standing(wire), &wire.item) {
            (Some(SlotSet::One(slot)), _) => !slot.at_hand(),
            (Some(SlotSet::List(items)), Some(item)) => items.get(item).is_none_or(|slot| !slot.at_hand()),
            (Some(SlotSet::List(items)), None) => !items.values().all(|slot| slot.at_hand()),
            (None, _) => true,
        })
    }

    fn next_task(&mut self) -> u64 {
        self.tasks_begun += 1;
        self.tasks_begun
    }

    /// Remakes values of a finished cell that are needed and no longer there.
    pub(super) fn remake(&mut self, id: CellId, blocks: BTreeSet<usize>) {
        let frames = self.frames(id).and_then(Result::ok).filter(|frames| frames.count > 0);
        let mut task = Task::new(self.next_task(), frames);
        if task.frames.is_some() {
            task.blocks = blocks;
        }
        self.tasks.insert(id, task);
        self.ensure(id);
    }

    /// Sees to it that everything a task needs is at hand, then starts its jobs. Works through a list, not by
    /// recursion, since chains of values that are not kept can be long.
    pub(super) fn ensure(&mut self, id: CellId) {
        let mut open = vec![id];
        while let Some(id) = open.pop() {
            let absent = self.absent(id);
            if absent.is_empty() {
                self.dispatch(id);
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
                let mut task = Task::new(self.next_task(), frames);
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
            let sliced = task.frames.is_some() && link.framed();
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
                    let missing = slot.absent(&self.shared.store, *first..*last + 1);
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
        match (self.standing(wire), &wire.item) {
            (Some(SlotSet::List(items)), Some(item)) => items.get(item).into_iter().cloned().collect(),
            (Some(set), _) => set.slots().into_iter().cloned().collect(),
            (None, _) => Vec::new(),
        }
    }

    /// Hands the jobs of a task to the pool.
    fn dispatch(&mut self, id: CellId) {
        let blocks: Vec<usize> = {
            let task = &self.tasks[&id];
            task.blocks.iter().copied().filter(|block| !task.done.contains_key(block)).collect()
        };
        let job = Arc::new(self.job(id));
        let Some(task) = self.tasks.get_mut(&id) else { return };
        let Some(frames) = task.frames.clone() else {
            task.jobs += 1;
            return self.spawn(id, move |shared| Message::Whole { cell: id, result: job.whole(shared) });
        };
        if blocks.is_empty() {
            return self.join(id);
        }
        let last = task.last.as_ref().filter(|_| task.fresh.is_some());
        let before: Arc<[Digest]> = last.map(|last| last.frame_keys.as_slice()).unwrap_or_default().into();
        let Some(threads) = self.threads() else { return };
        for stretch in stretches(&blocks, &frames, threads, &job.parts) {
            let (job, frames, before) = (Arc::clone(&job), frames.clone(), Arc::clone(&before));
            if let Some(task) = self.tasks.get_mut(&id) {
                task.jobs += 1;
            }
            self.spawn(id, move |shared| {
                let (results, trouble) = job.stretch(shared, &frames, stretch.clone(), &before);
                Message::Blocks { cell: id, first: stretch.start, results, trouble }
            });
        }
    }

    fn job(&self, id: CellId) -> Job {
        let cell = &self.cells[id];
        let inputs = cell.links.iter().map(|link| JobInput { port: link.port, slots: self.slots_of(link) }).collect();
        let task = &self.tasks[&id];
        let started = task.fresh.as_ref().filter(|_| self.shared.tell.is_some()).map(|(_, reason)| Event::Started {
            node: cell.name.clone(),
            kind: self.kind(id),
            because: told(&self.cause(id, reason)),
            blocks: task.blocks.len(),
        });
        Job {
            node: Arc::clone(&cell.node),
            card: Arc::clone(&cell.card),
            name: cell.name.clone(),
            item: cell.item().to_owned(),
            key: task.fresh.as_ref().map_or_else(|| cell.key(), |(made, _)| made.key),
            base_key: cell.base_key,
            file: cell.file.clone(),
            content: task.fresh.as_ref().map_or(cell.made.file, |(made, _)| made.file),
            stale: Arc::clone(&task.stale),
            inputs,
            before_s: self.before_s(id),
            parts: self.parts(id),
            call_blocks: AtomicUsize::new(1),
            started: Mutex::new(started),
        }
    }
}

impl Task {
    /// The key under which a result is computed.
    pub fn key(&self) -> Option<Digest> {
        self.fresh.as_ref().map(|(made, _)| made.key)
    }

    fn new(number: u64, frames: Option<Frames>) -> Self {
        Self {
            number,
            fresh: None,
            frames,
            blocks: BTreeSet::new(),
            kept: BTreeMap::new(),
            last: None,
            done: BTreeMap::new(),
            seconds: 0.0,
            computed: BTreeMap::new(),
            waits: 0,
            waiters: Vec::new(),
            jobs: 0,
            joining: false,
            stale: Arc::default(),
            tries: 0,
        }
    }
}
