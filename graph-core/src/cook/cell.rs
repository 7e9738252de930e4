//! Cells: the units that are cooked. A node of the plan is one cell, or one cell for each item it repeats over.

use super::slot::Slot;
use crate::files::Pattern;
use crate::node::{Card, Node, PortFacts};
use crate::plan::{OriginId, Plan, PlanSource};
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
}

/// Where one value on an input comes from.
#[derive(Debug, Clone)]
pub(crate) struct Wire {
    pub cell: CellId,
    pub port: String,
    /// The item of a list output, where a single item is meant.
    pub item: Option<String>,
    /// The name under which a gathering port shows it; a whole list output shows its own items under it.
    pub label: String,
}

/// A connected input of a cell.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    pub port: PortFacts,
    pub wires: Vec<Wire>,
}

/// How far a cell is.
#[derive(Debug)]
pub(crate) enum State {
    /// Something it needs is not finished.
    Waiting,
    /// Its computation runs, or waits for values that are being remade.
    Cooking,
    /// Finished, with what stands on its outputs.
    Done(Arc<BTreeMap<String, SlotSet>>),
    /// In a plan: it would be cooked, so its outputs are not known.
    Unknown,
    /// Failed, or skipped because of the failure of the cell named.
    Failed(String),
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
    pub file: Option<PathBuf>,
    pub writes: Option<PathBuf>,
    pub links: Vec<Link>,
    /// What makes a link impossible, such as an item that a zipped list lacks.
    pub broken: Option<String>,
    pub consumers: Vec<CellId>,
    /// Producers that are not finished.
    pub pending: usize,
    pub state: State,
    pub key: Digest,
    pub block_keys: Vec<Digest>,
    /// The part of the blocks' keys that all of them share.
    pub base_key: Digest,
    /// For a cell with a halo: the key of each block over the exact frames that it sees, not whole blocks of them.
    pub frame_keys: Vec<Digest>,
    /// Consumers that are not finished; at zero, memory is let go.
    pub open_consumers: usize,
}

impl Cell {
    /// The innermost item's name, empty outside of lists.
    pub fn item(&self) -> &str {
        self.items.last().map_or("", String::as_str)
    }

    pub fn slots(&self) -> Option<&Arc<BTreeMap<String, SlotSet>>> {
        match &self.state {
            State::Done(slots) => Some(slots),
            _ => None,
        }
    }
}

/// The items of a list that are known so far: by the items of the lists around it.
pub(crate) type KnownItems = BTreeMap<(OriginId, Vec<String>), BTreeMap<String, Option<PathBuf>>>;

/// The item combinations over which `scope` repeats; `None` while a list's items are not known.
pub(crate) fn combinations(plan: &Plan, scope: &[OriginId], known: &KnownItems) -> Option<Vec<Vec<String>>> {
    let mut all = vec![Vec::new()];
    for (depth, origin) in scope.iter().enumerate() {
        let mut next = Vec::new();
        for items in &all {
            let outer = outer_items(plan, *origin, &scope[..depth], items);
            for name in known.get(&(*origin, outer))?.keys() {
                let mut items: Vec<String> = items.clone();
                items.push(name.clone());
                next.push(items);
            }
        }
        all = next;
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
    let wire = |cell: CellId, label: String| Wire { cell, port: source.port.clone(), item: item.clone(), label };
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

/// Digest of what stands on an input, as it enters keys.
pub(crate) fn link_digest(link: &Link, digest_of: impl Fn(&Wire) -> Option<Digest>) -> Option<Digest> {
    if let [wire] = link.wires.as_slice()
        && !link.port.list
    {
        return digest_of(wire);
    }
    let mut hasher = Hasher::new("gathered");
    for wire in &link.wires {
        hasher.bytes(wire.label.as_bytes()).digest(&digest_of(wire)?);
    }
    Some(hasher.finish())
}
