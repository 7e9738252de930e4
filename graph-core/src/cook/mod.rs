//! Cooking: bringing every node up to date.

mod artifact;

pub use artifact::{Artifact, FILES};
