//! Actions: what a computation under a key gave.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::{Digest, FrameAxis, Hasher, ValueKind};

/// One value as a cook knows it without having it in memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ValueRecord {
    /// Digest of the whole value: the Merkle root over its blocks.
    pub digest: Digest,
    /// Frame axis of a time-varying value.
    pub axis: Option<FrameAxis>,
    /// Digests of its blocks of frames; a value without frames is one block.
    pub blocks: Vec<Digest>,
    /// One line for people.
    pub summary: String,
    /// Bytes of its encoding.
    pub bytes: u64,
}

impl ValueRecord {
    /// The root over block digests; a single block is its own root.
    pub fn root(kind: &ValueKind, blocks: &[Digest]) -> Digest {
        Self::root_named(kind.name, kind.version, blocks)
    }

    /// The same for a type of which only name and version are known.
    pub(crate) fn root_named(name: &str, version: u32, blocks: &[Digest]) -> Digest {
        if let [one] = blocks {
            return *one;
        }
        let mut hasher = Hasher::new("value");
        hasher.bytes(name.as_bytes()).number(u64::from(version)).number(blocks.len() as u64);
        for block in blocks {
            hasher.digest(block);
        }
        hasher.finish()
    }
}

/// What stands on an output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum OutputRecord {
    /// One value.
    One(ValueRecord),
    /// Items in the order of their names.
    List(BTreeMap<String, ValueRecord>),
}

impl OutputRecord {
    /// The digest of everything on the output.
    pub fn digest(&self) -> Digest {
        match self {
            Self::One(value) => value.digest,
            Self::List(items) => {
                let mut hasher = Hasher::new("list");
                for (name, value) in items {
                    hasher.bytes(name.as_bytes()).digest(&value.digest);
                }
                hasher.finish()
            }
        }
    }

    /// All values on the output, with their item names (empty for a single one).
    pub fn values(&self) -> Vec<(&str, &ValueRecord)> {
        match self {
            Self::One(value) => vec![("", value)],
            Self::List(items) => items.iter().map(|(name, value)| (name.as_str(), value)).collect(),
        }
    }
}

/// The outputs of a computation, and the extra files that it was seen to read.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Action {
    /// What stands on each output.
    pub outputs: BTreeMap<String, OutputRecord>,
    /// Files beside the source file that were read, by relative name, with the digests of their content.
    pub reads: Vec<(String, Digest)>,
    /// Seconds that it took to compute.
    pub seconds: f64,
}
