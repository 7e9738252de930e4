//! Cells: the units that are cooked. A node of the plan is one cell, or one cell for each item it repeats over.

use super::key::{Part, frame_of, key_of};
use super::plain::Sources;
use super::session::{CellRecord, Reason};
use super::slot::Slot;
use crate::files::Pattern;
use crate::node::{Card, Node, PortFacts};
use crate::plan::{OriginId, Plan, PlanSource};
use crate::store::{Action, OutputRecord};
use smallvec::SmallVec;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use wire::{Digest, Hasher};

/// Index of a cell.
pub(crate) type CellId = usize;

/// What stands on an output of a finished cell.
#[derive(Debug, Clone)]
pub(crate) enum SlotSet {
    One(Arc<Slot>),
    List(BTreeMap<String, Arc<Slot>>),
}

impl SlotSet {
    pub fn slots(&self) -> Vec<&Arc<Slot>> {
        match self {
            Self::One(slot) => vec![slot],
            Self::List(items) => items.values().collect(),
        }
    }

    /// The slot of a single value.
    pub fn one(&self) -> Option<&Arc<Slot>> {
        match self {
            Self::One(slot) => Some(slot),
            Self::List(_) => None,
        }
    }

    /// The digest of everything that stands here.
    pub fn digest(&self) -> Digest {
        match self {
            Self::One(slot) => slot.digest,
            Self::List(items) => list_digest(items.iter().map(|(name, slot)| (name, slot.digest))),
        }
    }

    pub fn record(&self) -> OutputRecord {
        match self {
            Self::One(slot) => OutputRecord::One(slot.record().clone()),
            Self::List(items) => {
                OutputRecord::List(items.iter().map(|(name, slot)| (name.clone(), slot.record().clone())).collect())
            }
        }
    }
}

/// The digest of a list of named values.
pub(crate) fn list_digest<'a>(items: impl Iterator<Item = (&'a String, Digest)>) -> Digest {
    let mut hasher = Hasher::new("list");
    for (name, digest) in items {
        hasher.bytes(name.as_bytes()).digest(&digest);
    }
    hasher.finish()
}

/// What stands on all outputs of a finished cell, in the order of its card.
pub(crate) type Slots = Arc<[SlotSet]>;

/// Where one value on an input comes from.
#[derive(Debug, Clone)]
pub(crate) struct Wire {
    pub cell: CellId,
    /// Position of the output on the producer's card.
    pub output: usize,
    /// The item of a list output, where a single item is meant.
    pub item: Option<String>,
    /// The name under which a gathering port shows it; a whole list output shows its own items under it.
    pub label: String,
}

impl Wire {
    /// The name under which a gathering port shows the item `name` of a whole list.
    pub fn label_of<'a>(&self, name: &'a str) -> Cow<'a, str> {
        if self.label.is_empty() { name.into() } else { format!("{}/{name}", self.label).into() }
    }
}

/// A connected input of a cell.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    pub port: PortFacts,
    pub wires: Vec<Wire>,
}

impl Link {
    /// The label of the part of a key that this input makes.
    pub fn label(&self) -> String {
        format!("input `{}`", self.port.name)
    }

    /// Whether the port varies over time and is cut into blocks for a cell that works per frame.
    pub fn framed(&self) -> bool {
        self.port.kind.framed && !self.port.still
    }
}

/// How far a cell is.
#[derive(Debug, Clone)]
pub(crate) enum State {
    /// Nothing is known of it yet.
    Waiting,
    /// Finished, with what stands on its outputs.
    Done(Slots),
    /// In a plan: it would be cooked, so its outputs are not known.
    Unknown,
    /// Failed, or skipped because of the failure of the cell named.
    Failed(String),
}

/// The parts of a key that are a cell's own: kind, version, parameters. Shared by the cells of a plan node.
#[derive(Debug)]
pub(crate) struct Settings {
    pub parts: Vec<Part>,
    /// Over all parts.
    pub digest: Digest,
}

/// The content of each link of a cell.
pub(crate) type Inputs = SmallVec<[Digest; 2]>;

/// What a key was made of the last time it was asked for.
#[derive(Debug, Clone, Default)]
pub(crate) struct Made {
    pub key: Digest,
    pub settings: Option<Arc<Settings>>,
    /// Content of the source file.
    pub file: Option<Digest>,
    /// Content of each link.
    pub inputs: Inputs,
    pub block_keys: Vec<Digest>,
    /// For a cell with a halo: the key of each block over the exact frames that it sees, not whole blocks of them.
    pub frame_keys: Vec<Digest>,
}

