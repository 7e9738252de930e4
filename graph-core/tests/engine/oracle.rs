//! What a cook of a random model must do, found out by evaluating it naively: every cell from the content of its inputs, and
//! a cell is computed when its inputs, parameters, kind, version and file were never seen together before.

use crate::model::{Model, Work};
use std::collections::{BTreeMap, BTreeSet};

/// What stands on the output of a cell.
#[derive(Debug, Clone, PartialEq)]
enum Content {
    Series(Vec<f64>),
    Number(f64),
    List(BTreeMap<String, Vec<f64>>),
    File,
}

/// What the frames of a per-frame cell are computed from.
#[derive(Debug, Clone, PartialEq)]
pub struct Framed {
    /// All that every block depends on.
    base: String,
    series: Vec<(String, Vec<f64>)>,
    halo: usize,
}

/// A cell as it must be.
#[derive(Debug, Clone)]
pub struct Cell {
    /// All that its result depends on; none where something it needs fails.
    pub key: Option<String>,
    /// Whether it can be computed from that.
    pub sound: bool,
    pub framed: Option<Framed>,
}

/// Everything that cooks of a model should know by now.
#[derive(Debug, Default)]
pub struct Oracle {
    seen: BTreeSet<String>,
    /// What each cell was last known as.
    last: BTreeMap<String, (String, Option<Framed>)>,
    /// Cells whose blocks are known by the exact frames that they see.
    exact: BTreeSet<String>,
}

/// What a cook must compute.
#[derive(Debug, Default)]
pub struct Expected {
    /// All cells that can be computed.
    pub sound: BTreeSet<String>,
    /// Cells whose key was never seen, by key: of each at least one is computed.
    pub fresh: BTreeMap<String, BTreeSet<String>>,
    /// Cells whose key differs from the one they had in the last cook.
    pub changed: BTreeSet<String>,
    pub failed: usize,
    /// Of the cells that may be computed, the fewest and the most blocks.
    pub blocks: BTreeMap<String, (usize, usize)>,
}

impl Oracle {
    /// What the next cook must do; `block` is the number of frames in a block.
    pub fn expect(&self, model: &Model, block: usize) -> (Expected, BTreeMap<String, Cell>) {
        let cells = evaluate(model);
        let mut expected = Expected::default();
        for (name, cell) in &cells {
            let Some(key) = &cell.key else { continue };
            if !cell.sound {
                expected.failed += 1;
                continue;
            }
            expected.sound.insert(name.clone());
            if !self.seen.contains(key) {
                expected.fresh.entry(key.clone()).or_default().insert(name.clone());
            }
            let last = self.last.get(name);
            if last.is_none_or(|(before, _)| before != key) {
                expected.changed.insert(name.clone());
            }
            let blocks = cell.framed.as_ref().map_or((0, 0), |now| {
                let before = last.and_then(|(_, framed)| framed.as_ref());
                let (exact, whole) = (now.differing(before, block, true), now.differing(before, block, false));
                // A cell that failed in between may still know blocks from before.
                let failed = last.is_some_and(|(key, _)| key.is_empty());
                let halo_known = now.halo == 0 || self.exact.contains(name);
                (if failed { 0 } else { exact }, if halo_known { exact } else { whole })
            });
            expected.blocks.insert(name.clone(), blocks);
        }
        (expected, cells)
    }

    /// Takes in what a cook did.
    pub fn learn(&mut self, cells: BTreeMap<String, Cell>, cooked: &BTreeSet<String>) {
        self.exact.retain(|name| cells.contains_key(name));
        let mut last = BTreeMap::new();
        for (name, cell) in cells {
            let Some(key) = cell.key.filter(|_| cell.sound) else {
                // What is still known of a cell that failed is the engine's business.
                self.exact.remove(&name);
                last.extend(self.last.remove_entry(&name).map(|(name, _)| (name, (String::new(), None))));
                continue;
            };
            let same = self.last.get(&name).is_some_and(|(before, _)| *before == key);
            if cooked.contains(&name) {
                let all = cell.framed.is_some() && !self.last.contains_key(&name);
                if all {
                    self.exact.insert(name.clone());
                }
            } else if !same {
                self.exact.remove(&name);
            }
            self.seen.insert(key.clone());
            last.insert(name, (key, cell.framed));
        }
        self.last = last;
    }
}

