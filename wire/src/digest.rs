//! BLAKE3 content digests: the names under which values, files and results are known.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A 256-bit BLAKE3 digest of content.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Digest(pub [u8; 32]);

impl Digest {
    /// The digest of `bytes`.
    pub fn of(bytes: &[u8]) -> Self {
        Self(*blake3::hash(bytes).as_bytes())
    }

    /// 64 lower-case hexadecimal digits.
    pub fn hex(&self) -> String {
        blake3::Hash::from_bytes(self.0).to_hex().to_string()
    }

    /// The first 12 hexadecimal digits, enough for people.
    pub fn short(&self) -> String {
        self.hex()[..12].to_owned()
    }

    /// Reads 64 hexadecimal digits back; `None` where the text is anything else.
    pub fn from_hex(text: &str) -> Option<Self> {
        blake3::Hash::from_hex(text).ok().map(|hash| Self(*hash.as_bytes()))
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.short())
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.hex())
    }
}

/// Bytes that are gathered before the hash proper begins: most keys are shorter, and are hashed in one go.
const GATHERED: usize = 256;

/// Hashes a sequence of length-prefixed parts, so that no two different sequences look alike.
#[derive(Clone)]
pub struct Hasher {
    gathered: [u8; GATHERED],
    count: usize,
    begun: Option<Box<blake3::Hasher>>,
}

impl Hasher {
    /// An empty sequence under a name that keeps different uses of the hash apart.
    #[inline]
    pub fn new(domain: &str) -> Self {
        let mut hasher = Self::bare();
        hasher.bytes(domain.as_bytes());
        hasher
    }

    /// An empty sequence without a name, for parts of fixed length after a digest that says what they are.
    #[inline]
    pub fn bare() -> Self {
        Self { gathered: [0; GATHERED], count: 0, begun: None }
    }

    #[inline]
    fn add(&mut self, bytes: &[u8]) {
        if let Some(begun) = &mut self.begun {
            begun.update(bytes);
        } else if let Some(place) = self.gathered.get_mut(self.count..self.count + bytes.len()) {
            place.copy_from_slice(bytes);
            self.count += bytes.len();
        } else {
            let mut begun = Box::new(blake3::Hasher::new());
            begun.update(&self.gathered[..self.count]).update(bytes);
            self.begun = Some(begun);
        }
    }

    /// Adds one part, preceded by its length.
    #[inline]
    pub fn bytes(&mut self, part: &[u8]) -> &mut Self {
        self.add(&(part.len() as u64).to_le_bytes());
        self.add(part);
        self
    }

    /// Adds a number.
    #[inline]
    pub fn number(&mut self, number: u64) -> &mut Self {
        self.add(&number.to_le_bytes());
        self
    }

    /// Adds a digest (fixed length, so without a prefix).
    #[inline]
    pub fn digest(&mut self, digest: &Digest) -> &mut Self {
        self.add(&digest.0);
        self
    }

    /// The digest of all parts so far.
    #[inline]
    pub fn finish(&self) -> Digest {
        match &self.begun {
            Some(begun) => Digest(*begun.finalize().as_bytes()),
            None => Digest::of(&self.gathered[..self.count]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_do_not_run_together() {
        let split = |a: &str, b: &str| Hasher::new("t").bytes(a.as_bytes()).bytes(b.as_bytes()).finish();
        assert_ne!(split("ab", "c"), split("a", "bc"));
    }

    #[test]
    fn long_sequences_are_hashed_as_short_ones() {
        let parts: Vec<Vec<u8>> = (0..40_u8).map(|length| vec![length; usize::from(length)]).collect();
        for count in 0..parts.len() {
            let mut hasher = Hasher::new("t");
            let mut plain = blake3::Hasher::new();
            plain.update(&1_u64.to_le_bytes()).update(b"t");
            for part in &parts[..count] {
                hasher.bytes(part);
                plain.update(&(part.len() as u64).to_le_bytes()).update(part);
            }
            assert_eq!(hasher.finish().0, *plain.finalize().as_bytes(), "{count} parts");
        }
    }

    #[test]
    fn hex_round_trips() {
        let digest = Digest::of(b"grimace");
        assert_eq!(Digest::from_hex(&digest.hex()), Some(digest));
        assert_eq!(Digest::from_hex("not hex"), None);
    }
}
