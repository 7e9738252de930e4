//! Decides for each dirty cell whether its result is known, and if not, why it is computed.

use super::cell::{CellId, Inputs, Link, Made, SlotSet, Slots, State, Wire};
use super::engine::Engine;
use super::event::Event;
use super::key::{content_of, key_of};
use super::part::compare;
use super::results::take_over;
use super::session::Reason;
use super::slot::Slot;
use super::why::told;
use crate::store::{Action, OutputRecord, ValueRecord};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use wire::{Digest, Hasher};

impl Engine {
    /// Brings one dirty cell, whose producers are all settled, up to date or on its way.
    pub(super) fn evaluate(&mut self, id: CellId) {
        self.turns[id].dirty = false;
        if self.evaluate_plain(id) {
            return;
        }
        if let Some(problem) = self.cells[id].broken.clone() {
            return self.fail(id, &problem);
        }
        let (mut failed, mut unknown) = (None, None);
        for producer in &self.turns[id].producers {
            match &self.cells[*producer].state {
                State::Failed(cause) => failed = failed.or_else(|| Some(cause.clone())),
                State::Unknown => unknown = unknown.or(Some(*producer)),
                State::Waiting | State::Done(_) => {}
            }
        }
        if let Some(cause) = failed {
            self.summary.skipped += 1;
            self.tell(|| Event::Skipped { node: self.cells[id].name.clone(), because: cause.clone() });
            self.cells[id].state = State::Failed(cause);
            self.learn_items(id);
            return self.settle(id, true);
        }
        let file = match self.file_content(id) {
            Ok(file) => file,
            Err(_) if self.withdraws(id) => return self.mark(id),
            Err(problem) => return self.fail(id, &problem),
        };
        if let Some(producer) = unknown {
            let own = self.own_reason(id, file).map(|reason| told(&self.cause(id, &reason)));
            let sure = own.is_some();
            let because = own.unwrap_or_else(|| format!("{} may give another result", self.cells[producer].name));
            return self.would_cook(id, because, sure);
        }
        let Some(mut made) = self.made(id, file) else {
            return self.fail(id, "an input has no value");
        };
        let cell = &self.cells[id];
        if matches!(cell.state, State::Done(_)) && made.key == cell.key() && self.reads_still_true(id) {
            return self.settle(id, false);
        }
        self.block_keys(id, &mut made);
        // Before the store is asked: it may have the result of a job whose message is still on its way.
        if self.adopts(id, &made) {
            return;
        }
        if let Some(action) = self.known(id, &made) {
            return self.cached(id, made, action);
        }
        if let Some(problem) = self.failures.get(&made.key).cloned() {
            return self.fail(id, &problem);
        }
        let reason = self.reason(id, made.file, &made.inputs);
        if self.options.dry {
            return self.would_cook(id, told(&self.cause(id, &reason)), true);
        }
        self.begin(id, made, reason);
    }

    fn would_cook(&mut self, id: CellId, because: String, sure: bool) {
        let (node, kind) = (self.cells[id].name.clone(), self.kind(id));
        self.summary.cooked += 1;
        self.tell(|| Event::WouldCook { node, kind, because, sure });
        self.cells[id].state = State::Unknown;
        self.learn_items(id);
        self.settle(id, true);
    }

    pub(super) fn kind(&self, id: CellId) -> String {
        self.plan.nodes[self.cells[id].plan].kind.clone()
    }

    /// The content of a cell's source file, as it enters keys.
    pub(super) fn file_content(&mut self, id: CellId) -> Result<Option<Digest>, String> {
        let Some(file) = self.cells[id].file.clone() else { return Ok(None) };
        let content = self.content(&file)?;
        Ok(Some(content_of(&file, &content)))
    }

    /// What the key is made of, settings, file, and the content of every input; `None` where an input has no value.
    fn made(&self, id: CellId, file: Option<Digest>) -> Option<Made> {
        let cell = &self.cells[id];
        let inputs = cell.links.iter().map(|link| self.link_digest(link)).collect::<Option<Inputs>>()?;
        let key = key_of(&cell.frame, file.as_ref(), &inputs);
        let settings = Some(Arc::clone(&cell.settings));
        Some(Made { key, settings, file, inputs, block_keys: Vec::new(), frame_keys: Vec::new() })
    }

    /// What stands on the output that a wire comes from.
    #[inline]
    pub(super) fn standing(&self, wire: &Wire) -> Option<&SlotSet> {
        self.cells[wire.cell].slots()?.get(wire.output)
    }

    /// The digest of what a wire carries.
    #[inline]
    pub(super) fn wire_digest(&self, wire: &Wire) -> Option<Digest> {
        match (self.standing(wire)?, &wire.item) {
            (SlotSet::List(items), Some(item)) => Some(items.get(item)?.digest),
            (set, _) => Some(set.digest()),
        }
    }

    /// The digest of what stands on an input, as it enters keys. A list that comes as one and one that is gathered from items are
    /// the same to the node, and so they are here.
    pub(super) fn link_digest(&self, link: &Link) -> Option<Digest> {
        if let ([wire], false) = (link.wires.as_slice(), link.port.list) {
            return self.wire_digest(wire);
        }
        let mut hasher = Hasher::new("gathered");
        for wire in &link.wires {
            match (self.standing(wire)?, &wire.item) {
                (SlotSet::List(items), None) => {
                    for (name, slot) in items {
                        hasher.bytes(wire.label_of(name).as_bytes()).digest(&slot.digest);
                    }
                }
                _ => {
                    hasher.bytes(wire.label.as_bytes()).digest(&self.wire_digest(wire)?);
                }
            }
        }
        Some(hasher.finish())
    }

