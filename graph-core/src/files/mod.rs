//! Source files: finding them by pattern, and knowing them by content.

mod fingerprint;
mod pattern;

pub use fingerprint::{Fingerprint, Fingerprints, Signature};
pub use pattern::{Pattern, PatternError};
