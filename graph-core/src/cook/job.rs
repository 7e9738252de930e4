//! Jobs: what runs on the pool's threads: one computation of a whole cell, or of blocks of its frames (`stretch`).

use super::cell::{SlotSet, Slots};
use super::cost::{CHEAP_S, FILE_S};
use super::event::Event;
use super::key::content_of;
use super::part::Part;
use super::shared::Shared;
use super::slot::{Absent, CookedBlock, Slot, cut, pack_of};
use crate::node::{Card, Context, Host, Inputs, Node, NodeError, Outputs, PortFacts, PortValue, SourceFile};
use crate::store::{Action, StoreError, ValueRecord};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use wire::{Digest, Value};

/// Why a job gave no result.
#[derive(Debug)]
pub(crate) enum JobError {
    /// The node failed.
    Node(NodeError),
    /// A value that the job needs has to be computed again first.
    Absent(Absent),
    /// The store could not be written.
    Store(StoreError),
}

impl From<NodeError> for JobError {
    fn from(error: NodeError) -> Self {
        Self::Node(error)
    }
}

impl From<Absent> for JobError {
    fn from(absent: Absent) -> Self {
        Self::Absent(absent)
    }
}

impl From<StoreError> for JobError {
    fn from(error: StoreError) -> Self {
        Self::Store(error)
    }
}

/// An input of a job.
pub(crate) struct JobInput {
    pub port: PortFacts,
    /// One slot, or several by the names that a gathering port shows.
    pub slots: Vec<(String, Arc<Slot>)>,
}

/// Everything that a computation needs, free of the coordinator.
pub(crate) struct Job {
    pub node: Arc<dyn Node>,
    pub card: Arc<Card>,
    pub name: String,
    pub item: String,
    pub key: Digest,
    /// The part of the blocks' keys that all of them share.
    pub base_key: Digest,
    pub file: Option<PathBuf>,
    /// What the file held when the key was made, with its ending.
    pub content: Option<Digest>,
    /// Raised where no cell asks for the result any more.
    pub stale: Arc<AtomicBool>,
    pub inputs: Vec<JobInput>,
    /// Seconds to have the inputs again, where they are not kept.
    pub before_s: f64,
    /// Blocks of which only some frames are computed.
    pub parts: BTreeMap<usize, Part>,
    /// How many blocks a call of a per-frame node may have, at a guess from the calls before.
    pub call_blocks: AtomicUsize,
    /// What is told when the first thread takes this job up.
    pub started: Mutex<Option<Event>>,
}

/// The engine's side of a node's context.
pub(crate) struct Desk<'a> {
    pub shared: &'a Shared,
    pub name: &'a str,
    /// Gives the key under which the cell is computed.
    pub key: &'a (dyn Fn() -> Digest + Sync),
    pub file: Option<&'a Path>,
    pub content: Option<Digest>,
    pub stale: &'a AtomicBool,
    pub reads: Mutex<Vec<(String, Digest)>>,
}

impl Host for Desk<'_> {
    fn stale(&self) -> bool {
        self.stale.load(Ordering::Relaxed)
    }

    fn memory_bytes(&self) -> u64 {
        self.shared.memory.budget
    }

    fn progress(&self, fraction: f64, numbers: &[(&str, f64)]) {
        self.shared.tell(|| {
            let numbers = numbers.iter().map(|(name, number)| ((*name).to_owned(), *number)).collect();
            Event::Progress { node: self.name.to_owned(), fraction, numbers }
        });
    }

    fn source(&self) -> Result<SourceFile, NodeError> {
        let path = self.file.ok_or_else(|| NodeError::failed("this node has no source file"))?;
        let (bytes, digest) =
            self.shared.files.read(path).map_err(|problem| NodeError::file(&path.display().to_string(), problem))?;
        if self.content.is_some_and(|known| known != content_of(path, &digest)) {
            let problem = "changed while it was being cooked; cook again once nobody writes it";
            return Err(NodeError::file(&path.display().to_string(), problem));
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(SourceFile { name, bytes })
    }

    fn sibling(&self, name: &str) -> Result<Arc<Vec<u8>>, NodeError> {
        let main = self.file.ok_or_else(|| NodeError::failed("this node has no source file"))?;
        let path = main.parent().unwrap_or(Path::new("")).join(name);
        let (bytes, digest) =
            self.shared.files.read(&path).map_err(|problem| NodeError::file(&path.display().to_string(), problem))?;
        self.reads.lock().unwrap_or_else(PoisonError::into_inner).push((name.to_owned(), digest));
        Ok(bytes)
    }

    fn checkpoint(&self, name: &str) -> Option<Vec<u8>> {
        self.shared.store.checkpoint(&(self.key)(), name)
    }

    fn save_checkpoint(&self, name: &str, state: &[u8]) {
        // A checkpoint that cannot be saved costs time after a crash, and nothing else.
        let _ = self.shared.store.put_checkpoint(&(self.key)(), name, state);
    }
}

impl Desk<'_> {
    /// Computes `node`, whose panics are its failures.
    pub fn compute(&self, node: &dyn Node, item: &str, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let context = Context::new(self, &self.shared.cancel, item);
        catch_unwind(AssertUnwindSafe(|| node.compute(&context, inputs)))
            .unwrap_or_else(|panic| Err(NodeError::Failed(panic_text(panic.as_ref()))))
    }
}

/// What a whole computation gave.
pub(crate) struct Finished {
    /// In the order of the card's outputs.
    pub slots: Slots,
    pub reads: Vec<(String, Digest)>,
    pub seconds: f64,
    /// Seconds to have the values again: none where they are kept.
    pub again_s: f64,
}