/// A unit of cooking.
#[derive(Debug)]
pub(crate) struct Cell {
    pub plan: usize,
    /// Item names, one a list of the plan node's scope.
    pub items: Vec<String>,
    /// `node` or `node@item`.
    pub name: String,
    pub node: Arc<dyn Node>,
    pub card: Arc<Card>,
    pub settings: Arc<Settings>,
    /// Settings and ports: the beginning of the key.
    pub frame: Digest,
    pub file: Option<PathBuf>,
    pub writes: Option<PathBuf>,
    pub links: Vec<Link>,
    /// What makes a link impossible, such as an item that a zipped list lacks.
    pub broken: Option<String>,
    /// Where its inputs come from, where it is plain: whole, of single values, without files (`plain`).
    pub plain: Option<Sources>,
    pub state: State,
    pub made: Made,
    /// Whether it was last made as a plain cell since its settings are what they are: its key is then not worked out so far, and
    /// `made.settings` are the cell's own.
    pub plainly_made: bool,
    /// The part of the blocks' keys that all of them share.
    pub base_key: Digest,
    /// What the session of an earlier process, or this engine before the last change, knew of it.
    pub before: Option<Box<CellRecord>>,
    /// The cook in which it was last computed, and why.
    pub cooked: Option<(u64, Reason)>,
    /// The cook in which its result last changed.
    pub changed_run: u64,
    /// Seconds that it took to compute, and the files that it was seen to read beside its own.
    pub seconds: f64,
    pub reads: Vec<(String, Digest)>,
    /// Seconds to have its values again: to read them, or to compute them and all that is not kept before them.
    pub again_s: f64,
}

impl Cell {
    /// The innermost item's name, empty outside of lists.
    pub fn item(&self) -> &str {
        self.items.last().map_or("", String::as_str)
    }

    /// The key under which it was last made.
    pub fn key(&self) -> Digest {
        if self.plainly_made { key_of(&self.frame, None, &self.made.inputs) } else { self.made.key }
    }

    /// The settings with which it was last made.
    pub fn made_settings(&self) -> Option<&Arc<Settings>> {
        if self.plainly_made { Some(&self.settings) } else { self.made.settings.as_ref() }
    }

    /// Has it have other settings; what it was last made of stays known.
    pub fn set_settings(&mut self, settings: &Arc<Settings>) {
        if self.plainly_made {
            (self.made.key, self.made.settings) = (self.key(), Some(Arc::clone(&self.settings)));
            self.plainly_made = false;
        }
        self.settings = Arc::clone(settings);
        self.frame = frame_of(settings, self.file.is_some(), &self.links);
    }

    pub fn slots(&self) -> Option<&Slots> {
        match &self.state {
            State::Done(slots) => Some(slots),
            _ => None,
        }
    }

    /// The outputs by the names of their ports.
    pub fn outputs(&self) -> impl Iterator<Item = (&'static str, &SlotSet)> {
        let sets = self.slots().map_or(&[][..], |slots| slots);
        self.card.outputs.iter().map(|port| port.name).zip(sets)
    }

    /// What the store and the session keep of its result.
    pub fn action(&self) -> Action {
        let outputs = self.outputs().map(|(name, set)| (name.to_owned(), set.record())).collect();
        Action { outputs, reads: self.reads.clone(), seconds: self.seconds }
    }
}

/// The items of a list that are known so far: by the items of the lists around it.
pub(crate) type KnownItems = BTreeMap<(OriginId, Vec<String>), BTreeMap<String, Option<PathBuf>>>;

/// The lists whose items cannot be known, by the items of the lists around them, with the cell that failed to give them.
pub(crate) type LostLists = BTreeMap<(OriginId, Vec<String>), CellId>;

/// The item combinations over which a node repeats.
#[derive(Debug, Default)]
pub(crate) struct Combinations {
    pub known: Vec<Vec<String>>,
    /// The items down to a list that is lost, with the cell that failed to give it.
    pub lost: Vec<(Vec<String>, CellId)>,
}

/// The item combinations over which `scope` repeats; `None` while a list's items are not known.
pub(crate) fn combinations(
    plan: &Plan,
    scope: &[OriginId],
    known: &KnownItems,
    lost: &LostLists,
) -> Option<Combinations> {
    let mut all = Combinations { known: vec![Vec::new()], lost: Vec::new() };
    for (depth, origin) in scope.iter().enumerate() {
        let mut next = Vec::new();
        for items in &all.known {
            let list = (*origin, outer_items(plan, *origin, &scope[..depth], items));
            if let Some(giver) = lost.get(&list) {
                all.lost.push((items.clone(), *giver));
                continue;
            }
            for name in known.get(&list)?.keys() {
                let mut items: Vec<String> = items.clone();
                items.push(name.clone());
                next.push(items);
            }
        }
        all.known = next;
    }
    Some(all)
}

