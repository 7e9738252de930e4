//! The store: two maps on disk, as in remote build caches. Actions map a key to digests of outputs; packs map a
//! digest to bytes. Every write goes to a temporary file, is synced and renamed; every read is verified.
//!
//! `disk` is the store itself; `action` and `pack` are what stands in it, `seal` makes records prove themselves, `damage`
//! notes what is found broken. `process` and `lease` say who uses the store, `inventory` lists it for its [care](crate::care).

mod action;
mod damage;
mod disk;
mod error;
mod inventory;
mod lease;
mod pack;
mod process;
mod seal;

pub use action::{Action, OutputRecord, ValueRecord};
pub use damage::Damage;
pub use disk::{Store, USE_GRAIN};
pub use error::StoreError;
pub use inventory::{Entry, Inventory, Part};
pub use lease::{Lease, LeaseRecord};
pub(crate) use pack::is_sound;
pub use pack::{Pack, PackWriter};
pub(crate) use seal::content;
