//! What the coordinator and the jobs on the pool share.

use super::cell::CellId;
use super::cost::{SMALL_BYTES, sooner_read};
use super::engine::Tell;
use super::event::Event;
use super::job::{JobError, panic_text};
use super::live::Mail;
use super::memory::Memory;
use super::results::Message;
use super::writer::Writer;
use crate::files::Fingerprints;
use crate::node::NodeError;
use crate::store::{Store, ValueRecord};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Sender;

pub(crate) struct Shared {
    pub store: Arc<Store>,
    pub writer: Writer,
    pub files: Fingerprints,
    pub memory: Arc<Memory>,
    pub cancel: Arc<AtomicBool>,
    pub tell: Option<Arc<Tell>>,
    /// Frames in a block.
    pub block_frames: usize,
    /// Whether results are kept that are computed again in less time than they would be read.
    pub keep_cheap: bool,
    /// Where jobs send what they gave.
    pub sender: Sender<Mail>,
}

impl Shared {
    /// Tells an event, which is only made where someone listens.
    #[inline]
    pub fn tell(&self, event: impl FnOnce() -> Event) {
        if let Some(tell) = &self.tell {
            tell(event());
        }
    }

    /// Whether a value is kept that takes so many seconds to have again. Values without frames always are, since they are
    /// what takes share, and small ones.
    pub fn worth_keeping(&self, record: &ValueRecord, again_s: f64) -> bool {
        let small = record.bytes <= SMALL_BYTES;
        self.keep_cheap || record.axis.is_none() || small || sooner_read(record.bytes, again_s)
    }

    /// Runs `work`; a panic in it fails the cell alone.
    pub fn guarded(&self, cell: CellId, work: impl FnOnce(&Self) -> Message) -> Message {
        catch_unwind(AssertUnwindSafe(|| work(self))).unwrap_or_else(|panic| {
            let problem = panic_text(panic.as_ref());
            Message::Whole { cell, result: Err(JobError::Node(NodeError::Failed(problem))) }
        })
    }
}
