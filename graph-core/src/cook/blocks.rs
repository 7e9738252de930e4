//! How a per-frame cell is cut into blocks, and the key of each block.

use super::cell::{CellId, Link, Made, SlotSet};
use super::engine::Engine;
use super::key::{Frames, halo};
use super::slot::Slot;
use std::sync::Arc;
use wire::{Digest, FrameAxis, Hasher};

/// The key of block `block`, of inputs whose blocks have the digests that `digest` gives.
pub(super) fn block_key(
    base: &Digest,
    frames: &Frames,
    block: usize,
    inputs: &[(String, Arc<Slot>)],
    mut digest: impl FnMut(&Slot, usize) -> Digest,
) -> Digest {
    let (own, needed) = (frames.of_block(block), frames.with_halo(block));
    let mut hasher = Hasher::new("block");
    hasher.digest(base).number(own.start as u64).number(own.end as u64);
    hasher.number(needed.start as u64).number(needed.end as u64);
    for (label, slot) in inputs {
        hasher.bytes(label.as_bytes());
        for index in slot.blocks_of(Some(&needed)) {
            hasher.digest(&digest(slot, index));
        }
    }
    hasher.finish()
}

impl Engine {
    /// Computes the keys of a per-frame cell's blocks.
    pub(super) fn block_keys(&mut self, id: CellId, made: &mut Made) {
        let Some(Ok(frames)) = self.frames(id) else { return };
        let cell = &self.cells[id];
        let mut base = Hasher::new("block");
        base.digest(&cell.frame);
        if let Some(digest) = &made.file {
            base.digest(digest);
        }
        for (_, digest) in cell.links.iter().zip(&made.inputs).filter(|(link, _)| !link.framed()) {
            base.digest(digest);
        }
        let base = base.finish();
        let slots: Vec<_> = self.framed_links(id).flat_map(|link| self.slots_of(link)).collect();
        let own = |slot: &Slot, index: usize| slot.record().blocks[index];
        let keys = (0..frames.blocks()).map(|block| block_key(&base, &frames, block, &slots, own));
        made.block_keys = keys.collect();
        self.cells[id].base_key = base;
    }

    pub(super) fn framed_links(&self, id: CellId) -> impl Iterator<Item = &Link> {
        self.cells[id].links.iter().filter(|link| link.framed())
    }

    /// The slots that a link carries, by the names that a gathering port shows.
    pub(super) fn slots_of(&self, link: &Link) -> Vec<(String, Arc<Slot>)> {
        let mut found = Vec::new();
        for wire in &link.wires {
            let set = self.standing(wire);
            match (set, &wire.item) {
                (Some(SlotSet::One(slot)), _) => found.push((wire.label.clone(), Arc::clone(slot))),
                (Some(SlotSet::List(items)), Some(item)) => {
                    found.extend(items.get(item).map(|slot| (wire.label.clone(), Arc::clone(slot))));
                }
                (Some(SlotSet::List(items)), None) => {
                    let items = items.iter().map(|(name, slot)| (wire.label_of(name).into_owned(), Arc::clone(slot)));
                    found.extend(items);
                }
                (None, _) => {}
            }
        }
        found
    }

    /// How a per-frame cell is cut; an error where its inputs hold different frames.
    pub(super) fn frames(&self, id: CellId) -> Option<Result<Frames, String>> {
        let halo = halo(&self.cells[id])?;
        let mut first: Option<(String, FrameAxis)> = None;
        for link in self.framed_links(id) {
            for (label, slot) in self.slots_of(link) {
                let Some(axis) = slot.axis else { continue };
                let name =
                    if label.is_empty() { link.port.name.to_owned() } else { format!("{}@{label}", link.port.name) };
                match &first {
                    None => first = Some((name, axis)),
                    Some((other, known)) => {
                        if let Err(problem) = known.matches(&axis) {
                            return Some(Err(format!("inputs `{other}` and `{name}` do not fit: {problem}")));
                        }
                    }
                }
            }
        }
        let count = first?.1.count;
        Some(Ok(Frames { count, halo, block: self.options.block_frames }))
    }
}
