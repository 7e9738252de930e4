//! Random graphs as data: how they grow, how they are edited, and the files they are written as.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::sync::atomic::{AtomicU32, Ordering};

/// Choices drawn from one number, so that a failing case shrinks by numbers.
pub struct Dice(pub u64);

impl Dice {
    /// A number below `most` (`SplitMix64`).
    pub fn below(&mut self, most: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) % most.max(1) as u64) as usize
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> Option<T> {
        (!from.is_empty()).then(|| from[self.below(from.len())])
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum Work {
    Read(String),
    /// Reads `takes/*.txt`, one item a file.
    ReadAll,
    Scale(f64),
    Blur(usize),
    Round,
    Versioned(u32),
    Sum(f64),
    Mean,
    Split,
    Add,
    Write,
}

#[derive(Debug, Clone)]
pub struct Node {
    pub name: String,
    pub work: Work,
    /// For `Add` the series and the number; for `Sum` and `Mean` all that is gathered.
    pub inputs: Vec<usize>,
    /// The nested graph that it stands in.
    pub group: Option<usize>,
}

/// A chain of nodes that is written as a nested graph.
#[derive(Debug, Clone)]
pub struct Group {
    pub members: Vec<usize>,
    /// From this position on, the members stand in a graph nested once more.
    pub deeper: usize,
}

/// How an edit reaches an engine that stays in memory.
#[derive(Debug, Clone, PartialEq)]
pub enum Push {
    Exchange(usize),
    Rescan,
    Reload,
}

#[derive(Debug, Clone)]
pub struct Model {
    pub files: BTreeMap<String, String>,
    /// Files that are written again though they are equal.
    pub touched: BTreeSet<String>,
    /// Nodes by a number that is greater than those of all nodes they need.
    pub nodes: BTreeMap<usize, Node>,
    pub groups: BTreeMap<usize, Group>,
    pub versions: BTreeMap<u32, u32>,
    pub reversed: bool,
    next: usize,
}

static SLOTS: AtomicU32 = AtomicU32::new(1);

fn numbers(dice: &mut Dice, count: usize) -> String {
    let mut text = String::new();
    for _ in 0..count {
        let _ = writeln!(text, "{}", dice.below(4000) as f64 / 8.0);
    }
    text
}

impl Model {
    /// Two single series and a pattern of three takes, grown by one node or group a number.
    pub fn new(seeds: &[u64]) -> Self {
        let mut dice = Dice(1);
        let files = ["one_0.txt", "one_1.txt", "takes/a.txt", "takes/b.txt", "takes/c.txt"];
        let lengths = [70, 70, 40, 75, 33];
        let files = files.iter().zip(lengths).map(|(name, count)| ((*name).to_owned(), numbers(&mut dice, count)));
        let mut model = Self {
            files: files.collect(),
            touched: BTreeSet::new(),
            nodes: BTreeMap::new(),
            groups: BTreeMap::new(),
            versions: BTreeMap::new(),
            reversed: false,
            next: 0,
        };
        for work in [Work::Read("one_0.txt".into()), Work::Read("one_1.txt".into()), Work::ReadAll] {
            model.push(work, Vec::new(), None);
        }
        for seed in seeds {
            model.grow(&mut Dice(*seed));
        }
        model
    }

    fn push(&mut self, work: Work, inputs: Vec<usize>, group: Option<usize>) -> usize {
        let id = self.next;
        self.next += 1;
        self.nodes.insert(id, Node { name: format!("n{id}"), work, inputs, group });
        id
    }

    /// Adds a node, or a chain of nodes in a graph of their own.
    fn grow(&mut self, dice: &mut Dice) {
        let mut series: Vec<usize> = self.visible().filter(|id| self.gives_series(*id)).collect();
        let still: Vec<usize> = series.iter().copied().filter(|id| self.reach(*id).is_empty()).collect();
        let numbers: Vec<usize> = self.visible().filter(|id| matches!(self.nodes[id].work, Work::Sum(_))).collect();
        // Half of the time the newest, which makes deep graphs; else any, which makes wide ones.
        if dice.below(2) == 0 {
            series.drain(..series.len() - 1);
        }
        let Some(from) = dice.pick(&series) else { return };
        let wire = |work| (work, vec![from]);
        let (work, inputs) = match dice.below(16) {
            0..=3 => return self.grow_group(dice, from),
            4 | 5 if self.reach(from).len() < 2 => wire(Work::Split),
            6 | 7 => {
                let many: Vec<usize> = (0..=dice.below(3)).filter_map(|_| dice.pick(&series)).collect();
                let many: BTreeSet<usize> = many.into_iter().collect();
                (Work::Sum(dice.below(9) as f64), many.into_iter().collect())
            }
            8 => {
                let many: BTreeSet<usize> = (0..=dice.below(3)).filter_map(|_| dice.pick(&still)).collect();
                (Work::Mean, many.into_iter().collect())
            }
            9 | 10 if !numbers.is_empty() => (Work::Add, vec![from, numbers[dice.below(numbers.len())]]),
            11 if self.reach(from).len() < 2 => wire(Work::Write),
            _ => wire(Self::chain_work(dice)),
        };
        self.push(work, inputs, None);
    }

    fn chain_work(dice: &mut Dice) -> Work {
        match dice.below(5) {
            0 => Work::Round,
            1 => Work::Blur(dice.below(6)),
            2 => Work::Versioned(SLOTS.fetch_add(1, Ordering::Relaxed)),
            _ => Work::Scale(1.0 + dice.below(8) as f64 / 4.0),
        }
    }

    fn grow_group(&mut self, dice: &mut Dice, mut from: usize) {
        let group = self.next;
        self.next += 1;
        let count = 2 + dice.below(3);
        let mut members = Vec::new();
        for _ in 0..count {
            from = self.push(Self::chain_work(dice), vec![from], Some(group));
            members.push(from);
        }
        self.groups.insert(group, Group { deeper: 1 + dice.below(count), members });
    }

    /// Nodes that others can be wired to: those of nested graphs only where they are its output.
    fn visible(&self) -> impl Iterator<Item = usize> {
        self.nodes
            .iter()
            .filter(|(id, node)| {
                node.work != Work::Write
                    && node.group.is_none_or(|group| self.groups[&group].members.last() == Some(id))
            })
            .map(|(id, _)| *id)
    }

    fn gives_series(&self, id: usize) -> bool {
        !matches!(self.nodes[&id].work, Work::Sum(_) | Work::Write)
    }

    /// The lists over which a node repeats, named by the nodes that give them.
    pub fn scope(&self, id: usize) -> Vec<usize> {
        let node = &self.nodes[&id];
        match node.work {
            Work::Read(_) | Work::Sum(_) | Work::Mean => Vec::new(),
            Work::ReadAll => vec![id],
            _ => self.reach(node.inputs[0]),
        }
    }

    /// The lists through which a node's output varies.
    pub fn reach(&self, id: usize) -> Vec<usize> {
        let mut scope = self.scope(id);
        if self.nodes[&id].work == Work::Split {
            scope.push(id);
        }
        scope
    }

    /// What the graph calls the output of a node.
    pub fn reference(&self, id: usize) -> String {
        let node = &self.nodes[&id];
        node.group.map_or_else(|| node.name.clone(), |group| format!("g{group}"))
    }

    /// The name of a node through all nesting.
    pub fn path(&self, id: usize) -> String {
        let node = &self.nodes[&id];
        let Some(group) = node.group else { return node.name.clone() };
        let Group { members, deeper } = &self.groups[&group];
        let within = members.iter().position(|member| *member == id).unwrap() >= *deeper;
        format!("g{group}/{}{}", if within { "in/" } else { "" }, node.name)
    }

    /// One edit; how it reaches an engine in memory.
    pub fn edit(&mut self, dice: &mut Dice) -> Push {
        let ids: Vec<usize> = self.nodes.keys().copied().collect();
        match dice.below(16) {
            0..=3 => self.edit_parameter(dice, &ids),
            4..=8 => self.edit_file(dice),
            9 => self.rewire(dice, &ids),
            10 => {
                let slots = self.nodes.values().filter_map(|node| match node.work {
                    Work::Versioned(slot) => Some(slot),
                    _ => None,
                });
                let slots: Vec<u32> = slots.collect();
                if let Some(slot) = dice.pick(&slots) {
                    *self.versions.entry(slot).or_insert(1) += 1;
                }
                Push::Reload
            }
            11 => {
                let name = format!("takes/{}.txt", ["a", "b", "c", "d", "e"][dice.below(5)]);
                if self.files.remove(&name).is_none() {
                    let count = 20 + dice.below(60);
                    self.files.insert(name, numbers(dice, count));
                }
                Push::Reload
            }
            12 => {
                self.grow(dice);
                Push::Reload
            }
            13 => {
                let used: BTreeSet<usize> = self.nodes.values().flat_map(|node| node.inputs.clone()).collect();
                let leaves: Vec<usize> = ids
                    .into_iter()
                    .filter(|id| *id > 2 && !used.contains(id) && self.nodes[id].group.is_none())
                    .collect();
                if let Some(leaf) = dice.pick(&leaves) {
                    self.nodes.remove(&leaf);
                }
                Push::Reload
            }
            14 => {
                let single: Vec<usize> = ids.into_iter().filter(|id| self.nodes[id].group.is_none()).collect();
                if let Some(id) = dice.pick(&single) {
                    self.nodes.get_mut(&id).unwrap().name = format!("r{}", self.next);
                    self.next += 1;
                }
                Push::Reload
            }
            _ => {
                self.reversed = !self.reversed;
                Push::Reload
            }
        }
    }

    fn edit_parameter(&mut self, dice: &mut Dice, ids: &[usize]) -> Push {
        let fitting: Vec<usize> = ids
            .iter()
            .copied()
            .filter(|id| matches!(self.nodes[id].work, Work::Scale(_) | Work::Blur(_) | Work::Sum(_)))
            .collect();
        let Some(id) = dice.pick(&fitting) else { return Push::Rescan };
        match &mut self.nodes.get_mut(&id).unwrap().work {
            Work::Scale(by) | Work::Sum(by) => *by = 1.0 + dice.below(8) as f64 / 4.0,
            // Another halo is another card.
            Work::Blur(halo) => {
                *halo = dice.below(6);
                return Push::Reload;
            }
            _ => {}
        }
        Push::Exchange(id)
    }

    fn edit_file(&mut self, dice: &mut Dice) -> Push {
        let names: Vec<String> = self.files.keys().cloned().collect();
        let name = names[dice.below(names.len())].clone();
        let text = self.files.get_mut(&name).unwrap();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let at = dice.below(lines.len());
        match dice.below(8) {
            0 => {
                self.touched.insert(name);
                return Push::Rescan;
            }
            // So little that rounding hides it, most of the time.
            1 | 2 => lines[at] = lines[at].parse().map_or("7".to_owned(), |number: f64| (number + 0.01).to_string()),
            // The same number, written otherwise.
            3 => lines[at] = format!("{}e0", lines[at].trim_end_matches("e0")),
            4 => lines.push("3.5".to_owned()),
            5 if lines.len() > 1 => drop(lines.pop()),
            6 => lines[at] = if lines[at] == "bad" { "1".to_owned() } else { "bad".to_owned() },
            _ => lines[at] = dice.below(500).to_string(),
        }
        *text = lines.join("\n") + "\n";
        Push::Rescan
    }

    /// Wires a node to another that varies over the same lists, so that all behind it still fits.
    fn rewire(&mut self, dice: &mut Dice, ids: &[usize]) -> Push {
        let fitting: Vec<usize> = ids.iter().copied().filter(|id| !self.nodes[id].inputs.is_empty()).collect();
        let Some(id) = dice.pick(&fitting) else { return Push::Reload };
        let standing = self.nodes[&id].inputs[0];
        if self.nodes[&standing].group.is_some() && self.nodes[&standing].group == self.nodes[&id].group {
            return Push::Reload;
        }
        let reach = self.reach(standing);
        let others: Vec<usize> = self
            .visible()
            .filter(|other| *other < id && self.gives_series(*other) && self.reach(*other) == reach)
            .filter(|other| !self.nodes[&id].inputs.contains(other))
            .collect();
        if let Some(other) = dice.pick(&others) {
            self.nodes.get_mut(&id).unwrap().inputs[0] = other;
        }
        Push::Reload
    }
}
