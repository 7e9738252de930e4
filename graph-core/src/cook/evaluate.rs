//! Decides for each cell whether its result is known, and if not, why it is cooked.

use super::cell::{CellId, Link, SlotSet, State, Wire, link_digest};
use super::event::Event;
use super::key::{Part, key_of, own_parts};
use super::kitchen::{Counter, Kitchen};
use super::session::{Cause, CellRecord, short};
use super::slot::Slot;
use super::why::{Difference, difference, told};
use crate::store::{Action, OutputRecord};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use wire::{Digest, Hasher};

impl<'a> Kitchen<'a> {
    /// Brings one cell, whose producers are all finished, up to date or on its way.
    pub fn evaluate<'scope>(&mut self, id: CellId, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        if let Some(problem) = self.cells[id].broken.clone() {
            return self.fail(id, &problem);
        }
        let producers = self.producers(id);
        let failed = producers.iter().find_map(|producer| match &self.cells[*producer].state {
            State::Failed(cause) => Some(cause.clone()),
            _ => None,
        });
        if let Some(cause) = failed {
            self.summary.skipped += 1;
            (self.tell)(Event::Skipped { node: self.cells[id].name.clone(), because: cause.clone() });
            return self.finish(id, State::Failed(cause));
        }
        let unknown = producers.iter().find(|producer| matches!(self.cells[**producer].state, State::Unknown));
        if let Some(producer) = unknown {
            let because = format!("{} may give another result", self.cells[*producer].name);
            return match self.own_cause(id, counter) {
                Some(cause) => self.would_cook(id, told(&cause), true),
                None => self.would_cook(id, because, false),
            };
        }
        let parts = match self.parts(id, counter) {
            Ok(parts) => parts,
            Err(problem) => return self.fail(id, &problem),
        };
        self.cells[id].key = key_of("cell", &parts);
        self.block_keys(id, &parts);
        if let Some(action) = self.known(id, counter) {
            return self.cached(id, &parts, action, counter);
        }
        let cause = self.cause(id, difference(self.session.cells.get(&self.cells[id].name), &parts, &[]));
        if self.options.dry {
            return self.would_cook(id, told(&cause), true);
        }
        self.begin(id, parts, cause, counter);
    }

    fn would_cook(&mut self, id: CellId, because: String, sure: bool) {
        let (node, kind) = (self.cells[id].name.clone(), self.kind(id));
        self.summary.cooked += 1;
        (self.tell)(Event::WouldCook { node, kind, because, sure });
        self.finish(id, State::Unknown);
    }

    pub fn kind(&self, id: CellId) -> String {
        self.plan.nodes[self.cells[id].plan].kind.clone()
    }

    /// Everything that the cell's key is made of.
    fn parts(&mut self, id: CellId, counter: &Counter<'_, '_>) -> Result<Vec<Part>, String> {
        let mut parts = self.settings(id, counter)?;
        for link in &self.cells[id].links {
            let digest = link_digest(link, |wire| self.wire_digest(wire));
            let digest = digest.ok_or_else(|| format!("input `{}` has no value", link.port.name))?;
            parts.push(Part { label: input_label(link), digest });
        }
        Ok(parts)
    }

    /// The parts of the key that are the cell's own: version, parameters, file.
    fn settings(&mut self, id: CellId, counter: &Counter<'_, '_>) -> Result<Vec<Part>, String> {
        let cell = &self.cells[id];
        let mut parts = if self.plan.nodes[cell.plan].template.mentions_item {
            own_parts(cell)
        } else {
            self.own_parts.entry(cell.plan).or_insert_with(|| own_parts(cell)).clone()
        };
        if let Some(file) = &cell.file {
            let content = counter.files.digest(file).map_err(|problem| format!("{}: {problem}", file.display()))?;
            let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            let digest = Hasher::new("file").bytes(ending.as_bytes()).digest(&content).finish();
            parts.push(Part { label: "file".into(), digest });
        }
        Ok(parts)
    }

    /// In a plan, why a cell with inputs that are not known is cooked whatever they turn out to be.
    fn own_cause(&mut self, id: CellId, counter: &Counter<'_, '_>) -> Option<Cause> {
        let mut parts = self.settings(id, counter).ok()?;
        let mut unknown = Vec::new();
        for link in &self.cells[id].links {
            match link_digest(link, |wire| self.wire_digest(wire)) {
                Some(digest) => parts.push(Part { label: input_label(link), digest }),
                None => unknown.push(input_label(link)),
            }
        }
        match difference(self.session.cells.get(&self.cells[id].name), &parts, &unknown) {
            Difference::Forgotten => None,
            own => Some(self.cause(id, own)),
        }
    }

    /// The digest of what a wire carries.
    pub fn wire_digest(&self, wire: &Wire) -> Option<Digest> {
        let slots = self.cells[wire.cell].slots()?;
        match (slots.get(&wire.port)?, &wire.item) {
            (SlotSet::One(slot), _) => Some(slot.record.digest),
            (SlotSet::List(items), Some(item)) => Some(items.get(item)?.record.digest),
            (SlotSet::List(items), None) => {
                let mut hasher = Hasher::new("list");
                for (name, slot) in items {
                    hasher.bytes(name.as_bytes()).digest(&slot.record.digest);
                }
                Some(hasher.finish())
            }
        }
    }

    /// The outputs known under the cell's key, from the last cook or from the store.
    fn known(&self, id: CellId, counter: &Counter<'_, '_>) -> Option<Action> {
        let cell = &self.cells[id];
        let before = self.session.cells.get(&cell.name).filter(|before| before.key == cell.key);
        let action = before.map(|before| before.action.clone()).or_else(|| self.store.action(&cell.key))?;
        let complete = cell.card.outputs.iter().all(|port| {
            matches!(
                (action.outputs.get(port.name), port.list),
                (Some(OutputRecord::One(_)), false) | (Some(OutputRecord::List(_)), true)
            )
        });
        let folder = cell.file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let same = |(name, digest): &(String, Digest)| {
            counter.files.digest(&folder.join(name)).is_ok_and(|now| now == *digest)
        };
        (complete && action.reads.iter().all(same)).then_some(action)
    }

    fn cached<'scope>(&mut self, id: CellId, parts: &[Part], action: Action, counter: &mut Counter<'_, 'scope>)
    where
        'a: 'scope,
    {
        let cell = &self.cells[id];
        let mut slots = BTreeMap::new();
        for port in &cell.card.outputs {
            let slot = |record: &crate::store::ValueRecord| {
                Arc::new(Slot::known(port.kind, record.clone(), self.options.block_frames))
            };
            let set = match action.outputs.get(port.name) {
                Some(OutputRecord::One(record)) => SlotSet::One(slot(record)),
                Some(OutputRecord::List(items)) => {
                    SlotSet::List(items.iter().map(|(name, record)| (name.clone(), slot(record))).collect())
                }
                None => continue,
            };
            slots.insert(port.name.to_owned(), set);
        }
        let blocks = cell.block_keys.len();
        let name = cell.name.clone();
        let before = self.session.cells.get(&name);
        let cooked = before.and_then(|before| before.cooked.clone());
        let same = before.filter(|before| before.key == cell.key);
        self.cells[id].frame_keys = same.map(|before| before.frame_keys.clone()).unwrap_or_default();
        self.note(id, parts, action, cooked);
        self.summary.cached += 1;
        self.summary.blocks_cached += blocks;
        (self.tell)(Event::Cached { node: name, kind: self.kind(id), blocks });
        self.finish(id, State::Done(Arc::new(slots)));
        self.publish(id, counter);
    }

    /// Remembers a finished cell.
    pub fn note(&mut self, id: CellId, parts: &[Part], action: Action, cooked: Option<(u64, Cause)>) {
        let cell = &self.cells[id];
        let parts = parts.iter().map(|part| (part.label.clone(), short(&part.digest))).collect();
        let (block_keys, frame_keys) = (cell.block_keys.clone(), cell.frame_keys.clone());
        let record = CellRecord { key: cell.key, parts, action, block_keys, frame_keys, cooked };
        self.records.insert(cell.name.clone(), record);
    }

    /// Marks a cell as failed, and tells so.
    pub fn fail(&mut self, id: CellId, problem: &str) {
        let cell = &self.cells[id];
        let mut inputs = BTreeMap::new();
        for link in &cell.links {
            for wire in &link.wires {
                let label = if wire.label.is_empty() { String::new() } else { format!("@{}", wire.label) };
                let set = self.cells[wire.cell].slots().and_then(|slots| slots.get(&wire.port));
                let summary = set.and_then(|set| set.slots().first().map(|slot| slot.record.summary.clone()));
                inputs.insert(format!("{}{label}", link.port.name), summary.unwrap_or_default());
            }
        }
        let place = self.plan.nodes[cell.plan].place.text();
        let (node, kind, error) = (cell.name.clone(), self.kind(id), problem.to_owned());
        self.summary.failed += 1;
        (self.tell)(Event::Failed { node: node.clone(), kind, error, place, inputs });
        self.finish(id, State::Failed(node));
    }

    /// The difference for which the cell is cooked, in words and with its place.
    fn cause(&self, id: CellId, difference: Difference) -> Cause {
        let cell = &self.cells[id];
        let plan = &self.plan.nodes[cell.plan];
        let here = Some(plan.place.text());
        let plain = |text: String, place: Option<String>| Cause { text, place, upstream: None };
        match difference {
            Difference::New => plain("it is new".into(), here),
            Difference::Forgotten => plain("the store no longer holds its result".into(), None),
            Difference::Added(label) => plain(format!("{label} was added"), here),
            Difference::Removed(label) => plain(format!("{label} was taken away"), here),
            Difference::Changed(label) => {
                if label == "version" {
                    let version = cell.card.version;
                    return plain(format!("its kind `{}` is now version {version}", plan.kind), None);
                }
                if label == "file" {
                    let file = cell.file.as_ref().map(|file| file.display().to_string());
                    return plain("its file changed".into(), file);
                }
                if let Some(port) = label.strip_prefix("input `").and_then(|rest| rest.strip_suffix('`')) {
                    return self.input_cause(id, port);
                }
                let parameter = label.strip_prefix("parameter `").and_then(|rest| rest.strip_suffix('`'));
                let entry = plan.template.entry();
                let span = parameter.and_then(|name| entry.with.get(name)).map(|param| param.value.span);
                let place = span.map(|span| {
                    let source = Arc::clone(&plan.template.graph.source);
                    crate::document::Place { source, span }.text()
                });
                plain(format!("{label} changed"), place.or(here))
            }
        }
    }

    /// Why an input differs: the producer whose result changed, or a changed connection.
    fn input_cause(&self, id: CellId, port: &str) -> Cause {
        let cell = &self.cells[id];
        let link = cell.links.iter().find(|link| link.port.name == port);
        let place = self.plan.nodes[cell.plan].inputs.iter().find(|input| input.port.name == port);
        for wire in link.iter().flat_map(|link| &link.wires) {
            let producer = &self.cells[wire.cell];
            let before =
                self.session.cells.get(&producer.name).and_then(|before| before.action.outputs.get(&wire.port));
            let now = self.records.get(&producer.name).and_then(|now| now.action.outputs.get(&wire.port));
            if before.map(OutputRecord::digest) != now.map(OutputRecord::digest) {
                let text = format!("its input `{port}` changed");
                return Cause { text, place: None, upstream: Some(producer.name.clone()) };
            }
        }
        let text = format!("its input `{port}` is connected to something else, or has other items");
        Cause { text, place: place.map(|input| input.place.text()), upstream: None }
    }
}

/// The label of the part of a key that an input makes.
fn input_label(link: &Link) -> String {
    format!("input `{}`", link.port.name)
}
