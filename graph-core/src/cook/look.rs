//! Looking at what was cooked: cells with what they were made of and what stands on their outputs, and the values themselves.
//! A value that is neither in memory nor in the store is computed again.

use super::cell::{CellId, SlotSet, State, Wire};
use super::engine::Engine;
use super::options::CookError;
use super::session::short;
use super::slot::Slot;
use super::why::told;
use crate::node::Node;
use crate::plan::Plan;
use crate::store::OutputRecord;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use wire::Value;

/// A value with the name under which a gathering port shows it.
pub type NamedValue = (String, Arc<dyn Value>);

/// A cell after a cook.
#[derive(Debug)]
pub struct CellLook<'e> {
    /// Its number, by which other calls know it.
    pub id: usize,
    /// `node` or `node@item`.
    pub name: &'e str,
    /// Its kind.
    pub kind: &'e str,
    /// Its node in the plan.
    pub node: usize,
    /// The node itself, with the parameters that it has for its items.
    pub made: &'e dyn Node,
    /// The file that it reads.
    pub reads: Option<&'e Path>,
    /// The items that it was cooked for, outermost first.
    pub items: &'e [String],
    /// The cells that it is wired to.
    pub producers: &'e [usize],
    /// The cell that keeps it from being cooked, itself where it failed.
    pub failed: Option<&'e str>,
    /// What of its key is its own, each part with a short digest: version, parameters, file.
    pub parts: Vec<(String, u64)>,
    /// What stands on its outputs.
    pub outputs: Vec<(&'static str, OutputRecord)>,
    /// Whether it was computed in this cook, and why it was when it last was.
    pub cooked: Option<(bool, String)>,
    /// Seconds that its computation took, when it last was.
    pub seconds: f64,
    /// The file that it writes.
    pub writes: Option<&'e Path>,
}

/// Why a value cannot be looked at.
#[derive(Debug, thiserror::Error)]
pub enum LookError {
    /// The cell was not cooked, or has no such output.
    #[error("`{cell}` has nothing on its output `{port}`; cook it first")]
    Nothing {
        /// The cell.
        cell: String,
        /// The output.
        port: String,
    },
    /// The value is no longer there and could not be computed again.
    #[error("the value of `{cell}.{port}` is no longer kept and could not be computed again")]
    Lost {
        /// The cell.
        cell: String,
        /// The output.
        port: String,
    },
    /// The cook could not go on.
    #[error(transparent)]
    Cook(#[from] CookError),
}

impl Engine {
    /// The plan that is cooked.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// All cells, each after those it is wired to.
    pub fn cells(&self) -> Vec<CellLook<'_>> {
        let mut order: Vec<CellId> = (0..self.cells.len()).collect();
        order.sort_by_key(|id| (self.cells[*id].plan, &self.cells[*id].items));
        order.into_iter().map(|id| self.cell(id)).collect()
    }

