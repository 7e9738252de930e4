//! Seals: records as bytes that prove themselves.

use serde::{Serialize, de::DeserializeOwned};
use wire::Digest;

const DIGEST_BYTES: usize = 32;

/// A record as bytes that prove themselves: the digest of its encoding, then the encoding.
pub(super) fn seal<T: Serialize>(record: &T) -> Vec<u8> {
    let encoding = postcard::to_stdvec(record).expect("records of plain data serialise into memory");
    let mut bytes = Digest::of(&encoding).0.to_vec();
    bytes.extend_from_slice(&encoding);
    bytes
}

/// The encoding in sealed bytes; `None` where it is not what was sealed.
pub(crate) fn content(bytes: &[u8]) -> Option<&[u8]> {
    let (seal, encoding) = bytes.split_at_checked(DIGEST_BYTES)?;
    (Digest::of(encoding).0 == seal).then_some(encoding)
}

/// What sealed bytes hold.
pub(super) enum Unsealed<T> {
    /// The record.
    Sound(T),
    /// Whole, but another record than is asked for: another version of the program wrote it.
    Other,
    /// Not what was sealed.
    Damaged,
}

/// Reads a record back.
pub(super) fn unseal<T: DeserializeOwned>(bytes: &[u8]) -> Unsealed<T> {
    match content(bytes) {
        None => Unsealed::Damaged,
        Some(encoding) => postcard::from_bytes(encoding).map_or(Unsealed::Other, Unsealed::Sound),
    }
}
