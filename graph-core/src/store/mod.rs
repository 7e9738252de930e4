//! The store: two maps on disk, as in remote build caches. Actions map a key to digests of outputs; packs map a
//! digest to bytes. Every write goes to a temporary file, is synced and renamed; every read is verified.

mod action;
mod disk;
mod pack;

pub use action::{Action, OutputRecord, ValueRecord};
pub use disk::{Statistics, Store, StoreError};
pub use pack::{Pack, PackWriter};
