//! Joins the blocks of a per-frame cell, those just computed and those kept from the last cook, into its outputs.

use super::cell::{SlotSet, Slots};
use super::job::{Finished, JobError};
use super::key::Frames;
use super::part::note_differences;
use super::shared::Shared;
use super::slot::{CookedBlock, Slot};
use crate::node::{NodeError, PortFacts};
use crate::store::{Action, OutputRecord, PackWriter, Store, ValueRecord};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use wire::{Digest, FrameAxis};

/// Joins blocks into records, and writes them to the store where that is worth it.
pub(crate) struct Join {
    pub ports: Vec<PortFacts>,
    /// The key in the making; `None` where blocks are only remade.
    pub key: Option<Digest>,
    pub done: BTreeMap<usize, Vec<CookedBlock>>,
    pub kept: BTreeMap<usize, usize>,
    pub before: Option<Action>,
    pub seconds: f64,
    /// Seconds to have all of it again, with what is not kept before it; none where too few frames were computed to tell.
    pub again_s: Option<f64>,
    pub frames: Frames,
    /// The cook that this is.
    pub run: u64,
    /// The frames that were computed in each block.
    pub computed: BTreeMap<usize, Range<usize>>,
    /// What stands on the outputs so far: what is remade, or the last cook's, for the values of kept blocks that are in memory.
    pub held: Option<Slots>,
}

impl Join {
    /// The outputs, written to the store where that is worth it.
    pub fn run(self, shared: &Shared) -> Result<Finished, JobError> {
        if let (None, Some(known)) = (&self.key, &self.held) {
            return self.remade(known);
        }
        let mut kept = true;
        let ports = self.ports.iter().enumerate();
        let slots = ports.map(|(index, port)| {
            let (slot, stored) = self.join_port(shared, index, port)?;
            kept &= stored;
            Ok(SlotSet::One(slot))
        });
        let slots: Slots = slots.collect::<Result<_, JobError>>()?;
        if let Some(key) = &self.key {
            let named = self.ports.iter().map(|port| port.name.to_owned()).zip(slots.iter());
            let outputs = named.map(|(name, set)| (name, set.record())).collect();
            shared.writer.action(*key, Action { outputs, reads: Vec::new(), seconds: self.seconds });
        }
        let again_s = if kept { 0.0 } else { self.again_s.unwrap_or(self.seconds) };
        Ok(Finished { slots, reads: Vec::new(), seconds: self.seconds, again_s })
    }

    fn remade(&self, known: &Slots) -> Result<Finished, JobError> {
        for (index, (port, set)) in self.ports.iter().zip(known.iter()).enumerate() {
            let SlotSet::One(slot) = set else { continue };
            for (block, outputs) in &self.done {
                if slot.record().blocks[*block] != outputs[index].digest {
                    let name = port.name;
                    let problem =
                        format!("output `{name}` differs when it is computed again: the node is not a pure function");
                    return Err(NodeError::Failed(problem).into());
                }
                slot.hold(*block, Arc::clone(&outputs[index].value));
            }
        }
        Ok(Finished { slots: Arc::clone(known), reads: Vec::new(), seconds: 0.0, again_s: 0.0 })
    }

    /// An output, and whether the store keeps it.
    fn join_port(&self, shared: &Shared, index: usize, port: &PortFacts) -> Result<(Arc<Slot>, bool), JobError> {
        let (frames, store) = (&self.frames, &shared.store);
        let slot = |record| Slot::known(port.kind, record, frames.block, &shared.memory);
        let before = match self.before.as_ref().and_then(|before| before.outputs.get(port.name)) {
            Some(OutputRecord::One(record)) => Some(slot(record.clone())),
            _ => None,
        };
        let mut digests = Vec::with_capacity(frames.blocks());
        let mut bytes = 0;
        for block in 0..frames.blocks() {
            if let Some(outputs) = self.done.get(&block) {
                digests.push(outputs[index].digest);
                bytes += outputs[index].encoding.len() as u64;
            } else {
                let old = self.kept.get(&block).zip(before.as_ref());
                let digest = old.and_then(|(at, before)| before.record().blocks.get(*at).copied());
                digests.push(digest.ok_or_else(|| NodeError::Failed("a kept block is not in the session".into()))?);
                bytes += before.as_ref().map_or(0, |before| before.bytes / before.record().blocks.len().max(1) as u64);
            }
        }
        let axis = self.axis(index, before.as_ref());
        let record = ValueRecord {
            digest: ValueRecord::root(&port.kind, &digests),
            axis: Some(axis),
            blocks: digests,
            summary: self.summary(index, port, before.as_ref()),
            bytes,
        };
        let held = self.held.as_ref().and_then(|held| held.get(index)).and_then(SlotSet::one);
        let worth = match (self.again_s, held) {
            (None, Some(held)) => held.in_store(store),
            (again_s, _) => shared.worth_keeping(&record, again_s.unwrap_or(f64::INFINITY)),
        };
        let slot = Arc::new(slot(record));
        for (block, outputs) in &self.done {
            slot.hold(*block, Arc::clone(&outputs[index].value));
        }
        if let Some(held) = held {
            for (block, at) in &self.kept {
                held.in_block(*at).into_iter().for_each(|value| slot.hold(*block, value));
            }
            note_differences(self.run, held, &slot, &self.computed);
        }
        let pack = if worth { self.pack(store, index, &slot, before.as_ref()) } else { None };
        if let Some(pack) = &pack {
            shared.writer.value(&slot, pack);
        }
        Ok((slot, pack.is_some()))
    }

    /// All blocks of `slot` as one pack; `None` where a kept block is neither in memory nor in the store any more.
    fn pack(&self, store: &Store, index: usize, slot: &Slot, before: Option<&Slot>) -> Option<PackWriter> {
        let mut pack = PackWriter::default();
        for (block, digest) in slot.record().blocks.iter().enumerate() {
            let encoding = if let Some(outputs) = self.done.get(&block) {
                Arc::clone(&outputs[index].encoding)
            } else if let Some(value) = slot.in_block(block) {
                Arc::new(value.encoded())
            } else {
                Arc::new(before?.encoding(store, *self.kept.get(&block)?).ok()?)
            };
            pack.push(*digest, encoding);
        }
        Some(pack)
    }

    fn axis(&self, index: usize, before: Option<&Slot>) -> FrameAxis {
        let count = self.frames.count;
        let cooked = self.done.iter().next().and_then(|(block, outputs)| Some((*block, outputs[index].value.axis()?)));
        match (cooked, before.and_then(|before| before.axis)) {
            (Some((block, axis)), _) => {
                FrameAxis { first: axis.first - self.frames.of_block(block).start as i64, count, ..axis }
            }
            (None, Some(axis)) => FrameAxis { count, ..axis },
            (None, None) => FrameAxis::new(count, 1.0),
        }
    }

    fn summary(&self, index: usize, port: &PortFacts, before: Option<&Slot>) -> String {
        let blocks: Vec<_> = self.done.values().map(|outputs| Arc::clone(&outputs[index].value)).collect();
        let small = self.done.values().map(|outputs| outputs[index].encoding.len()).sum::<usize>() < 16 << 20;
        if self.kept.is_empty()
            && small
            && let Ok(whole) = (port.kind.join)(&blocks)
        {
            return whole.summary();
        }
        let part = blocks.first().map(|block| block.summary());
        let part = part.or_else(|| before.map(|before| before.record().summary.clone())).unwrap_or_default();
        format!("{} frames; in one block of them: {part}", self.frames.count)
    }
}