/// The items, among `items` of `scope`, of the lists that `origin` itself repeats over.
pub(crate) fn outer_items(plan: &Plan, origin: OriginId, scope: &[OriginId], items: &[String]) -> Vec<String> {
    let wanted = &plan.origins[origin].scope;
    wanted
        .iter()
        .filter_map(|outer| scope.iter().position(|own| own == outer).map(|depth| items[depth].clone()))
        .collect()
}

/// Where existing cells are found: by plan node and items.
pub(crate) type Directory = BTreeMap<(usize, Vec<String>), CellId>;

/// The wires from `source` to a cell of `consumer` with the items `items`.
pub(crate) fn wires(
    plan: &Plan,
    directory: &Directory,
    (consumer, items): (usize, &[String]),
    source: &PlanSource,
    gathers: Option<bool>,
) -> Result<Vec<Wire>, String> {
    let (own, theirs) = (&plan.nodes[consumer].scope, &plan.nodes[source.node].scope);
    let innermost = items.last();
    let item_of = |origin: &OriginId| own.iter().position(|mine| mine == origin).map(|depth| items[depth].clone());
    let list_origin =
        plan.origins.iter().position(|origin| origin.node == source.node && origin.port.as_ref() == Some(&source.port));
    let item = match (source.list, gathers) {
        (true, None) => list_origin.as_ref().and_then(item_of).or_else(|| innermost.cloned()),
        _ => None,
    };
    let fixed: Vec<Option<String>> = theirs.iter().map(item_of).collect();
    let open = fixed.iter().filter(|item| item.is_none()).count();
    let outputs = &plan.nodes[source.node].card.outputs;
    let output = outputs.iter().position(|port| port.name == source.port).unwrap_or_default();
    let wire = |cell: CellId, label: String| Wire { cell, output, item: item.clone(), label };
    let several = gathers.unwrap_or(false);
    if open == 0 {
        let items: Vec<String> = fixed.into_iter().flatten().collect();
        let cell = directory.get(&(source.node, items)).ok_or_else(|| format!("`{}` is not there", source.label))?;
        let label = if source.list && !several { String::new() } else { source.label.clone() };
        return Ok(vec![wire(*cell, label)]);
    }
    let matching =
        directory.range((source.node, Vec::new())..).take_while(|((node, _), _)| *node == source.node).filter(
            |((_, theirs), _)| theirs.iter().zip(&fixed).all(|(one, fixed)| fixed.as_ref().is_none_or(|f| f == one)),
        );
    if gathers.is_some() {
        return Ok(matching
            .map(|((_, theirs), cell)| {
                let open = theirs.iter().zip(&fixed).filter(|(_, fixed)| fixed.is_none());
                let name = open.map(|(name, _)| name.as_str()).collect::<Vec<_>>().join("/");
                wire(*cell, if several { format!("{}/{name}", source.label) } else { name })
            })
            .collect());
    }
    // Another list: its item of the same name.
    let wanted = innermost.cloned().unwrap_or_default();
    let mut names = Vec::new();
    for ((_, theirs), cell) in matching {
        let name = theirs.last().cloned().unwrap_or_default();
        if name == wanted {
            return Ok(vec![wire(*cell, String::new())]);
        }
        names.push(name);
    }
    Err(format!("`{}` has no item `{wanted}`; it has {}", source.label, some_of(&names)))
}

/// The first few of `names`, for messages.
pub(crate) fn some_of(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        few if few.len() <= 6 => few.join(", "),
        many => format!("{} and {} more", many[..5].join(", "), many.len() - 5),
    }
}

/// The items of the files that match `pattern`.
pub(crate) fn file_items(pattern: &Pattern) -> Result<BTreeMap<String, Option<PathBuf>>, String> {
    let files = pattern.files().map_err(|problem| problem.to_string())?;
    Ok(files.into_iter().map(|(name, path)| (name, Some(path))).collect())
}

/// The name of a cell.
pub(crate) fn cell_name(path: &str, items: &[String]) -> String {
    if items.is_empty() { path.to_owned() } else { format!("{path}@{}", items.join("/")) }
}
