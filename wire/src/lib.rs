//! What flows on a wire: the [`Value`] trait, content digests, the stable binary encoding and the frame axis.
//!
//! This crate stands below everything else. Data types (`face-math`) implement [`Value`] beside their
//! definition; the engine (`graph-core`) moves values about knowing this trait and nothing more.

mod axis;
mod codec;
mod digest;
mod kind;
mod table;

pub use axis::{AxisError, FrameAxis};
pub use codec::{DecodeError, Decoder, Encoder};
pub use digest::{Digest, Hasher};
pub use kind::{Data, JoinError, Value, ValueKind};
pub use table::{Rows, Table, Tolerance};
