//! Stretches: neighbouring blocks of a per-frame cell that one job computes, several of them in one call of the node where they are
//! quick and small. A node that works per frame gives the same bits either way; what it has to do once a call, such as
//! reading the weights of networks, it does less often.

use super::job::{Job, JobError, missing_output, typed};
use super::key::Frames;
use super::part::Part;
use super::shared::Shared;
use super::slot::CookedBlock;
use crate::node::{Inputs, NodeError, Outputs, PortFacts, PortValue};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;
use wire::{Digest, Hasher, Value};

/// Blocks of a stretch at the most.
const BLOCKS: usize = 4;
/// How long a call may take, at a guess from the calls before: so often a job looks whether it is still wanted.
const CALL_S: f64 = 0.1;
/// Bytes that a call may hold, at a guess from the calls before.
const CALL_BYTES: usize = 32 << 20;

/// What the computation of a block gave.
pub(crate) struct BlockResult {
    /// A block for each output; `None` where the block of the last cook is still right.
    pub blocks: Option<Vec<CookedBlock>>,
    pub seconds: f64,
    /// The frames that were computed.
    pub frames: Range<usize>,
    /// The key over exactly the frames seen, for a node with a halo.
    pub frame_key: Option<Digest>,
}

/// What a call of the node gave.
struct Call {
    results: Vec<BlockResult>,
    /// Bytes in memory of what went in and came out.
    bytes: usize,
}

/// Cuts blocks, in rising order, into stretches for so many threads: at least two for each, where there are so many blocks.
/// Blocks whose `parts` touch stay together.
pub(crate) fn stretches(
    blocks: &[usize],
    frames: &Frames,
    threads: usize,
    parts: &BTreeMap<usize, Part>,
) -> Vec<Range<usize>> {
    // With a halo each block has a key of its own over the frames that it sees.
    let most = if frames.halo > 0 { 1 } else { (blocks.len() / (2 * threads)).clamp(1, BLOCKS) };
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for block in blocks {
        let touches = || frames.halo == 0 && touch(parts, *block);
        match stretches.last_mut() {
            Some(last) if last.end == *block && (last.len() < most || touches()) => last.end += 1,
            _ => stretches.push(*block..*block + 1),
        }
    }
    stretches
}

/// Whether the part of a block begins where that of the block before ends.
fn touch(parts: &BTreeMap<usize, Part>, block: usize) -> bool {
    let before = block.checked_sub(1).and_then(|before| parts.get(&before));
    before.zip(parts.get(&block)).is_some_and(|(before, part)| before.frames.end == part.frames.start)
}

impl Job {
    /// Computes the blocks of a stretch, or those before the first trouble. `before` are the keys that the blocks had in the last cook
    /// over exactly the frames that they see; where one is as it was, nothing is computed.
    pub fn stretch(
        &self,
        shared: &Shared,
        frames: &Frames,
        stretch: Range<usize>,
        before: &[Digest],
    ) -> (Vec<BlockResult>, Option<JobError>) {
        let mut results = Vec::with_capacity(stretch.len());
        while results.len() < stretch.len() {
            if shared.cancel.load(Ordering::Relaxed) || self.stale.load(Ordering::Relaxed) {
                return (results, Some(NodeError::Cancelled.into()));
            }
            let (first, start) = (stretch.start + results.len(), Instant::now());
            let end = if self.parts.is_empty() {
                stretch.end.min(first + self.call_blocks.load(Ordering::Relaxed))
            } else {
                (first + 1..stretch.end).find(|block| !touch(&self.parts, *block)).unwrap_or(stretch.end)
            };
            match self.call(shared, frames, first..end, before.get(first)) {
                Ok(call) => {
                    let in_time = CALL_S * call.results.len() as f64 / start.elapsed().as_secs_f64();
                    let in_memory = CALL_BYTES * call.results.len() / call.bytes.max(1);
                    self.call_blocks.store((in_time as usize).min(in_memory).max(1), Ordering::Relaxed);
                    results.extend(call.results);
                }
                Err(error) => return (results, Some(error)),
            }
        }
        (results, None)
    }

