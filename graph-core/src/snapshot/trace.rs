//! What every cell before the chosen outputs was made of and gave: by it, the first that differs is found.

use crate::cook::{CellLook, Engine};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// The cells before the chosen outputs, by name.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Trace(pub BTreeMap<String, TracedCell>);

/// A cell of a trace.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TracedCell {
    /// Its kind.
    pub kind: String,
    /// Its version, parameters and file, each by a short digest.
    pub made_of: BTreeMap<String, String>,
    /// Short digests of what stands on its outputs.
    pub gave: BTreeMap<String, String>,
}

/// The first cell on the way to an output that differs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FirstDifference {
    /// The cell.
    pub node: String,
    /// Its kind.
    pub kind: String,
    /// `file:line:column` of its node.
    pub place: String,
    /// What differs there.
    pub because: String,
    /// Other cells before the output at which differences begin as well.
    pub others: Vec<String>,
}

impl TracedCell {
    fn of(cell: &CellLook<'_>) -> Self {
        Self {
            kind: cell.kind.to_owned(),
            made_of: cell.parts.iter().map(|(label, digest)| (label.clone(), format!("{digest:016x}"))).collect(),
            gave: cell.outputs.iter().map(|(port, record)| ((*port).to_owned(), record.digest().short())).collect(),
        }
    }

    /// What differs, where that is not an input; with how much it says.
    fn difference(&self, now: &Self) -> (u8, String) {
        if self.kind != now.kind {
            return (0, format!("it is of the kind `{}`, and was of the kind `{}`", now.kind, self.kind));
        }
        for (label, digest) in &now.made_of {
            match self.made_of.get(label) {
                Some(known) if known == digest => {}
                Some(_) => return (0, format!("its {label} changed")),
                None => return (0, format!("its {label} is new")),
            }
        }
        match self.made_of.keys().find(|label| !now.made_of.contains_key(*label)) {
            Some(label) => (0, format!("its {label} is gone")),
            None => (
                2,
                "from the same settings and inputs it gives another result: its code differs, or the machine"
                    .to_owned(),
            ),
        }
    }
}

impl Trace {
    /// Everything before the cells `ends`, and these.
    pub fn of(engine: &Engine, ends: &BTreeSet<usize>) -> Self {
        let cells = engine.cells();
        let before = before(&cells, ends);
        let traced = cells.iter().filter(|cell| before.contains(&cell.id));
        Self(traced.map(|cell| (cell.name.to_owned(), TracedCell::of(cell))).collect())
    }

    /// The first cell before `end` (or `end` itself) that gives something else than it did. Of several, one whose settings
    /// differ counts more than one that only gives other numbers.
    pub fn first(&self, engine: &Engine, end: usize) -> Option<FirstDifference> {
        let cells = engine.cells();
        let before = before(&cells, &BTreeSet::from([end]));
        let (mut differing, mut roots) = (BTreeSet::new(), Vec::new());
        for cell in cells.iter().filter(|cell| before.contains(&cell.id)) {
            let now = TracedCell::of(cell);
            let (weight, because) = match self.0.get(cell.name) {
                Some(known) if known.gave == now.gave => continue,
                Some(known) => known.difference(&now),
                None => (1, "it is new".to_owned()),
            };
            let follows = cell.producers.iter().any(|producer| differing.contains(producer));
            differing.insert(cell.id);
            // Other settings make a difference of their own, whatever comes in.
            if !follows || weight == 0 {
                let place = engine.plan().nodes[cell.node].place.text();
                roots.push((weight, cell.name.to_owned(), cell.kind.to_owned(), place, because));
            }
        }
        roots.sort_by_key(|root| root.0);
        let mut roots = roots.into_iter();
        let (_, node, kind, place, because) = roots.next()?;
        Some(FirstDifference { node, kind, place, because, others: roots.map(|root| root.1).collect() })
    }
}

/// The cells before `ends`, and these.
fn before(cells: &[CellLook<'_>], ends: &BTreeSet<usize>) -> BTreeSet<usize> {
    let producers: BTreeMap<usize, &[usize]> = cells.iter().map(|cell| (cell.id, cell.producers)).collect();
    let (mut found, mut open) = (BTreeSet::new(), ends.iter().copied().collect::<Vec<_>>());
    while let Some(id) = open.pop() {
        if found.insert(id) {
            open.extend(producers.get(&id).copied().unwrap_or_default());
        }
    }
    found
}
