//! Packs: the encoded blocks of one value in one file, each verified by its digest when it is read.
//!
//! Layout: magic; length of the type's name, its version, number of blocks (8 bytes each); the name; per block its digest
//! and length; the encodings end to end. The name of the file is the value's root digest, which the type and the block
//! digests make up, so a pack proves itself, without anything being known of its type.

use super::ValueRecord;
use std::io::{self, Read};
use wire::{Digest, ValueKind};

const MAGIC: &[u8; 8] = b"grimpk02";
/// Bytes before the name of the type.
const FIXED_BYTES: usize = 32;
/// Bytes that say a block's digest and length.
const HEAD_BYTES: usize = 40;
/// No type has a longer name.
const LONGEST_NAME: usize = 1 << 12;

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

    /// The pack of a value of `kind`.
    pub fn finish(&self, kind: &ValueKind) -> Pack {
        let bytes = self.bytes(kind);
        let content: usize = self.blocks.iter().map(|(_, encoding)| encoding.len()).sum();
        let mut at = bytes.len() - content;
        let mut blocks = Vec::with_capacity(self.blocks.len());
        for (digest, encoding) in &self.blocks {
            blocks.push((*digest, at..at + encoding.len()));
            at += encoding.len();
        }
        Pack { of: (kind.name.to_owned(), kind.version), bytes: std::sync::Arc::new(bytes), blocks }
    }

    fn bytes(&self, kind: &ValueKind) -> Vec<u8> {
        let content: usize = self.blocks.iter().map(|(_, bytes)| bytes.len()).sum();
        let mut out = Vec::with_capacity(FIXED_BYTES + kind.name.len() + self.blocks.len() * HEAD_BYTES + content);
        out.extend_from_slice(MAGIC);
        for number in [kind.name.len() as u64, u64::from(kind.version), self.blocks.len() as u64] {
            out.extend_from_slice(&number.to_le_bytes());
        }
        out.extend_from_slice(kind.name.as_bytes());
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

/// What stands before the encodings.
struct Head {
    name: String,
    version: u32,
    /// Digest and length of each block.
    blocks: Vec<(Digest, u64)>,
    /// Its own length in bytes.
    bytes: u64,
}

impl Head {
    /// Reads the head of a pack of `length` bytes; `None` where it is damaged.
    fn read(input: &mut impl Read, length: u64) -> io::Result<Option<Self>> {
        let mut fixed = [0; FIXED_BYTES];
        if length < FIXED_BYTES as u64 {
            return Ok(None);
        }
        input.read_exact(&mut fixed)?;
        let word = |bytes: &[u8]| {
            let mut word = [0; 8];
            word.copy_from_slice(bytes);
            u64::from_le_bytes(word)
        };
        let (name, version, count) = (word(&fixed[8..16]), word(&fixed[16..24]), word(&fixed[24..32]));
        let heads = count.checked_mul(HEAD_BYTES as u64);
        let bytes = heads.and_then(|heads| heads.checked_add(name)?.checked_add(FIXED_BYTES as u64));
        let (Some(bytes), Ok(version)) = (bytes.filter(|bytes| *bytes <= length), u32::try_from(version)) else {
            return Ok(None);
        };
        if &fixed[..8] != MAGIC || name > LONGEST_NAME as u64 {
            return Ok(None);
        }
        let mut text = vec![0; name as usize];
        input.read_exact(&mut text)?;
        let Ok(name) = String::from_utf8(text) else { return Ok(None) };
        let mut blocks = Vec::with_capacity(count as usize);
        let mut end = Some(bytes);
        for _ in 0..count {
            let mut head = [0; HEAD_BYTES];
            input.read_exact(&mut head)?;
            let (digest, bytes) = head.split_at(32);
            let mut own = Digest::default();
            own.0.copy_from_slice(digest);
            end = end.and_then(|end| end.checked_add(word(bytes)));
            blocks.push((own, word(bytes)));
        }
        Ok((end == Some(length)).then_some(Self { name, version, blocks, bytes }))
    }
}

/// Reads a whole pack of `length` bytes from `input`, and says whether it is the pack of the value `root`, undamaged.
/// Takes the memory of its largest block.
///
/// # Errors
/// Where it cannot be read.
pub(crate) fn is_sound(mut input: impl Read, length: u64, root: &Digest) -> io::Result<bool> {
    let Some(head) = Head::read(&mut input, length)? else { return Ok(false) };
    let digests: Vec<Digest> = head.blocks.iter().map(|(digest, _)| *digest).collect();
    if ValueRecord::root_named(&head.name, head.version, &digests) != *root {
        return Ok(false);
    }
    let mut encoding = Vec::new();
    for (digest, bytes) in head.blocks {
        encoding.resize(bytes as usize, 0);
        input.read_exact(&mut encoding)?;
        if ValueKind::digest_named(&head.name, head.version, &encoding) != digest {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The bytes of a pack, opened.
#[derive(Debug, Clone)]
pub struct Pack {
    /// Name and version of the value's type.
    of: (String, u32),
    bytes: std::sync::Arc<Vec<u8>>,
    blocks: Vec<(Digest, std::ops::Range<usize>)>,
}

impl Pack {
    /// Opens the bytes of a pack; `None` where they are damaged in their head or length.
    pub fn open(bytes: Vec<u8>) -> Option<Self> {
        let head = Head::read(&mut bytes.as_slice(), bytes.len() as u64).ok()??;
        let mut at = usize::try_from(head.bytes).ok()?;
        let mut blocks = Vec::with_capacity(head.blocks.len());
        for (digest, length) in head.blocks {
            let end = at + usize::try_from(length).ok()?;
            blocks.push((digest, at..end));
            at = end;
        }
        Some(Self { of: (head.name, head.version), bytes: std::sync::Arc::new(bytes), blocks })
    }

    /// Whether it is the pack of the value `root` of `kind`, as far as its head says.
    pub fn is_of(&self, kind: &ValueKind, root: &Digest) -> bool {
        self.of == (kind.name.to_owned(), kind.version) && ValueRecord::root(kind, &self.digests()) == *root
    }

    /// What stands in its file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
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
        let finished = writer.finish(&kind);
        let bytes = finished.bytes().to_vec();
        let opened = Pack::open(bytes.clone()).unwrap();
        assert_eq!((&opened.of, &opened.blocks), (&finished.of, &finished.blocks));
        let digests = opened.digests();
        let root = ValueRecord::root(&kind, &digests);
        let sound = |bytes: Vec<u8>| {
            let opened = Pack::open(bytes.clone()).is_some_and(|pack| {
                pack.is_of(&kind, &root) && (0..digests.len()).all(|index| pack.block(&kind, index).is_some())
            });
            let streamed = is_sound(bytes.as_slice(), bytes.len() as u64, &root).unwrap_or(false);
            assert_eq!(opened, streamed);
            opened
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