impl Framed {
    fn count(&self) -> usize {
        self.series[0].1.len()
    }

    /// The number of blocks that differ from those before: in the frames that they see, or in the blocks that hold these.
    fn differing(&self, before: Option<&Self>, block: usize, exact: bool) -> usize {
        let sees = |framed: &Self, at: usize| {
            let (count, own) = (framed.count(), at * block..((at + 1) * block).min(framed.count()));
            let needed = own.start.saturating_sub(framed.halo)..(own.end + framed.halo).min(count);
            let read = if exact {
                needed.clone()
            } else {
                needed.start / block * block..(needed.end.div_ceil(block) * block).min(count)
            };
            let frames: Vec<_> =
                framed.series.iter().map(|(name, series)| (name.clone(), series[read.clone()].to_vec())).collect();
            (own, needed, frames)
        };
        let before = before.filter(|before| before.base == self.base);
        let blocks = |framed: &Self| framed.count().div_ceil(block);
        (0..blocks(self))
            .filter(|at| before.is_none_or(|before| *at >= blocks(before) || sees(before, *at) != sees(self, *at)))
            .count()
    }
}

type Items = Vec<String>;

/// Every cell of the model by its name.
fn evaluate(model: &Model) -> BTreeMap<String, Cell> {
    let mut cells = BTreeMap::new();
    let mut contents: BTreeMap<usize, BTreeMap<Items, Option<Content>>> = BTreeMap::new();
    for id in model.nodes.keys() {
        let mut of_node = BTreeMap::new();
        for items in combinations(model, &contents, *id) {
            let (cell, content) = cell(model, &contents, *id, &items);
            let name =
                if items.is_empty() { model.path(*id) } else { format!("{}@{}", model.path(*id), items.join("/")) };
            cells.insert(name, cell);
            of_node.insert(items, content);
        }
        contents.insert(*id, of_node);
    }
    cells
}

/// The items for which a node is cooked; none at all where a list that it repeats over is not known.
fn combinations(model: &Model, contents: &BTreeMap<usize, BTreeMap<Items, Option<Content>>>, id: usize) -> Vec<Items> {
    let mut all = vec![Vec::new()];
    for origin in model.scope(id) {
        let mut next = Vec::new();
        for items in all {
            let names: Vec<String> = if model.nodes[&origin].work == Work::ReadAll {
                let takes = model.files.keys().filter_map(|name| name.strip_prefix("takes/")?.strip_suffix(".txt"));
                takes.map(str::to_owned).collect()
            } else {
                match contents[&origin].get(&items) {
                    Some(Some(Content::List(list))) => list.keys().cloned().collect(),
                    _ => Vec::new(),
                }
            };
            next.extend(names.into_iter().map(|name| items.iter().cloned().chain([name]).collect::<Items>()));
        }
        all = next;
    }
    all
}