impl Job {
    pub(super) fn gather_inputs(&self, shared: &Shared, frames: Option<&Range<usize>>) -> Result<Inputs, JobError> {
        let mut inputs = Inputs::default();
        for input in &self.inputs {
            let sliced = frames.filter(|_| input.port.kind.framed && !input.port.still);
            let fetch = |slot: &Slot| match sliced {
                Some(frames) => slot.frames(&shared.store, frames),
                None => slot.whole(&shared.store),
            };
            let value = if input.port.list {
                let items = input.slots.iter().map(|(name, slot)| Ok((name.clone(), fetch(slot)?)));
                PortValue::List(items.collect::<Result<_, Absent>>()?)
            } else {
                PortValue::One(fetch(&input.slots[0].1)?)
            };
            inputs.set(input.port.name, value);
        }
        Ok(inputs)
    }

    pub(super) fn compute(
        &self,
        shared: &Shared,
        inputs: &Inputs,
    ) -> Result<(Outputs, Vec<(String, Digest)>), JobError> {
        if let Some(started) = self.started.lock().unwrap_or_else(PoisonError::into_inner).take() {
            shared.tell(|| started);
        }
        let (name, file) = (self.name.as_str(), self.file.as_deref());
        let (content, stale) = (self.content, self.stale.as_ref());
        let desk = Desk { shared, name, key: &|| self.key, file, content, stale, reads: Mutex::default() };
        let outputs = desk.compute(self.node.as_ref(), &self.item, inputs)?;
        Ok((outputs, desk.reads.into_inner().unwrap_or_else(PoisonError::into_inner)))
    }

    /// Computes the whole cell, and writes what is worth it to the store.
    pub fn whole(&self, shared: &Shared) -> Result<Finished, JobError> {
        let inputs = self.gather_inputs(shared, None)?;
        let _span = tracing::debug_span!("cook", cell = self.name.as_str()).entered();
        let start = Instant::now();
        let (mut outputs, reads) = self.compute(shared, &inputs)?;
        let seconds = start.elapsed().as_secs_f64();
        // What is cheap is not written at all: computing it again takes less than a look into the store.
        let again_s = self.before_s + seconds;
        let cheap = !shared.keep_cheap && seconds < CHEAP_S && again_s < FILE_S;
        let kept = Cell::new(true);
        let write = |record: &ValueRecord| {
            let worth = !cheap && shared.worth_keeping(record, again_s);
            kept.set(kept.get() && worth);
            worth
        };
        let keep = |port: &PortFacts, value: &Arc<dyn Value>| keep(shared, port, value, write);
        let mut sets = Vec::with_capacity(self.card.outputs.len());
        for port in &self.card.outputs {
            let given = outputs.take(port.name).ok_or_else(|| missing_output(port))?;
            sets.push(match given {
                PortValue::One(value) if !port.list => SlotSet::One(keep(port, &value)?),
                PortValue::List(items) if port.list => {
                    let kept = items.into_iter().map(|(name, value)| Ok((name, keep(port, &value)?)));
                    SlotSet::List(kept.collect::<Result<_, JobError>>()?)
                }
                _ => return Err(missing_output(port)),
            });
        }
        if !cheap {
            let named = self.card.outputs.iter().map(|port| port.name.to_owned()).zip(&sets);
            let outputs = named.map(|(name, set)| (name, set.record())).collect();
            shared.writer.action(self.key, Action { outputs, reads: reads.clone(), seconds });
        }
        Ok(Finished { slots: sets.into(), reads, seconds, again_s: if kept.get() { 0.0 } else { again_s } })
    }
}

/// A value as a slot; written to the store where `write` says so of its record.
pub(crate) fn keep(
    shared: &Shared,
    port: &PortFacts,
    value: &Arc<dyn Value>,
    write: impl FnOnce(&ValueRecord) -> bool,
) -> Result<Arc<Slot>, JobError> {
    typed(port, value)?;
    let blocks = cut(value, shared.block_frames);
    let record = record_of(port, &blocks, value.axis(), value.summary());
    let slot = Arc::new(Slot::known(port.kind, record, shared.block_frames, &shared.memory));
    let write = write(slot.record());
    for (index, block) in blocks.iter().enumerate() {
        slot.hold(index, Arc::clone(&block.value));
    }
    if write {
        shared.writer.value(&slot, &pack_of(&blocks));
    }
    Ok(slot)
}

pub(crate) fn typed(port: &PortFacts, value: &Arc<dyn Value>) -> Result<(), JobError> {
    if value.kind() == port.kind {
        return Ok(());
    }
    let problem =
        format!("the node gave {} on its output `{}`, which is {}", value.kind().name, port.name, port.kind.name);
    Err(NodeError::Failed(problem).into())
}

pub(crate) fn missing_output(port: &PortFacts) -> JobError {
    NodeError::Failed(format!("the node gave nothing on its output `{}`", port.name)).into()
}

/// The record of a value that consists of `blocks`.
pub(crate) fn record_of(
    port: &PortFacts,
    blocks: &[CookedBlock],
    axis: Option<wire::FrameAxis>,
    summary: String,
) -> ValueRecord {
    let digests: Vec<Digest> = blocks.iter().map(|block| block.digest).collect();
    ValueRecord {
        digest: ValueRecord::root(&port.kind, &digests),
        axis,
        blocks: digests,
        summary,
        bytes: blocks.iter().map(|block| block.encoding.len() as u64).sum(),
    }
}

pub(crate) fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("the node panicked: {}", text.unwrap_or("without a message"))
}
