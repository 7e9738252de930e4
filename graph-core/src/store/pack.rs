//! Packs: the encoded blocks of one value in one file, each verified by its digest when it is read.
//!
//! Layout: magic, number of blocks, then per block its digest and length, then the encodings end to end. The name of
//! the file is the value's root digest, which the block digests make up, so a pack proves itself.

use wire::{Digest, ValueKind};

const MAGIC: &[u8; 8] = b"grimpk01";

/// Collects the blocks of one value.
#[derive(Debug, Default)]
pub struct PackWriter {
    blocks: Vec<(Digest, std::sync::Arc<Vec<u8>>)>,
}

impl PackWriter {
    /// Adds the next block.
    pub fn push(&mut self, digest: Digest, encoding: std::sync::Arc<Vec<u8>>) {
        self.blocks.push((digest, encoding));
    }

    /// The bytes of the pack.
    pub fn finish(&self) -> Vec<u8> {
        let content: usize = self.blocks.iter().map(|(_, bytes)| bytes.len()).sum();
        let mut out = Vec::with_capacity(16 + self.blocks.len() * 40 + content);
        out.extend_from_slice(MAGIC);
        out.extend_from_slice(&(self.blocks.len() as u64).to_le_bytes());
        for (digest, bytes) in &self.blocks {
            out.extend_from_slice(&digest.0);
            out.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
        }
        for (_, bytes) in &self.blocks {
            out.extend_from_slice(bytes);
        }
        out
    }
}

/// The bytes of a pack, opened.
#[derive(Debug, Clone)]
pub struct Pack {
    bytes: std::sync::Arc<Vec<u8>>,
    blocks: Vec<(Digest, std::ops::Range<usize>)>,
}

impl Pack {
    /// Opens the bytes of a pack; `None` where they are damaged in their head or length.
    pub fn open(bytes: Vec<u8>) -> Option<Self> {
        let word = |at: usize| -> Option<usize> {
            let word: [u8; 8] = bytes.get(at..at.checked_add(8)?)?.try_into().ok()?;
            usize::try_from(u64::from_le_bytes(word)).ok()
        };
        if bytes.get(..8)? != MAGIC {
            return None;
        }
        let count = word(8)?;
        let mut at = count.checked_mul(40)?.checked_add(16)?;
        if at > bytes.len() {
            return None;
        }
        let mut blocks = Vec::with_capacity(count);
        for index in 0..count {
            let head = 16 + index * 40;
            let digest = Digest(bytes.get(head..head + 32)?.try_into().ok()?);
            let end = at.checked_add(word(head + 32)?)?;
            blocks.push((digest, at..end));
            at = end;
        }
        if at != bytes.len() {
            return None;
        }
        Some(Self { bytes: std::sync::Arc::new(bytes), blocks })
    }

    /// The digests of the blocks.
    pub fn digests(&self) -> Vec<Digest> {
        self.blocks.iter().map(|(digest, _)| *digest).collect()
    }

    /// The encoding of block `index`, verified; `None` where there is no such block or its bytes are damaged.
    pub fn block(&self, kind: &ValueKind, index: usize) -> Option<&[u8]> {
        let (digest, range) = self.blocks.get(index)?;
        let bytes = self.bytes.get(range.clone())?;
        (kind.digest(bytes) == *digest).then_some(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cook::FILES;
    use std::sync::Arc;

    #[test]
    fn every_flipped_or_missing_byte_is_noticed() {
        let kind = FILES.facts().kind;
        let mut writer = PackWriter::default();
        for block in [b"brow".to_vec(), b"chin and jaw".to_vec()] {
            writer.push(kind.digest(&block), Arc::new(block));
        }
        let bytes = writer.finish();
        let digests = Pack::open(bytes.clone()).unwrap().digests();
        let sound = |bytes: Vec<u8>| {
            Pack::open(bytes).is_some_and(|pack| {
                pack.digests() == digests && (0..digests.len()).all(|index| pack.block(&kind, index).is_some())
            })
        };
        assert!(sound(bytes.clone()));
        for at in 0..bytes.len() {
            assert!(!sound(bytes[..at].to_vec()), "cut at {at}");
            let mut flipped = bytes.clone();
            flipped[at] ^= 0x10;
            assert!(!sound(flipped), "flipped at {at}");
        }
    }
}