    /// Whether the files that a cell was seen to read beside its own are as they were.
    pub(super) fn reads_still_true(&self, id: CellId) -> bool {
        let cell = &self.cells[id];
        self.still_true(cell.file.as_deref(), &cell.reads)
    }

    fn still_true(&self, file: Option<&Path>, reads: &[(String, Digest)]) -> bool {
        let folder = file.and_then(Path::parent).unwrap_or(Path::new(""));
        reads.iter().all(|(name, digest)| self.shared.files.digest(&folder.join(name)).is_ok_and(|now| now == *digest))
    }

    /// The outputs known under the cell's key, from the last cook or from the store.
    fn known(&self, id: CellId, made: &Made) -> Option<Action> {
        let cell = &self.cells[id];
        let before = cell.before.as_ref().filter(|before| before.key == made.key);
        let action = match before {
            Some(before) => before.action.clone(),
            // What is cheap is not in the store, and computed again before the store would have answered.
            None if self.costs.cheap(cell.plan) => return None,
            None => self.shared.store.action(&made.key)?,
        };
        let complete = cell.card.outputs.iter().all(|port| {
            matches!(
                (action.outputs.get(port.name), port.list),
                (Some(OutputRecord::One(_)), false) | (Some(OutputRecord::List(_)), true)
            )
        });
        (complete && self.still_true(cell.file.as_deref(), &action.reads)).then_some(action)
    }

    fn cached(&mut self, id: CellId, mut made: Made, action: Action) {
        let (block_frames, memory) = (self.shared.block_frames, &self.shared.memory);
        let cell = &mut self.cells[id];
        let mut slots: Slots = cell
            .card
            .outputs
            .iter()
            .filter_map(|port| {
                let slot =
                    |record: &ValueRecord| Arc::new(Slot::known(port.kind, record.clone(), block_frames, memory));
                Some(match action.outputs.get(port.name)? {
                    OutputRecord::One(record) => SlotSet::One(slot(record)),
                    OutputRecord::List(items) => {
                        SlotSet::List(items.iter().map(|(name, record)| (name.clone(), slot(record))).collect())
                    }
                })
            })
            .collect();
        if let Some(before) = cell.before.as_ref().filter(|_| matches!(cell.state, State::Waiting)) {
            if before.key == made.key {
                made.frame_keys.clone_from(&before.frame_keys);
            }
            cell.cooked = before.cooked.as_ref().map(|(run, cause)| (*run, Reason::told(cause.clone())));
        }
        let (blocks, name) = (made.block_keys.len(), cell.name.clone());
        (cell.seconds, cell.reads) = (action.seconds, action.reads);
        if let Some(stood) = self.stood.remove(&name) {
            stood.take_over(cell, &made.key, &mut slots);
        }
        if let Some(twin) =
            self.stands.get(&made.key).map(|twin| &self.cells[*twin]).filter(|twin| twin.key() == made.key)
            && let Some(held) = twin.slots()
        {
            take_over(&slots, held);
        }
        self.summary.blocks_cached += blocks;
        self.tell(|| Event::Cached { node: name, kind: self.kind(id), blocks });
        self.done(id, made, slots);
        self.publish(id);
    }

    /// Takes a cell's result.
    pub(super) fn done(&mut self, id: CellId, made: Made, slots: Slots) {
        let cell = &mut self.cells[id];
        let now = slots.iter().map(SlotSet::digest);
        // Against what consumers have seen, and against what the last cook of an earlier process knew.
        let (changed, differs) = match (&cell.state, &cell.before) {
            (State::Done(seen), _) => {
                let changed = !seen.iter().map(SlotSet::digest).eq(now);
                (changed, changed)
            }
            (_, Some(before)) => {
                let known = cell.card.outputs.iter().map(|port| before.action.outputs.get(port.name));
                (true, !known.map(|record| record.map(OutputRecord::digest)).eq(now.map(Some)))
            }
            _ => (true, true),
        };
        if differs {
            cell.changed_run = self.session.run;
        }
        if let (State::Done(seen), true) = (&cell.state, changed) {
            compare(self.session.run, seen, &slots);
        }
        let key = std::mem::replace(&mut cell.made, made).key;
        cell.plainly_made = false;
        cell.state = State::Done(slots);
        if self.stands.get(&key) == Some(&id) {
            self.stands.remove(&key);
        }
        self.stands.insert(self.cells[id].made.key, id);
        self.learn_items(id);
        self.settle(id, changed);
    }

    /// Marks a cell as failed, and tells so.
    pub(super) fn fail(&mut self, id: CellId, problem: &str) {
        let cell = &self.cells[id];
        let mut inputs = BTreeMap::new();
        for link in &cell.links {
            for wire in &link.wires {
                let label = if wire.label.is_empty() { String::new() } else { format!("@{}", wire.label) };
                let set = self.standing(wire);
                let summary = set.and_then(|set| set.slots().first().map(|slot| slot.record().summary.clone()));
                inputs.insert(format!("{}{label}", link.port.name), summary.unwrap_or_default());
            }
        }
        let place = self.plan.nodes[cell.plan].place.text();
        let (node, kind, error) = (cell.name.clone(), self.kind(id), problem.to_owned());
        self.tell(|| Event::Failed { node: node.clone(), kind, error, place, inputs });
        self.summary.failed += 1;
        self.failed.insert(id);
        self.cells[id].state = State::Failed(node);
        self.learn_items(id);
        self.settle(id, true);
    }
}
