//! Artifacts: files that nodes make. Nodes give bytes; the engine alone writes them to disk.

use crate::node::Port;
use wire::{Data, DecodeError, Decoder, Encoder, Value, ValueKind};

/// The port on which every writing node gives its file (see [`Card::writes`](crate::node::Card::writes)).
pub const FILES: Port<Artifact> = Port::new("file", "the written file");

/// A file's content, as a node made it. The engine publishes it at the path that the node's `writes` parameter names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Artifact {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
}

impl Value for Artifact {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.blob(&self.bytes);
    }

    fn summary(&self) -> String {
        format!("a file of {} bytes", self.bytes.len())
    }

    fn size(&self) -> usize {
        self.bytes.len()
    }
}

impl Data for Artifact {
    const NAME: &'static str = "File";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(Self { bytes: input.blob()?.to_vec() })
    }
}
