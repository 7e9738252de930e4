//! How much a store holds.

use crate::store::{Part, Store};
use serde::Serialize;

/// How much a store holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Statistics {
    /// Number of actions.
    pub actions: u64,
    /// Bytes of actions.
    pub action_bytes: u64,
    /// Number of packs.
    pub packs: u64,
    /// Bytes of packs.
    pub pack_bytes: u64,
    /// Number of sessions: graphs that were cooked with this store.
    pub sessions: u64,
    /// Bytes of sessions, and of what they were at rest.
    pub session_bytes: u64,
    /// Number of saved states of cooks that were cut short.
    pub checkpoints: u64,
    /// Bytes of these states.
    pub checkpoint_bytes: u64,
    /// Number of pinned graphs.
    pub pins: u64,
    /// Number of cooks that run now.
    pub cooks: u64,
    /// Number of files that dead processes left behind.
    pub leftovers: u64,
    /// Bytes of these files.
    pub leftover_bytes: u64,
}

impl Statistics {
    /// Bytes of everything that `gc` weighs.
    pub fn bytes(&self) -> u64 {
        self.action_bytes + self.pack_bytes + self.session_bytes + self.checkpoint_bytes
    }
}

/// Counts what `store` holds.
pub fn statistics(store: &Store) -> Statistics {
    let mut counted = Statistics::default();
    for entry in store.inventory().entries {
        let (number, bytes) = match entry.part {
            Part::Action => (&mut counted.actions, &mut counted.action_bytes),
            Part::Pack => (&mut counted.packs, &mut counted.pack_bytes),
            Part::Session => (&mut counted.sessions, &mut counted.session_bytes),
            Part::Checkpoint => (&mut counted.checkpoints, &mut counted.checkpoint_bytes),
            Part::Rest => {
                counted.session_bytes += entry.bytes;
                continue;
            }
            Part::Pin => {
                counted.pins += 1;
                continue;
            }
        };
        *number += 1;
        *bytes += entry.bytes;
    }
    let left = store.sweep(true);
    counted.leftovers = left.len() as u64;
    counted.leftover_bytes = left.iter().map(|(_, bytes)| bytes).sum();
    counted.cooks = store.leases().len() as u64;
    counted
}
