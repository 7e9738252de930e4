//! Slots: a value as the cook holds it: its record always, its blocks in memory or in the store as it happens.

use super::memory::Memory;
use super::part::Differences;
use crate::store::{Pack, PackWriter, Store, ValueRecord};
use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use wire::{Digest, FrameAxis, Value, ValueKind};

/// One block as it came out of a computation.
#[derive(Debug, Clone)]
pub(crate) struct CookedBlock {
    pub digest: Digest,
    pub value: Arc<dyn Value>,
    pub encoding: Arc<Vec<u8>>,
}

impl CookedBlock {
    pub fn new(value: Arc<dyn Value>) -> Self {
        let encoding = value.encoded();
        Self { digest: value.kind().digest(&encoding), value, encoding: Arc::new(encoding) }
    }
}

/// Cuts a value into blocks of frames; a value without frames is one block.
pub(crate) fn cut(value: &Arc<dyn Value>, block_frames: usize) -> Vec<CookedBlock> {
    match value.axis() {
        Some(axis) if axis.count > block_frames => (0..axis.count.div_ceil(block_frames))
            .map(|block| {
                let frames = block_range(block, block_frames, axis.count);
                let slice = value.slice(frames).unwrap_or_else(|| Arc::clone(value));
                CookedBlock::new(slice)
            })
            .collect(),
        _ => vec![CookedBlock::new(Arc::clone(value))],
    }
}

/// The frames of block `block`.
pub(crate) fn block_range(block: usize, block_frames: usize, count: usize) -> Range<usize> {
    (block * block_frames).min(count)..((block + 1) * block_frames).min(count)
}

/// A block that is neither in memory nor sound in the store: it has to be computed again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Absent {
    /// Whether the store held it damaged.
    pub damaged: bool,
}

const UNKNOWN: u8 = 0;
const STORED: u8 = 1;
const ABSENT: u8 = 2;
/// On its way into the store; until it is there, its pack stays in memory.
const ON_ITS_WAY: u8 = 3;

/// Where a value is held in memory.
type Place = Mutex<Option<Arc<dyn Value>>>;

/// The places of a value's blocks, and of the whole where that is more than one.
#[derive(Debug)]
enum Places {
    One(Place),
    Many { blocks: Vec<Place>, whole: Box<Place> },
}

impl Places {
    fn blocks(&self) -> &[Place] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Many { blocks, .. } => blocks,
        }
    }

    fn whole(&self) -> &Place {
        match self {
            Self::One(one) => one,
            Self::Many { whole, .. } => whole,
        }
    }
}

