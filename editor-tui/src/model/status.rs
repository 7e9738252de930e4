//! What is known of each node: up to date or not and why, cooking, failed; gathered from what cooks tell.

use graph_core::cook::Event;
use std::collections::{BTreeMap, HashMap};

/// How a node, or one item of it, stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Standing {
    /// Nothing is known.
    #[default]
    Unknown,
    /// Up to date.
    Clean,
    /// Something upstream may change it.
    Waiting,
    /// It would be cooked.
    Stale,
    /// It is being cooked.
    Cooking,
    /// It could not be cooked since something before it failed.
    Skipped,
    /// It failed.
    Failed,
}

const STANDINGS: [Standing; 7] = [
    Standing::Unknown,
    Standing::Clean,
    Standing::Waiting,
    Standing::Stale,
    Standing::Cooking,
    Standing::Skipped,
    Standing::Failed,
];

/// What is known of one cell.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CellFacts {
    /// How it stands.
    pub standing: Standing,
    /// Why it is so: what changed, or what failed.
    pub because: String,
    /// Seconds of its last computation.
    pub seconds: Option<f64>,
    /// One line an output.
    pub outputs: BTreeMap<String, String>,
    /// How far it is, 0 to 1.
    pub fraction: f64,
    /// Numbers that it tells, such as a loss, in the order told.
    pub numbers: BTreeMap<String, f64>,
    /// The first of these numbers over time.
    pub history: Vec<f64>,
}

/// How many cells stand how, of a node or a nested graph.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    counts: [u32; 7],
    /// The same by item.
    pub items: BTreeMap<String, [u32; 7]>,
    /// The cell that was heard of last.
    pub last: Option<String>,
}

impl Tally {
    /// Cells that stand so.
    pub fn count(&self, standing: Standing) -> u32 {
        self.counts[standing as usize]
    }

    /// All cells.
    pub fn total(&self) -> u32 {
        self.counts.iter().sum()
    }

    /// The standing that speaks for all.
    pub fn standing(&self) -> Standing {
        speaks(&self.counts)
    }

    /// The standing that speaks for all cells of an item.
    pub fn of_item(&self, item: &str) -> Standing {
        self.items.get(item).map_or(Standing::Unknown, speaks)
    }
}

/// Failures speak before work, work before age.
fn speaks(counts: &[u32; 7]) -> Standing {
    const ORDER: [Standing; 6] =
        [Standing::Cooking, Standing::Failed, Standing::Skipped, Standing::Stale, Standing::Waiting, Standing::Clean];
    ORDER.into_iter().find(|standing| counts[*standing as usize] > 0).unwrap_or_default()
}

/// What is known of all cells.
#[derive(Debug, Clone, Default)]
pub struct Statuses {
    cells: HashMap<String, CellFacts>,
    tallies: HashMap<String, Tally>,
}

impl Statuses {
    /// What is known of the node or nested graph at `path`.
    pub fn tally(&self, path: &str) -> Option<&Tally> {
        self.tallies.get(path)
    }

    /// What is known of a cell.
    pub fn cell(&self, name: &str) -> Option<&CellFacts> {
        self.cells.get(name)
    }

    /// The cell that tells most of the node at `path`: that of `item`, else one that failed or is cooking, else the last heard of.
    pub fn telling(&self, path: &str, item: Option<&str>) -> Option<(&str, &CellFacts)> {
        let tally = self.tally(path)?;
        let named = item.map(|item| format!("{path}@{item}"));
        let found = named.and_then(|name| self.cells.get_key_value(&name));
        let last = || self.cells.get_key_value(tally.last.as_ref()?);
        found.or_else(last).map(|(name, facts)| (name.as_str(), facts))
    }

    /// Forgets how cells stand before all of them are told anew; times and summaries stay.
    pub fn begin(&mut self) {
        self.tallies.clear();
        for facts in self.cells.values_mut() {
            facts.standing = Standing::Unknown;
        }
    }

    /// What a cook that was broken off leaves: nothing is cooking any more.
    pub fn stop(&mut self) {
        let cooking: Vec<String> = self
            .cells
            .iter()
            .filter(|(_, facts)| facts.standing == Standing::Cooking)
            .map(|(name, _)| name.clone())
            .collect();
        for name in cooking {
            self.set(&name, Standing::Stale, |_| {});
        }
    }

