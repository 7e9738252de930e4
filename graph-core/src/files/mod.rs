//! Source files: finding them by pattern, and knowing them by content.

mod fingerprint;
mod gate;
mod pattern;

pub use fingerprint::{Fingerprint, Fingerprints, Signature};
pub use gate::Gate;
pub use pattern::{Pattern, PatternError};
