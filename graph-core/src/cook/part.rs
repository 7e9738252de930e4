//! Parts: the frames of a block that an edit touches. Of a value that was computed anew it is known how its blocks differ from those
//! before; a cell that works per frame then computes no more of its own blocks than the frames that see a difference, and takes
//! the others from the blocks that it had. A node that works per frame gives the same bits either way.

use super::blocks::block_key;
use super::cell::{CellId, SlotSet, Slots};
use super::engine::Engine;
use super::key::Frames;
use super::slot::{Slot, block_range};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use wire::{Digest, Value};

/// Of values with more blocks than this that changed, and more than an eighth of all, nothing is told: all of them is new.
const FEW_BLOCKS: usize = 2;

/// How a block differs from the one that stood in its place before.
#[derive(Debug)]
pub(crate) struct Difference {
    /// The digest that the block had.
    before: Digest,
    /// The frames of the value that hold all that differs.
    frames: Range<usize>,
}

/// How the blocks of a value differ from those of the last cook, by their position.
#[derive(Debug)]
pub(crate) struct Differences {
    /// The cook that made the value.
    pub run: u64,
    blocks: BTreeMap<usize, Difference>,
}

/// What of a block is computed.
#[derive(Debug)]
pub(crate) struct Part {
    /// The frames that are computed.
    pub frames: Range<usize>,
    /// The block as it was, by output.
    pub before: Vec<Arc<dyn Value>>,
}

/// Notes on slots that a cell now has how they differ from those that it had, where that is not noted already.
pub(super) fn compare(run: u64, had: &Slots, has: &Slots) {
    for (old, new) in had.iter().zip(has.iter()) {
        if let (SlotSet::One(old), SlotSet::One(new)) = (old, new)
            && new.differences(run).is_none()
        {
            note_differences(run, old, new, &BTreeMap::new());
        }
    }
}

/// Notes on a slot how it differs from the one before; outside of the frames `computed` of a block, by its position, it does not.
pub(super) fn note_differences(run: u64, old: &Slot, new: &Slot, computed: &BTreeMap<usize, Range<usize>>) {
    if let Some(blocks) = differences(old, new, computed) {
        new.differs(Differences { run, blocks });
    }
}

fn differences(
    old: &Slot,
    new: &Slot,
    computed: &BTreeMap<usize, Range<usize>>,
) -> Option<BTreeMap<usize, Difference>> {
    let axis = new.axis.filter(|axis| old.axis == Some(*axis) && old.digest != new.digest)?;
    let (before, now) = (&old.record().blocks, &new.record().blocks);
    let changed: Vec<usize> = (0..now.len()).filter(|block| before.get(*block) != now.get(*block)).collect();
    if before.len() != now.len() || changed.len() > FEW_BLOCKS.max(now.len() / 8) {
        return None;
    }
    let block_frames = new.block_frames;
    let difference = |block: usize| {
        let (old, new) = (old.in_block(block)?, new.in_block(block)?);
        let own = block_range(block, block_frames, axis.count);
        let within = computed.get(&block).unwrap_or(&own);
        let equal = |frame: &usize| {
            let at = frame - own.start;
            let encoded = |value: &Arc<dyn Value>| Some(value.slice(at..at + 1)?.encoded());
            encoded(&old).is_some_and(|before| encoded(&new) == Some(before))
        };
        let first = within.clone().find(|frame| !equal(frame))?;
        let last = (first..within.end).rev().find(|frame| !equal(frame))?;
        Some((block, Difference { before: before[block], frames: first..last + 1 }))
    };
    Some(changed.into_iter().filter_map(difference).collect())
}

impl Engine {
    /// The blocks of a per-frame cell in the making of which only some frames are to be computed.
    pub(super) fn parts(&self, id: CellId) -> BTreeMap<usize, Part> {
        let task = &self.tasks[&id];
        let (Some(frames), Some(last), Some(slots)) = (&task.frames, &task.last, self.cells[id].slots()) else {
            return BTreeMap::new();
        };
        let inputs: Vec<_> = self.framed_links(id).flat_map(|link| self.slots_of(link)).collect();
        let part = |block: usize| {
            let frames = self.seen_anew(id, frames, block, &inputs, last.block_keys.get(block)?)?;
            let before = slots.iter().map(|set| match set {
                SlotSet::One(slot) => slot.in_block(block),
                SlotSet::List(_) => None,
            });
            Some((block, Part { frames, before: before.collect::<Option<_>>()? }))
        };
        task.blocks.iter().filter_map(|block| part(*block)).collect()
    }

    /// The frames of a block that see a difference between what its inputs are and what they were under the key `before`;
    /// `None` where that is not known, or none are left out.
    fn seen_anew(
        &self,
        id: CellId,
        frames: &Frames,
        block: usize,
        inputs: &[(String, Arc<Slot>)],
        before: &Digest,
    ) -> Option<Range<usize>> {
        let (own, needed) = (frames.of_block(block), frames.with_halo(block));
        let (mut first, mut end) = (usize::MAX, 0);
        let key = block_key(&self.cells[id].base_key, frames, block, inputs, |slot, index| {
            let differences = slot.differences(self.session.run);
            let Some(difference) = differences.and_then(|differences| differences.blocks.get(&index)) else {
                return slot.record().blocks[index];
            };
            let seen = difference.frames.start.max(needed.start)..difference.frames.end.min(needed.end);
            if !seen.is_empty() {
                (first, end) = (first.min(seen.start), end.max(seen.end));
            }
            difference.before
        });
        if key != *before {
            return None;
        }
        let part = first.saturating_sub(frames.halo).max(own.start)..(end + frames.halo).min(own.end);
        (!part.is_empty() && part != own).then_some(part)
    }
}