    /// Takes in what a cook, or a plan of one, tells.
    pub fn take(&mut self, event: &Event) {
        match event {
            Event::Started { node, because, .. } => self.set(node, Standing::Cooking, |facts| {
                because.clone_into(&mut facts.because);
                (facts.fraction, facts.numbers) = (0.0, BTreeMap::new());
                facts.history.clear();
            }),
            Event::Progress { node, fraction, numbers } => self.set(node, Standing::Cooking, |facts| {
                facts.fraction = *fraction;
                facts.numbers.clone_from(numbers);
                let told = numbers.get("loss").or_else(|| numbers.values().next());
                if let Some(number) = told
                    && facts.history.len() < 4096
                {
                    facts.history.push(*number);
                }
            }),
            Event::Cooked { node, seconds, outputs, .. } => self.set(node, Standing::Clean, |facts| {
                facts.seconds = Some(*seconds);
                facts.outputs.clone_from(outputs);
                facts.because.clear();
            }),
            Event::Cached { node, .. } => self.set(node, Standing::Clean, |facts| facts.because.clear()),
            Event::WouldCook { node, because, sure, .. } => {
                let standing = if *sure { Standing::Stale } else { Standing::Waiting };
                self.set(node, standing, |facts| because.clone_into(&mut facts.because));
            }
            Event::Failed { node, error, .. } => {
                self.set(node, Standing::Failed, |facts| error.clone_into(&mut facts.because));
            }
            Event::Skipped { node, because } => {
                self.set(node, Standing::Skipped, |facts| facts.because = format!("it needs {because}"));
            }
            _ => {}
        }
    }

    fn set(&mut self, name: &str, standing: Standing, note: impl FnOnce(&mut CellFacts)) {
        let known = self.cells.contains_key(name);
        let facts = if known { self.cells.get_mut(name) } else { None };
        let before = if let Some(facts) = facts {
            let before = std::mem::replace(&mut facts.standing, standing);
            note(facts);
            before
        } else {
            let mut facts = CellFacts { standing, ..CellFacts::default() };
            note(&mut facts);
            self.cells.insert(name.to_owned(), facts);
            Standing::Unknown
        };
        let (path, item) = name.split_once('@').map_or((name, None), |(path, item)| (path, Some(item)));
        let mut ends: Vec<usize> = path.match_indices('/').map(|(at, _)| at).collect();
        ends.push(path.len());
        for end in ends {
            let tally = match self.tallies.get_mut(&path[..end]) {
                Some(tally) => tally,
                None => self.tallies.entry(path[..end].to_owned()).or_default(),
            };
            let shift = |counts: &mut [u32; 7]| {
                if before != Standing::Unknown {
                    counts[before as usize] = counts[before as usize].saturating_sub(1);
                }
                counts[standing as usize] += 1;
            };
            shift(&mut tally.counts);
            if let Some(item) = item {
                match tally.items.get_mut(item) {
                    Some(counts) => shift(counts),
                    None => shift(tally.items.entry(item.to_owned()).or_default()),
                }
            }
            if tally.last.as_deref() != Some(name) {
                tally.last = Some(name.to_owned());
            }
        }
    }

    /// All standings of a tally with their counts, those that occur.
    pub fn shares(tally: &Tally) -> impl Iterator<Item = (Standing, u32)> + '_ {
        STANDINGS.into_iter().map(|standing| (standing, tally.count(standing))).filter(|(_, count)| *count > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cached(node: &str) -> Event {
        Event::Cached { node: node.into(), kind: "k".into(), blocks: 0 }
    }

    #[test]
    fn items_and_nested_graphs_are_tallied() {
        let mut statuses = Statuses::default();
        statuses.begin();
        for node in ["solve/raw@a", "solve/raw@b", "solve/fine@a", "rig"] {
            statuses.take(&cached(node));
        }
        let failed = Event::Failed {
            node: "solve/raw@b".into(),
            kind: "k".into(),
            error: "no".into(),
            place: String::new(),
            inputs: BTreeMap::new(),
        };
        statuses.take(&failed);
        let solve = statuses.tally("solve").unwrap();
        assert_eq!((solve.total(), solve.count(Standing::Clean), solve.standing()), (3, 2, Standing::Failed));
        assert_eq!(solve.of_item("a"), Standing::Clean);
        assert_eq!(solve.of_item("b"), Standing::Failed);
        assert_eq!(statuses.telling("solve/raw", Some("b")).unwrap().1.because, "no");
        statuses.begin();
        assert!(statuses.tally("solve").is_none());
    }
}
