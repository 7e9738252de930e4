//! Computing a cheap cell in place: on the coordinating thread, without a task.

use super::cell::{CellId, Link, Made, SlotSet, Slots};
use super::cost::{FILE_S, sooner_read};
use super::engine::Engine;
use super::event::Event;
use super::job::{Desk, Finished, JobError, keep, missing_output, typed};
use super::session::Reason;
use super::slot::{Absent, Slot};
use super::why::told;
use crate::node::{Inputs, NodeError, Outputs, PortFacts, PortValue};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use wire::{Digest, Encoder, Value};

impl Engine {
    /// Computes a cheap whole cell, all of whose inputs are at hand.
    pub(super) fn compute_here(&mut self, id: CellId, made: Made, reason: Reason) {
        self.tell_started(id, &reason);
        let before_s = self.before_s(id);
        match self.result_here(id, &made, before_s) {
            Ok(finished) => {
                self.costs.learn(self.cells[id].plan, finished.seconds);
                self.cooked(id, made, reason, finished, (0, 0));
            }
            // A value was lost between two looks: the task finds it again.
            Err(JobError::Absent(_)) => {
                self.costs.learn(self.cells[id].plan, f64::INFINITY);
                self.begin(id, made, reason);
            }
            Err(error) => self.failed_here(id, made.key, error),
        }
    }

    pub(super) fn tell_started(&self, id: CellId, reason: &Reason) {
        self.tell(|| Event::Started {
            node: self.cells[id].name.clone(),
            kind: self.kind(id),
            because: told(&self.cause(id, reason)),
            blocks: 0,
        });
    }

    /// A cell gave no result here.
    pub(super) fn failed_here(&mut self, id: CellId, key: Digest, error: JobError) {
        match error {
            JobError::Node(NodeError::Cancelled) if self.cancelled() => self.mark(id),
            JobError::Node(_) if self.withdraws(id) => self.mark(id),
            JobError::Node(error) => {
                self.note_failure(id, key, &error.to_string());
                self.fail(id, &error.to_string());
            }
            JobError::Store(error) => {
                self.broken.get_or_insert(error.into());
            }
            // It is looked at again, and then as any other.
            JobError::Absent(_) => {
                self.costs.learn(self.cells[id].plan, f64::INFINITY);
                self.mark(id);
            }
        }
    }

    fn result_here(&mut self, id: CellId, made: &Made, before_s: f64) -> Result<Finished, JobError> {
        let cell = &self.cells[id];
        let mut inputs = Inputs::default();
        for link in &cell.links {
            inputs.set(link.port.name, self.fetch(link)?);
        }
        let desk = Desk {
            shared: &self.shared,
            name: &cell.name,
            key: &|| made.key,
            file: cell.file.as_deref(),
            content: made.file,
            stale: &AtomicBool::new(false),
            reads: Mutex::default(),
        };
        let _span = tracing::debug_span!("cook", cell = cell.name.as_str()).entered();
        let start = Instant::now();
        let outputs = desk.compute(cell.node.as_ref(), cell.item(), &inputs)?;
        let seconds = start.elapsed().as_secs_f64();
        let reads = desk.reads.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.finished_here(id, outputs, reads, seconds, before_s)
    }

    /// What a cell gave as what stands on its outputs.
    pub(super) fn finished_here(
        &mut self,
        id: CellId,
        mut outputs: Outputs,
        reads: Vec<(String, Digest)>,
        seconds: f64,
        before_s: f64,
    ) -> Result<Finished, JobError> {
        let again_s = before_s + seconds;
        let mut kept = true;
        let card = Arc::clone(&self.cells[id].card);
        let mut set = |port: &PortFacts| {
            let given = outputs.take(port.name).ok_or_else(|| missing_output(port))?;
            Ok(match given {
                PortValue::One(value) if !port.list => SlotSet::One(self.slot_here(port, value, again_s, &mut kept)?),
                PortValue::List(items) if port.list => {
                    let slot = |(name, value)| Ok((name, self.slot_here(port, value, again_s, &mut kept)?));
                    SlotSet::List(items.into_iter().map(slot).collect::<Result<_, JobError>>()?)
                }
                _ => return Err(missing_output(port)),
            })
        };
        let slots: Slots = match card.outputs.as_slice() {
            [port] => Arc::new([set(port)?]),
            ports => ports.iter().map(set).collect::<Result<_, JobError>>()?,
        };
        Ok(Finished { slots, reads, seconds, again_s: if kept { 0.0 } else { again_s } })
    }

    fn fetch(&self, link: &Link) -> Result<PortValue, JobError> {
        if let ([wire], false) = (link.wires.as_slice(), link.port.list)
            && let Some(SlotSet::One(slot)) = self.standing(wire)
        {
            return Ok(PortValue::One(slot.whole(&self.shared.store)?));
        }
        let slots = self.slots_of(link);
        let store = &self.shared.store;
        if !link.port.list {
            let (_, slot) = slots.first().ok_or(Absent { damaged: false })?;
            return Ok(PortValue::One(slot.whole(store)?));
        }
        let items = slots.into_iter().map(|(name, slot)| Ok((name, slot.whole(store)?)));
        Ok(PortValue::List(items.collect::<Result<_, Absent>>()?))
    }

    fn slot_here(
        &mut self,
        port: &PortFacts,
        value: Arc<dyn Value>,
        again_s: f64,
        kept: &mut bool,
    ) -> Result<Arc<Slot>, JobError> {
        let (axis, block_frames) = (value.axis(), self.shared.block_frames);
        if axis.is_some_and(|axis| axis.count > block_frames) || again_s > FILE_S {
            return keep(&self.shared, port, &value, |record| {
                let worth = sooner_read(record.bytes, again_s);
                *kept &= worth;
                worth
            });
        }
        typed(port, &value)?;
        // One block that is not written: its encoding is only hashed.
        *kept = false;
        let mut encoder = Encoder::over(std::mem::take(&mut self.scratch));
        value.encode(&mut encoder);
        self.scratch = encoder.finish();
        // A single block is its own root.
        let (digest, bytes) = (port.kind.digest(&self.scratch), self.scratch.len() as u64);
        Ok(Arc::new(Slot::of_one(value, (digest, bytes), block_frames, &self.shared.memory)))
    }
}
