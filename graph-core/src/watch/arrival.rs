//! The rule of arrival: a file has arrived once its size and times have stood still for the settle time, or when it was renamed
//! into its place. Time is given from outside, so that the rule can be tried without waiting.

use crate::files::Signature;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Files that were renamed into place since the last look.
pub type Renamed = BTreeSet<PathBuf>;

/// What became of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// It is new, or no longer what arrived: it is looked at until it stands still. Told once, when that begins.
    Settling,
    /// It stands still: it may be read. Told again where it has other content, or may have.
    Arrived,
    /// It is no longer there.
    Left,
}

/// What a look brought to light.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct News {
    /// The file.
    pub path: PathBuf,
    /// What became of it.
    pub change: Change,
    /// Its size in bytes; none where it left.
    pub bytes: Option<u64>,
}

#[derive(Debug, Clone, Copy)]
struct Known {
    now: Signature,
    /// When it was first seen as it is now.
    since: Duration,
    /// How it looked when it arrived.
    arrived: Option<Signature>,
}

/// What is known of all files that are watched.
#[derive(Debug, Default)]
pub struct Arrivals {
    known: BTreeMap<PathBuf, Known>,
}

impl Arrivals {
    /// Takes a look at time `now`, counted from any moment: every file that is there, with its signature. `settle` says for
    /// each how long it has to stand still. Gives what changed since the last look, in the order of the paths.
    pub fn take(
        &mut self,
        now: Duration,
        found: &BTreeMap<PathBuf, Signature>,
        renamed: &Renamed,
        settle: impl Fn(&Path) -> Duration,
    ) -> Vec<News> {
        let mut news = Vec::new();
        self.known.retain(|path, _| {
            let stays = found.contains_key(path);
            if !stays {
                news.push(News { path: path.clone(), change: Change::Left, bytes: None });
            }
            stays
        });
        for (path, signature) in found {
            let fresh = Known { now: *signature, since: now, arrived: None };
            let known = self.known.entry(path.clone());
            let is_new = matches!(known, std::collections::btree_map::Entry::Vacant(_));
            let known = known.or_insert(fresh);
            let moved = known.now != *signature;
            let began = is_new || moved && known.arrived == Some(known.now);
            if moved {
                (known.now, known.since) = (*signature, now);
            }
            if known.arrived == Some(*signature) {
                continue;
            }
            let still = now.saturating_sub(known.since) >= settle(path);
            let bytes = Some(signature.size);
            if still || renamed.contains(path) {
                known.arrived = Some(*signature);
                news.push(News { path: path.clone(), change: Change::Arrived, bytes });
            } else if began {
                news.push(News { path: path.clone(), change: Change::Settling, bytes });
            }
        }
        news.sort_by(|one, other| one.path.cmp(&other.path));
        news
    }

    /// The files that have arrived, each as it looked then. One that is being written again is among them as it was: it is let
    /// in no more, since it looks different.
    pub fn arrived(&self) -> BTreeMap<PathBuf, Signature> {
        self.known.iter().filter_map(|(path, known)| Some((path.clone(), known.arrived?))).collect()
    }

    /// The files that are being written, with their sizes in bytes.
    pub fn settling(&self) -> impl Iterator<Item = (&Path, u64)> {
        let moving = self.known.iter().filter(|(_, known)| known.arrived != Some(known.now));
        moving.map(|(path, known)| (path.as_path(), known.now.size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SETTLE: Duration = Duration::from_secs(2);

    fn signature(size: u64, modified_ns: i128) -> Signature {
        Signature { size, modified_ns, changed_ns: modified_ns, inode: 1 }
    }

    fn one(arrivals: &mut Arrivals, at_ms: u64, file: Option<Signature>, renamed: bool) -> Option<Change> {
        let path = PathBuf::from("takes/a.c3d");
        let renamed = renamed.then(|| path.clone()).into_iter().collect();
        let found = file.map(|file| (path, file)).into_iter().collect();
        let news = arrivals.take(Duration::from_millis(at_ms), &found, &renamed, |_| SETTLE);
        assert!(news.len() <= 1);
        news.first().map(|news| news.change)
    }

    #[test]
    fn a_file_arrives_once_it_stood_still() {
        let mut arrivals = Arrivals::default();
        let mut look = |at_ms, size| one(&mut arrivals, at_ms, Some(signature(size, i128::from(size))), false);
        assert_eq!(look(0, 10), Some(Change::Settling));
        assert_eq!(look(1900, 20), None);
        assert_eq!(look(3800, 20), None);
        assert_eq!(look(3900, 20), Some(Change::Arrived));
        assert_eq!(look(9000, 20), None);
        assert_eq!(look(9100, 5), Some(Change::Settling));
        assert_eq!(look(11_100, 5), Some(Change::Arrived));
    }

    #[test]
    fn a_renamed_file_arrives_at_once_and_settles_where_it_is_written_on() {
        let mut arrivals = Arrivals::default();
        assert_eq!(one(&mut arrivals, 0, Some(signature(7, 1)), true), Some(Change::Arrived));
        assert_eq!(one(&mut arrivals, 10, Some(signature(9, 2)), false), Some(Change::Settling));
        assert_eq!(arrivals.settling().count(), 1);
        assert_eq!(arrivals.arrived().len(), 1);
    }

    #[test]
    fn a_same_size_edit_and_a_file_that_comes_again_settle_anew() {
        let mut arrivals = Arrivals::default();
        one(&mut arrivals, 0, Some(signature(7, 1)), true);
        assert_eq!(one(&mut arrivals, 10, Some(signature(7, 2)), false), Some(Change::Settling));
        assert_eq!(one(&mut arrivals, 20, None, false), Some(Change::Left));
        assert_eq!(one(&mut arrivals, 30, Some(signature(7, 1)), false), Some(Change::Settling));
        assert_eq!(one(&mut arrivals, 2030, Some(signature(7, 1)), false), Some(Change::Arrived));
    }

    proptest! {
        #[test]
        fn nothing_arrives_that_moved_within_the_settle_time(
            steps in prop::collection::vec((1_u64..900, prop::option::of(0_u64..3)), 1..60),
        ) {
            let mut arrivals = Arrivals::default();
            let (mut at, mut last, mut moved_at) = (0, None, 0);
            for (wait, size) in steps {
                at += wait;
                if size != last {
                    (last, moved_at) = (size, at);
                }
                let file = size.map(|size| signature(size, i128::from(moved_at)));
                let change = one(&mut arrivals, at, file, false);
                prop_assert!(change != Some(Change::Arrived) || at - moved_at >= 2000);
                let arrived = arrivals.arrived().values().next().copied();
                prop_assert!(size.is_none() || at - moved_at < 2000 || arrived == file);
            }
        }
    }
}