/// A value of a finished cell.
#[derive(Debug)]
pub(crate) struct Slot {
    pub kind: ValueKind,
    /// Digest of the whole value.
    pub digest: Digest,
    /// Frame axis of a time-varying value.
    pub axis: Option<FrameAxis>,
    /// Bytes of its encoding.
    pub bytes: u64,
    /// The whole record; of a single block that is in memory only once somebody asks for it.
    record: OnceLock<Box<ValueRecord>>,
    /// Frames in a block.
    pub block_frames: usize,
    /// How it differs from what stood in its place before, where that is known.
    differences: OnceLock<Differences>,
    places: Places,
    pack: Mutex<Option<Pack>>,
    stored: AtomicU8,
    memory: Arc<Memory>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Slot {
    /// A value of which only the record is known.
    pub fn known(kind: ValueKind, record: ValueRecord, block_frames: usize, memory: &Arc<Memory>) -> Self {
        let places = if record.blocks.len() == 1 {
            Places::One(Place::default())
        } else {
            let blocks = record.blocks.iter().map(|_| Place::default()).collect();
            Places::Many { blocks, whole: Box::default() }
        };
        let (digest, axis, bytes) = (record.digest, record.axis, record.bytes);
        let (pack, stored, memory) = (Mutex::new(None), AtomicU8::new(UNKNOWN), Arc::clone(memory));
        let record = OnceLock::from(Box::new(record));
        let differences = OnceLock::new();
        Self { kind, digest, axis, bytes, record, block_frames, differences, places, pack, stored, memory }
    }

    /// A value of one block, in memory, whose encoding has this digest and so many bytes.
    pub fn of_one(
        value: Arc<dyn Value>,
        (digest, bytes): (Digest, u64),
        block_frames: usize,
        memory: &Arc<Memory>,
    ) -> Self {
        memory.take(value.size());
        Self {
            kind: value.kind(),
            digest,
            axis: value.axis(),
            bytes,
            record: OnceLock::new(),
            block_frames,
            differences: OnceLock::new(),
            places: Places::One(Mutex::new(Some(value))),
            pack: Mutex::new(None),
            stored: AtomicU8::new(UNKNOWN),
            memory: Arc::clone(memory),
        }
    }

    /// What is known of the value without having it in memory.
    pub fn record(&self) -> &ValueRecord {
        // The value stays in memory until its record is made (`release`).
        self.record.get_or_init(|| {
            let summary = lock(&self.places.blocks()[0]).as_ref().map(|value| value.summary()).unwrap_or_default();
            let (digest, axis, bytes) = (self.digest, self.axis, self.bytes);
            Box::new(ValueRecord { digest, axis, blocks: vec![digest], summary, bytes })
        })
    }

    /// The value, where it is one block and in memory.
    #[inline]
    pub fn in_memory(&self) -> Option<Arc<dyn Value>> {
        match &self.places {
            Places::One(place) => lock(place).clone(),
            Places::Many { .. } => None,
        }
    }

    /// The value of a block, where it is in memory.
    pub fn in_block(&self, block: usize) -> Option<Arc<dyn Value>> {
        self.places.blocks().get(block).and_then(|place| lock(place).clone())
    }

    /// Notes how it differs from what stood in its place before.
    pub fn differs(&self, differences: Differences) {
        let _ = self.differences.set(differences);
    }

    /// How it differs from what stood in its place before the cook `run`, where that cook made it.
    pub fn differences(&self, run: u64) -> Option<&Differences> {
        self.differences.get().filter(|differences| differences.run == run)
    }

    /// Puts a value into memory in place of what was there, or takes it out.
    fn place(&self, place: &Place, value: Option<Arc<dyn Value>>) {
        let bytes = |value: &Option<Arc<dyn Value>>| value.as_ref().map_or(0, |value| value.size());
        self.memory.take(bytes(&value));
        let before = std::mem::replace(&mut *lock(place), value);
        self.memory.give_back(bytes(&before));
    }

    /// Puts a computed block into memory.
    pub fn hold(&self, block: usize, value: Arc<dyn Value>) {
        self.place(&self.places.blocks()[block], Some(value));
    }

    /// Takes the values that an equal slot holds in memory.
    pub fn take_from(&self, other: &Self) {
        for (mine, theirs) in self.places.blocks().iter().zip(other.places.blocks()) {
            let value = lock(theirs).as_ref().map(Arc::clone);
            if value.is_some() {
                self.place(mine, value);
            }
        }
        if other.stored.load(Ordering::SeqCst) == STORED {
            self.now_stored();
        }
    }

    /// Lets go of everything in memory, but for a pack that is on its way into the store.
    pub fn release(&self) {
        self.record();
        self.empty();
    }

    fn empty(&self) {
        for block in self.places.blocks() {
            self.place(block, None);
        }
        self.place(self.places.whole(), None);
        let mut pack = lock(&self.pack);
        if self.stored.load(Ordering::SeqCst) != ON_ITS_WAY {
            *pack = None;
        }
    }

    /// Says that the value is on its way into the store as `pack`, and can be read from that until it is there.
    pub fn will_be_stored(&self, pack: Pack) {
        let mut own = lock(&self.pack);
        *own = Some(pack);
        self.stored.store(ON_ITS_WAY, Ordering::SeqCst);
    }

    /// Says that the store did not take it.
    pub fn will_not_be_stored(&self) {
        self.stored.store(ABSENT, Ordering::SeqCst);
    }

    /// Says that the store now holds the value.
    pub fn now_stored(&self) {
        let mut pack = lock(&self.pack);
        self.stored.store(STORED, Ordering::SeqCst);
        *pack = None;
    }

    /// Whether the store holds the value, or is about to.
    pub fn in_store(&self, store: &Store) -> bool {
        if self.stored.load(Ordering::Relaxed) == UNKNOWN {
            let state = if store.has_pack(&self.digest) { STORED } else { ABSENT };
            self.stored.store(state, Ordering::Relaxed);
        }
        self.is_stored()
    }

    /// Whether the store is known to hold the value, or about to.
    pub fn is_stored(&self) -> bool {
        matches!(self.stored.load(Ordering::SeqCst), STORED | ON_ITS_WAY)
    }

    /// The blocks that hold the given frames, or all of them.
    pub fn blocks_of(&self, frames: Option<&Range<usize>>) -> Range<usize> {
        match (frames, self.places.blocks().len()) {
            (Some(frames), count) if count > 1 => {
                frames.start / self.block_frames..frames.end.div_ceil(self.block_frames).min(count)
            }
            (_, count) => 0..count,
        }
    }

    /// The blocks among `blocks` that would have to be computed again.
    pub fn absent(&self, store: &Store, blocks: Range<usize>) -> Vec<usize> {
        if self.in_store(store) || lock(self.places.whole()).is_some() {
            return Vec::new();
        }
        blocks.filter(|block| lock(&self.places.blocks()[*block]).is_none()).collect()
    }

    /// Whether the value is in memory, or known to be in the store.
    pub fn at_hand(&self) -> bool {
        self.is_stored()
            || lock(self.places.whole()).is_some()
            || self.places.blocks().iter().all(|block| lock(block).is_some())
    }

    /// The encoding of a block from the store, verified.
    pub fn encoding(&self, store: &Store, block: usize) -> Result<Vec<u8>, Absent> {
        let mut pack = lock(&self.pack);
        if pack.is_none() {
            *pack = store.pack(&self.kind, &self.digest).map_err(|_| self.lost(true))?;
        }
        let Some(open) = pack.as_ref() else { return Err(self.lost(false)) };
        if let Some(bytes) = open.block(&self.kind, block) {
            return Ok(bytes.to_vec());
        }
        store.drop_pack(&self.digest);
        *pack = None;
        Err(self.lost(true))
    }

    fn lost(&self, damaged: bool) -> Absent {
        self.stored.store(ABSENT, Ordering::Relaxed);
        Absent { damaged }
    }

    fn block(&self, store: &Store, block: usize) -> Result<Arc<dyn Value>, Absent> {
        if let Some(value) = lock(&self.places.blocks()[block]).as_ref() {
            return Ok(Arc::clone(value));
        }
        let encoding = self.encoding(store, block)?;
        let value = (self.kind.decode)(&encoding).map_err(|_| self.lost(true))?;
        self.hold(block, Arc::clone(&value));
        Ok(value)
    }

    /// The whole value.
    pub fn whole(&self, store: &Store) -> Result<Arc<dyn Value>, Absent> {
        if let Places::One(_) = &self.places {
            return self.block(store, 0);
        }
        if let Some(value) = lock(self.places.whole()).as_ref() {
            return Ok(Arc::clone(value));
        }
        let blocks =
            (0..self.places.blocks().len()).map(|block| self.block(store, block)).collect::<Result<Vec<_>, _>>()?;
        let value = (self.kind.join)(&blocks).map_err(|_| self.lost(true))?;
        self.place(self.places.whole(), Some(Arc::clone(&value)));
        Ok(value)
    }

    /// The frames at positions `frames`.
    pub fn frames(&self, store: &Store, frames: &Range<usize>) -> Result<Arc<dyn Value>, Absent> {
        let whole = lock(self.places.whole()).as_ref().map(Arc::clone);
        let (value, first) = if let Some(whole) = whole {
            (whole, 0)
        } else {
            let range = self.blocks_of(Some(frames));
            let first = range.start * self.block_frames;
            let blocks = range.map(|block| self.block(store, block)).collect::<Result<Vec<_>, _>>()?;
            let value = match blocks.as_slice() {
                [one] => Arc::clone(one),
                many => (self.kind.join)(many).map_err(|_| self.lost(true))?,
            };
            (value, first)
        };
        let within = frames.start - first..frames.end - first;
        if value.axis().is_some_and(|axis| within == (0..axis.count)) {
            return Ok(value);
        }
        value.slice(within).ok_or_else(|| self.lost(true))
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.empty();
    }
}

/// Writes the blocks of a value into one pack.
pub(crate) fn pack_of(blocks: &[CookedBlock]) -> PackWriter {
    let mut writer = PackWriter::default();
    for block in blocks {
        writer.push(block.digest, Arc::clone(&block.encoding));
    }
    writer
}