fn cell(
    model: &Model,
    contents: &BTreeMap<usize, BTreeMap<Items, Option<Content>>>,
    id: usize,
    items: &Items,
) -> (Cell, Option<Content>) {
    let node = &model.nodes[&id];
    let broken = (Cell { key: None, sound: false, framed: None }, None);
    let kind = node.work.kind();
    if let Work::Read(_) | Work::ReadAll = &node.work {
        let path = if let Work::Read(path) = &node.work { path.clone() } else { format!("takes/{}.txt", items[0]) };
        let Some(text) = model.files.get(&path) else { return broken };
        let values: Result<Vec<f64>, _> = text.lines().map(str::parse).collect();
        let content = values.ok().map(Content::Series);
        return (Cell { key: Some(format!("read {text}")), sound: content.is_some(), framed: None }, content);
    }
    let gathers = matches!(node.work, Work::Sum(_) | Work::Mean);
    let Some(series) = inputs(model, contents, id, items, gathers) else { return broken };
    let version = match node.work {
        Work::Versioned(slot) => model.versions.get(&slot).copied().unwrap_or(1),
        _ => 1,
    };
    // The name of the file that a node writes is no part of what it computes.
    let settings = if node.work == Work::Write { String::new() } else { format!("{:?}", node.work) };
    let mut base = format!("{kind} {version} {settings}");
    let mut number = 0.0;
    if node.work == Work::Add {
        let Some(Some(Content::Number(value))) = contents[&node.inputs[1]].get(&Vec::new()) else { return broken };
        number = *value;
        base = format!("{base} {number:?}");
    }
    let halo = if let Work::Blur(halo) = node.work { halo } else { 0 };
    let key = format!("{base} {series:?}");
    let per_frame = !matches!(node.work, Work::Sum(_) | Work::Split | Work::Write);
    if per_frame && series.iter().any(|(_, values)| values.len() != series[0].1.len()) {
        return (Cell { key: Some(key), sound: false, framed: None }, None);
    }
    let first = series.first().map(|(_, values)| values.clone()).unwrap_or_default();
    let each = |change: &dyn Fn(usize) -> f64| Content::Series((0..first.len()).map(change).collect());
    let content = match &node.work {
        Work::Scale(by) => each(&|t| first[t] * by),
        Work::Blur(halo) => each(&|t| {
            let near = &first[t.saturating_sub(*halo)..=(t + halo).min(first.len() - 1)];
            near.iter().sum::<f64>() / near.len() as f64
        }),
        Work::Round => each(&|t| first[t].round()),
        Work::Versioned(_) => each(&|t| first[t] + f64::from(version / 2)),
        Work::Add => each(&|t| first[t] + number),
        Work::Mean => each(&|t| series.iter().map(|(_, values)| values[t]).sum::<f64>() / series.len() as f64),
        Work::Sum(offset) => Content::Number(series.iter().flat_map(|(_, values)| values).sum::<f64>() + offset),
        Work::Split => {
            let runs = first.chunks(10).enumerate();
            Content::List(runs.map(|(run, values)| (format!("run{run}"), values.to_vec())).collect())
        }
        Work::Read(_) | Work::ReadAll | Work::Write => Content::File,
    };
    let framed = per_frame.then_some(Framed { base, series, halo });
    (Cell { key: Some(key), sound: true, framed }, Some(content))
}

/// The series on a cell's input by the names that the input shows, none where one of them fails.
fn inputs(
    model: &Model,
    contents: &BTreeMap<usize, BTreeMap<Items, Option<Content>>>,
    id: usize,
    items: &Items,
    gathers: bool,
) -> Option<Vec<(String, Vec<f64>)>> {
    let node = &model.nodes[&id];
    let sources = if gathers { node.inputs.as_slice() } else { &node.inputs[..1] };
    let mut found = Vec::new();
    for source in sources {
        let scope = model.scope(*source);
        // What varies over lists that the node does not repeat over is gathered.
        let standing = contents[source].iter().filter(|(theirs, _)| gathers || items.starts_with(theirs));
        if gathers && lost(model, contents, &scope) {
            return None;
        }
        for (theirs, content) in standing {
            let name = |more: Option<&String>| {
                let open: Vec<&str> = theirs.iter().chain(more).map(String::as_str).collect();
                let several = sources.len() > 1;
                match (gathers, open.is_empty(), several) {
                    (false, ..) => String::new(),
                    (true, true, _) => model.reference(*source),
                    (true, false, false) => open.join("/"),
                    (true, false, true) => format!("{}/{}", model.reference(*source), open.join("/")),
                }
            };
            match content.as_ref()? {
                Content::Series(values) => found.push((name(None), values.clone())),
                Content::List(list) if gathers => {
                    found.extend(list.iter().map(|(item, values)| (name(Some(item)), values.clone())));
                }
                Content::List(list) => {
                    let item = items.get(theirs.len())?;
                    found.push((String::new(), list.get(item)?.clone()));
                }
                Content::Number(_) | Content::File => return None,
            }
        }
    }
    found.sort_by(|one, other| one.0.cmp(&other.0));
    Some(found)
}

/// Whether some list that is repeated over can never be known, since what gives it fails.
fn lost(model: &Model, contents: &BTreeMap<usize, BTreeMap<Items, Option<Content>>>, scope: &[usize]) -> bool {
    scope.iter().any(|origin| model.nodes[origin].work == Work::Split && contents[origin].values().any(Option::is_none))
}