    /// Computes blocks in one call. A node with a halo sees frames of the blocks beside its own.
    fn call(
        &self,
        shared: &Shared,
        frames: &Frames,
        blocks: Range<usize>,
        before: Option<&Digest>,
    ) -> Result<Call, JobError> {
        let (first, last) = (blocks.start, blocks.end - 1);
        let own = frames.of_block(first).start..frames.of_block(last).end;
        let seen = frames.with_halo(first).start..frames.with_halo(last).end;
        let whole = || self.gather_inputs(shared, Some(&seen));
        let with_halo = if frames.halo > 0 { Some(whole()?) } else { None };
        let frame_key = with_halo.as_ref().map(|inputs| self.frame_key(&own, &seen, inputs));
        if frame_key.is_some() && frame_key.as_ref() == before {
            return Ok(Call {
                results: vec![BlockResult { blocks: None, seconds: 0.0, frames: 0..0, frame_key }],
                bytes: 0,
            });
        }
        let _span = tracing::debug_span!("cook", cell = self.name.as_str(), first = own.start, end = own.end).entered();
        let start = Instant::now();
        let parts: Option<Vec<&Part>> = blocks.clone().map(|block| self.parts.get(&block)).collect();
        if let Some(parts) = parts
            && let Some(outputs) = self.parts(shared, frames, first, &parts)?
        {
            let seconds = start.elapsed().as_secs_f64() / parts.len() as f64;
            let results = outputs.into_iter().zip(parts).map(|(outputs, part)| BlockResult {
                blocks: Some(outputs),
                seconds,
                frames: part.frames.clone(),
                frame_key,
            });
            return Ok(Call { results: results.collect(), bytes: 0 });
        }
        let inputs = with_halo.map_or_else(whole, Ok)?;
        let start = Instant::now();
        let (mut outputs, _) = self.compute(shared, &inputs)?;
        let seconds = start.elapsed().as_secs_f64() / blocks.len() as f64;
        let mut bytes = self.framed_bytes(&inputs);
        let result =
            |block| BlockResult { blocks: Some(Vec::new()), seconds, frames: frames.of_block(block), frame_key };
        let mut results: Vec<BlockResult> = blocks.clone().map(result).collect();
        for port in &self.card.outputs {
            let value = framed_output(&mut outputs, port, seen.len())?;
            bytes += value.size();
            for (block, result) in blocks.clone().zip(&mut results) {
                let own = frames.of_block(block);
                let value =
                    within(&value, own.start - seen.start..own.end - seen.start).ok_or_else(|| missing_output(port))?;
                result.blocks.get_or_insert_default().push(CookedBlock::new(value));
            }
        }
        Ok(Call { results, bytes })
    }

    /// Computes parts of the blocks from `first` on, which touch; their other frames are those that they had. `None` where the
    /// two do not fit together.
    fn parts(
        &self,
        shared: &Shared,
        frames: &Frames,
        first: usize,
        parts: &[&Part],
    ) -> Result<Option<Vec<Vec<CookedBlock>>>, JobError> {
        let (start, end) = (parts[0].frames.start, parts[parts.len() - 1].frames.end);
        let seen = frames.around(&(start..end));
        let inputs = self.gather_inputs(shared, Some(&seen))?;
        let (mut outputs, _) = self.compute(shared, &inputs)?;
        let mut whole: Vec<Vec<CookedBlock>> = parts.iter().map(|_| Vec::new()).collect();
        for (index, port) in self.card.outputs.iter().enumerate() {
            let value = framed_output(&mut outputs, port, seen.len())?;
            for (block, (part, whole)) in (first..).zip(parts.iter().zip(&mut whole)) {
                let own = frames.of_block(block);
                let fresh = within(&value, part.frames.start - seen.start..part.frames.end - seen.start);
                let had = |frames: Range<usize>| {
                    let within = frames.start - own.start..frames.end - own.start;
                    (!within.is_empty()).then(|| part.before[index].slice(within))
                };
                let pieces = [had(own.start..part.frames.start), Some(fresh), had(part.frames.end..own.end)];
                let pieces: Option<Vec<_>> = pieces.into_iter().flatten().collect();
                match pieces.map(|pieces| (port.kind.join)(&pieces)) {
                    Some(Ok(value)) => whole.push(CookedBlock::new(value)),
                    _ => return Ok(None),
                }
            }
        }
        Ok(Some(whole))
    }