    /// The cell called `name`.
    pub fn look(&self, name: &str) -> Option<CellLook<'_>> {
        self.named(name).map(|id| self.cell(id))
    }

    /// The names of the cells of the node at `path`, in their order.
    pub fn names(&self, path: &str) -> Vec<&str> {
        let of_plan = self.paths.get(path).map_or(&[][..], |at| &self.of_plan[*at]);
        let mut names: Vec<&str> = of_plan.iter().map(|id| self.cells[*id].name.as_str()).collect();
        names.sort_unstable();
        names
    }

    fn named(&self, name: &str) -> Option<CellId> {
        let path = name.split_once('@').map_or(name, |(path, _)| path);
        let of_plan = &self.of_plan[*self.paths.get(path)?];
        of_plan.iter().copied().find(|id| self.cells[*id].name == name)
    }

    fn cell(&self, id: CellId) -> CellLook<'_> {
        let cell = &self.cells[id];
        let settings = cell.made_settings().into_iter().flat_map(|settings| &settings.parts);
        let mut parts: Vec<_> = settings.map(|part| (part.label.clone(), short(&part.digest))).collect();
        parts.extend(cell.made.file.iter().map(|file| ("file".to_owned(), short(file))));
        let failed = match &cell.state {
            State::Failed(by) => Some(by.as_str()),
            _ => None,
        };
        let cooked = cell.cooked.as_ref();
        CellLook {
            id,
            name: &cell.name,
            kind: &self.plan.nodes[cell.plan].kind,
            node: cell.plan,
            made: cell.node.as_ref(),
            reads: cell.file.as_deref(),
            items: &cell.items,
            producers: &self.turns[id].producers,
            failed,
            parts,
            outputs: cell.outputs().map(|(name, set)| (name, set.record())).collect(),
            cooked: cooked.map(|(run, reason)| (*run == self.session.run, told(&self.cause(id, reason)))),
            seconds: cell.seconds,
            writes: cell.writes.as_deref(),
        }
    }

    /// The value that stands on the output `port` of the cell `id`; of a list output, that of `item`.
    ///
    /// # Errors
    /// Where there is none, or it is no longer kept and cannot be computed again.
    pub fn value(&mut self, id: usize, port: &str, item: &str) -> Result<Arc<dyn Value>, LookError> {
        let slot = self.cells.get(id).and_then(|cell| {
            let (_, set) = cell.outputs().find(|(name, _)| *name == port)?;
            match set {
                SlotSet::One(slot) => Some(Arc::clone(slot)),
                SlotSet::List(items) => items.get(item).cloned(),
            }
        });
        let nothing = || LookError::Nothing {
            cell: self.cells.get(id).map_or_else(String::new, |cell| cell.name.clone()),
            port: port.to_owned(),
        };
        let slot = slot.ok_or_else(nothing)?;
        self.whole(id, port, &slot)
    }

    /// What stands on the output `port` of the cell called `name`: values by item for a list, else one under the empty name.
    ///
    /// # Errors
    /// As [`value`](Self::value).
    pub fn values(&mut self, name: &str, port: &str) -> Result<BTreeMap<String, Arc<dyn Value>>, LookError> {
        let id = self.named(name);
        let nothing = || LookError::Nothing { cell: name.to_owned(), port: port.to_owned() };
        let id = id.ok_or_else(nothing)?;
        let set = self.cells[id].outputs().find(|(known, _)| *known == port).map(|(_, set)| set.clone());
        let slots = match set.ok_or_else(nothing)? {
            SlotSet::One(slot) => BTreeMap::from([(String::new(), slot)]),
            SlotSet::List(items) => items,
        };
        slots.into_iter().map(|(item, slot)| Ok((item, self.whole(id, port, &slot)?))).collect()
    }

    /// What stands on the input `port` of the cell `id`, under the names that a gathering port shows; empty where it is open.
    ///
    /// # Errors
    /// As [`value`](Self::value).
    pub fn input(&mut self, id: usize, port: &str) -> Result<Vec<NamedValue>, LookError> {
        let links = self.cells.get(id).into_iter().flat_map(|cell| &cell.links).filter(|link| link.port.name == port);
        let wires: Vec<Wire> = links.flat_map(|link| &link.wires).cloned().collect();
        let mut found = Vec::new();
        for wire in wires {
            let producer = &self.cells[wire.cell];
            let port = producer.card.outputs[wire.output].name;
            let items = match (producer.slots().and_then(|slots| slots.get(wire.output)), &wire.item) {
                (Some(SlotSet::List(_)), Some(item)) => vec![item.clone()],
                (Some(SlotSet::List(items)), None) => items.keys().cloned().collect(),
                _ => vec![String::new()],
            };
            for item in items {
                let label = if item.is_empty() { wire.label.clone() } else { item.clone() };
                found.push((label, self.value(wire.cell, port, &item)?));
            }
        }
        Ok(found)
    }

    /// Has at hand what the cell `id` takes, so that computing it anew waits for nothing else: in memory what it takes as a
    /// whole, and computed again what is kept nowhere.
    ///
    /// # Errors
    /// As [`value`](Self::value).
    pub fn prepare(&mut self, id: usize) -> Result<(), LookError> {
        let links = self.cells.get(id).map(|cell| cell.links.clone()).unwrap_or_default();
        for (link, wire) in links.iter().flat_map(|link| link.wires.iter().map(move |wire| (link, wire))) {
            let producer = &self.cells[wire.cell];
            let port = producer.card.outputs[wire.output].name;
            let set = producer.slots().and_then(|slots| slots.get(wire.output));
            let slots: Vec<Arc<Slot>> = set.iter().flat_map(|set| set.slots()).map(Arc::clone).collect();
            for slot in slots {
                if link.framed() {
                    self.make_again(wire.cell, &slot)?;
                    // The first block opens what the store holds of all of them.
                    drop(slot.frames(&self.shared.store, &(0..1)));
                } else {
                    self.whole(wire.cell, port, &slot)?;
                }
            }
        }
        Ok(())
    }

    /// Computes again what of a slot is neither in memory nor in the store.
    fn make_again(&mut self, id: CellId, slot: &Arc<Slot>) -> Result<(), LookError> {
        let missing = slot.absent(&self.shared.store, slot.blocks_of(None));
        if !missing.is_empty() && !self.options.dry && !self.tasks.contains_key(&id) {
            self.remake(id, missing.into_iter().collect());
            self.run();
            if let Some(problem) = self.broken.take() {
                return Err(problem.into());
            }
        }
        Ok(())
    }

    fn whole(&mut self, id: CellId, port: &str, slot: &Arc<Slot>) -> Result<Arc<dyn Value>, LookError> {
        let mut slot = Arc::clone(slot);
        // Once from where it is, once more where it was found damaged and was computed again.
        for _ in 0..2 {
            self.make_again(id, &slot)?;
            if let Ok(value) = slot.whole(&self.shared.store) {
                return Ok(value);
            }
            // What gives another result when it is computed again has a new place for it.
            let sets = self.cells[id].outputs().filter(|(name, _)| *name == port).flat_map(|(_, set)| set.slots());
            let same = sets.into_iter().find(|known| known.digest == slot.digest);
            slot = same.map_or(slot, Arc::clone);
        }
        Err(LookError::Lost { cell: self.cells[id].name.clone(), port: port.to_owned() })
    }
}
