//! What sessions name: the results that the last cook of a graph was made of.

use crate::cook::Session;
use crate::store::{Part, Store};
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use wire::Digest;

/// Files of the store that a session names, and when its cook ended.
pub(super) struct Needs {
    pub named: BTreeSet<(Part, Digest)>,
    pub time: SystemTime,
}

impl Needs {
    /// What the session called `name` names; `None` where it cannot be read.
    pub fn of(store: &Store, name: &Digest) -> Option<Self> {
        let session: Session = store.peek_session(name)?;
        let mut named = BTreeSet::from([(Part::Session, *name), (Part::Rest, *name)]);
        for record in session.cells.values() {
            named.insert((Part::Action, record.key));
            named.insert((Part::Checkpoint, record.key));
            let values = record.action.outputs.values().flat_map(crate::store::OutputRecord::values);
            named.extend(values.map(|(_, value)| (Part::Pack, value.digest)));
        }
        // A cook that finds its graph at rest notes so at the session's file.
        let used = std::fs::metadata(store.session_place(name)).and_then(|meta| meta.modified()).unwrap_or(UNIX_EPOCH);
        Some(Self { named, time: used.max(UNIX_EPOCH + Duration::from_secs(session.time_s)) })
    }
}

/// When what sessions name was last needed, and which of it must stay.
#[derive(Default)]
pub(super) struct Needed {
    pub last: BTreeMap<(Part, Digest), SystemTime>,
    pub pinned: BTreeSet<(Part, Digest)>,
    pub running: BTreeSet<(Part, Digest)>,
}

impl Needed {
    /// Takes in what a session names.
    pub fn add(&mut self, needs: Needs, pinned: bool, running: bool) {
        for file in needs.named {
            let last = self.last.entry(file).or_insert(needs.time);
            *last = needs.time.max(*last);
            if pinned {
                self.pinned.insert(file);
            }
            if running {
                self.running.insert(file);
            }
        }
    }
}
