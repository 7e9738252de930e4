//! A snapshot as it is taken after a cook.

use super::chosen::chosen;
use super::reduce::{Reduced, reduce};
use super::trace::Trace;
use crate::cook::{Engine, LookError};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use wire::{Tolerance, Value};

/// What the chosen outputs gave.
#[derive(Debug)]
pub struct Taken {
    /// The outputs, by name.
    pub outputs: BTreeMap<String, TakenOutput>,
    /// What every cell before them was made of and gave.
    pub trace: Trace,
}

/// An output as it was found.
#[derive(Debug)]
pub struct TakenOutput {
    /// Type of its values.
    pub kind: &'static str,
    /// Version of their encoding.
    pub version: u32,
    /// Tolerances that the type itself names, by table, with their unit.
    pub tolerances: BTreeMap<String, (Tolerance, &'static str)>,
    /// The values by item, each with the cell that gave it; one without a name outside of lists.
    pub items: BTreeMap<String, (usize, Reduced)>,
    /// Items that could not be cooked.
    pub failed: Vec<String>,
}

impl Taken {
    /// Looks at the chosen outputs after a cook.
    ///
    /// # Errors
    /// Where a value cannot be had.
    pub fn after(engine: &mut Engine) -> Result<Self, LookError> {
        let chosen = chosen(engine.plan());
        let mut ends = BTreeSet::new();
        let mut outputs = BTreeMap::new();
        for (name, chosen) in chosen {
            let Some(port) = engine.plan().nodes[chosen.node].card.output(&chosen.port).copied() else { continue };
            let mut output = TakenOutput {
                kind: port.kind.name,
                version: port.kind.version,
                tolerances: BTreeMap::new(),
                items: BTreeMap::new(),
                failed: Vec::new(),
            };
            for (cell, item, place, digest) in places(engine, chosen.node, &chosen.port) {
                ends.insert(cell);
                let Some(digest) = digest else {
                    output.failed.push(item);
                    continue;
                };
                let value: Arc<dyn Value> = engine.value(cell, &chosen.port, &place)?;
                for table in value.tables() {
                    output.tolerances.insert(table.what.to_owned(), (table.tolerance, table.unit));
                }
                output.items.insert(item, (cell, reduce(value.as_ref(), &digest)));
            }
            outputs.insert(name, output);
        }
        let trace = Trace::of(engine, &ends);
        Ok(Self { outputs, trace })
    }
}

/// Cell, name of the item, its name on a list output, and digest of each value; none where the cell failed.
fn places(engine: &Engine, node: usize, port: &str) -> Vec<(usize, String, String, Option<wire::Digest>)> {
    let mut found = Vec::new();
    for cell in engine.cells().into_iter().filter(|cell| cell.node == node) {
        let outer = cell.items.join("/");
        let Some((_, record)) = cell.outputs.iter().find(|(name, _)| *name == port) else {
            found.push((cell.id, outer, String::new(), None));
            continue;
        };
        for (item, value) in record.values() {
            let name = [outer.as_str(), item].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("/");
            found.push((cell.id, name, item.to_owned(), Some(value.digest)));
        }
    }
    found
}
