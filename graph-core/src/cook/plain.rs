//! Plain cells: whole, of single values, with no files and no lists of which others wait for the items. Where their kind is
//! cheap and all they need is in memory, they are looked at and computed in one go, touching no more than that takes. Their keys
//! are worked out only when somebody asks, since nothing is looked for under them: cheap results are not in the store.

use super::cell::{Cell, CellId, Inputs as Digests, Link, SlotSet, State};
use super::engine::Engine;
use super::job::{Desk, Finished, JobError};
use super::key::{halo, key_of};
use crate::node::{Inputs, PortValue};
use smallvec::SmallVec;
use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Where an input of a plain cell comes from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source {
    cell: u32,
    /// Position of the output on the producer's card.
    output: u16,
    /// Position of the input on the cell's own card.
    input: u16,
}

pub(crate) type Sources = SmallVec<[Source; 2]>;

impl Engine {
    /// Where the inputs of a cell that is about to be made come from, where it is plain.
    pub(super) fn plain(&self, cell: &Cell) -> Option<Sources> {
        let plain = cell.broken.is_none()
            && cell.file.is_none()
            && cell.writes.is_none()
            && halo(cell).is_none()
            && !self.list_origins.contains_key(&cell.plan);
        if !plain {
            return None;
        }
        let source = |link: &Link| {
            let ([wire], false) = (link.wires.as_slice(), link.port.list) else { return None };
            let single = wire.item.is_none() && !self.cells[wire.cell].card.outputs.get(wire.output)?.list;
            let input = cell.card.inputs.iter().position(|port| port.name == link.port.name)?;
            single.then_some(Source { cell: wire.cell as u32, output: wire.output as u16, input: input as u16 })
        };
        cell.links.iter().map(source).collect()
    }

    /// Brings a plain cell up to date, where that can be done here and now. Whether it was; else it is looked at as any other.
    pub(super) fn evaluate_plain(&mut self, id: CellId) -> bool {
        let cell = &self.cells[id];
        let Some(sources) = &cell.plain else { return false };
        let mut inputs = Digests::new();
        for source in sources {
            match &self.cells[source.cell as usize].state {
                State::Done(slots) => inputs.push(slots[usize::from(source.output)].digest()),
                _ => return false,
            }
        }
        let done = matches!(cell.state, State::Done(_));
        if done && cell.plainly_made && cell.made.inputs == inputs {
            self.settle(id, false);
            return true;
        }
        let looked_for = cell.before.is_some() || !self.failures.is_empty() || !self.carries_nothing();
        if looked_for || self.options.dry || !self.prepared || !self.costs.cheap(cell.plan) {
            return false;
        }
        // Undone before it was looked at: it stands as it did.
        if done && !cell.plainly_made && cell.made.key == key_of(&cell.frame, None, &inputs) {
            return false;
        }
        self.touch_next(id);
        self.compute_plain(id, inputs)
    }

    /// Reads a little of what is probably computed soon. Planning leaves nodes far apart, so that most of the time of trivial ones
    /// goes into waiting for memory; this way it is on its way while others are computed.
    fn touch_next(&self, id: CellId) {
        let Some(next) = self.turns[id].consumers.first() else { return };
        black_box(Arc::strong_count(&self.cells[*next].node));
        let Some(after) = self.turns[*next].consumers.first() else { return };
        let cell = &self.cells[*after];
        black_box((Arc::as_ptr(&cell.node).cast::<()>(), cell.seconds, cell.changed_run, cell.made.inputs.len()));
    }

    /// Computes a plain cell of these inputs, where they are in memory. Whether they are.
    fn compute_plain(&mut self, id: CellId, digests: Digests) -> bool {
        let cell = &self.cells[id];
        let (mut inputs, mut before_s) = (Inputs::default(), 0.0_f64);
        for source in cell.plain.iter().flatten() {
            let producer = &self.cells[source.cell as usize];
            let value = match producer.slots().map(|slots| &slots[usize::from(source.output)]) {
                Some(SlotSet::One(slot)) => slot.in_memory(),
                _ => None,
            };
            let Some(value) = value else { return false };
            inputs.add(cell.card.inputs[usize::from(source.input)].name, PortValue::One(value));
            before_s = before_s.max(producer.again_s);
        }
        let reason = self.reason(id, None, &digests);
        self.tell_started(id, &reason);
        match self.result_of_plain(id, &digests, &inputs, before_s) {
            Ok(finished) => {
                self.costs.learn(self.cells[id].plan, finished.seconds);
                self.plainly_cooked(id, digests, reason, finished);
            }
            Err(error) => {
                let key = key_of(&self.cells[id].frame, None, &digests);
                self.failed_here(id, key, error);
            }
        }
        true
    }

    fn result_of_plain(
        &mut self,
        id: CellId,
        digests: &Digests,
        inputs: &Inputs,
        before_s: f64,
    ) -> Result<Finished, JobError> {
        let cell = &self.cells[id];
        let desk = Desk {
            shared: &self.shared,
            name: &cell.name,
            key: &|| key_of(&cell.frame, None, digests),
            file: None,
            content: None,
            stale: &AtomicBool::new(false),
            reads: Mutex::default(),
        };
        let _span = tracing::debug_span!("cook", cell = cell.name.as_str()).entered();
        let start = Instant::now();
        let outputs = desk.compute(cell.node.as_ref(), cell.item(), inputs)?;
        let seconds = start.elapsed().as_secs_f64();
        let reads = desk.reads.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.finished_here(id, outputs, reads, seconds, before_s)
    }
}