    /// Bytes of what comes in a frame at a time.
    fn framed_bytes(&self, inputs: &Inputs) -> usize {
        let framed = |name: &str| {
            self.inputs.iter().any(|input| input.port.name == name && input.port.kind.framed && !input.port.still)
        };
        let values = inputs.ports().filter(|(name, _)| framed(name)).map(|(_, value)| match value {
            PortValue::One(value) => value.size(),
            PortValue::List(items) => items.values().map(|value| value.size()).sum(),
        });
        values.sum()
    }

    /// The key of a block over exactly the frames that it sees.
    fn frame_key(&self, own: &Range<usize>, seen: &Range<usize>, inputs: &Inputs) -> Digest {
        let mut hasher = Hasher::new("frames");
        hasher.digest(&self.base_key).number(own.start as u64).number(own.end as u64);
        hasher.number(seen.start as u64).number(seen.end as u64);
        for input in self.inputs.iter().filter(|input| input.port.kind.framed && !input.port.still) {
            let values = inputs.ports().filter(|(name, _)| *name == input.port.name);
            for (name, value) in values {
                hasher.bytes(name.as_bytes());
                match value {
                    PortValue::One(value) => drop(hasher.bytes(&value.encoded())),
                    PortValue::List(items) => {
                        for (item, value) in items {
                            hasher.bytes(item.as_bytes()).bytes(&value.encoded());
                        }
                    }
                }
            }
        }
        hasher.finish()
    }
}

/// What a node gave on an output, which has to have so many frames.
fn framed_output(outputs: &mut Outputs, port: &PortFacts, needed: usize) -> Result<Arc<dyn Value>, JobError> {
    let Some(PortValue::One(value)) = outputs.take(port.name) else { return Err(missing_output(port)) };
    typed(port, &value)?;
    let given = value.axis().map_or(0, |axis| axis.count);
    if given != needed {
        let name = port.name;
        let problem = format!("the node gave {given} frames on `{name}` where {needed} are needed");
        return Err(NodeError::Failed(problem).into());
    }
    Ok(value)
}

/// Some frames of a value; the value itself where that is all of them.
fn within(value: &Arc<dyn Value>, frames: Range<usize>) -> Option<Arc<dyn Value>> {
    if value.axis().is_some_and(|axis| frames == (0..axis.count)) {
        return Some(Arc::clone(value));
    }
    value.slice(frames)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_leave_work_for_every_thread() {
        let frames = |halo| Frames { count: 3200, halo, block: 32 };
        let all: Vec<usize> = (0..100).collect();
        let lengths = |stretches: Vec<Range<usize>>| stretches.iter().map(Range::len).max();
        let stretches =
            |blocks: &[usize], frames: &Frames, threads| stretches(blocks, frames, threads, &BTreeMap::new());
        assert_eq!(lengths(stretches(&all, &frames(0), 2)), Some(4));
        assert_eq!(lengths(stretches(&all, &frames(0), 16)), Some(3));
        assert_eq!(lengths(stretches(&all, &frames(0), 64)), Some(1));
        assert_eq!(lengths(stretches(&all, &frames(2), 1)), Some(1));
        assert_eq!(stretches(&[1, 2, 3, 7, 8, 20], &frames(0), 1), [1..4, 7..9, 20..21]);
        assert!(stretches(&[], &frames(0), 1).is_empty());
    }

    #[test]
    fn blocks_whose_parts_touch_stay_together() {
        let part = |frames| Part { frames, before: Vec::new() };
        let parts = BTreeMap::from([(4, part(150..160)), (5, part(160..170)), (6, part(200..210))]);
        let frames = |halo| Frames { count: 3200, halo, block: 32 };
        assert_eq!(stretches(&[4, 5, 6], &frames(0), 2, &parts), [4..6, 6..7]);
        assert_eq!(stretches(&[4, 5, 6], &frames(1), 2, &parts), [4..5, 5..6, 6..7]);
    }
}
