//! Unfolds plan nodes into cells as soon as the items they repeat over are known.

use super::cell::{
    Cell, CellId, Link, Made, Settings, SlotSet, State, cell_name, combinations, file_items, outer_items, wires,
};
use super::engine::Engine;
use super::event::Event;
use super::key::frame_of;
use super::turn::{Few, Turn};
use crate::document::Spanned;
use crate::plan::{OriginId, PlanNode, PlanSource, make};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use wire::Digest;

impl Engine {
    /// Makes all cells that can be made now.
    pub(super) fn unfold(&mut self) {
        let before = self.cells.len();
        let mut folded = Vec::new();
        for index in std::mem::take(&mut self.folded) {
            if self.waits(index, &folded) {
                folded.push(index);
                continue;
            }
            self.learn_files(index);
            match combinations(&self.plan, &self.plan.nodes[index].scope, &self.known_items, &self.lost_lists) {
                None => folded.push(index),
                Some(all) => {
                    for (items, giver) in all.lost {
                        self.skip(index, &items, giver);
                    }
                    for items in all.known {
                        self.make_cell(index, items);
                    }
                }
            }
        }
        self.folded = folded;
        if self.cells.len() > before {
            self.tell(|| Event::Planned { cells: self.cells.len() });
        }
    }

    /// Whether something that the node is connected to has no cells yet.
    fn waits(&self, index: usize, folded: &[usize]) -> bool {
        let sources = self.plan.nodes[index].inputs.iter().flat_map(|input| &input.sources);
        sources.into_iter().any(|source| folded.contains(&source.node))
    }

    /// Tells that a node has no cells for `items`, since the cell that gives a list it repeats over failed.
    fn skip(&mut self, index: usize, items: &[String], giver: CellId) {
        let State::Failed(cause) = &self.cells[giver].state else { return };
        let (node, because) = (cell_name(&self.plan.nodes[index].path, items), cause.clone());
        self.summary.skipped += 1;
        self.tell(|| Event::Skipped { node, because });
    }

    /// The cells that failed to give lists over which the sources of a gathering input repeat.
    fn lost_givers(&self, index: usize, items: &[String], source: &PlanSource) -> Vec<CellId> {
        let (own, theirs) = (&self.plan.nodes[index].scope, &self.plan.nodes[source.node].scope);
        let concerns = |origin: OriginId, outer: &[String]| {
            let fits = |(at, list): (usize, &OriginId)| {
                own.iter().position(|mine| mine == list).is_none_or(|depth| items[depth] == outer[at])
            };
            theirs.contains(&origin) && self.plan.origins[origin].scope.iter().enumerate().all(fits)
        };
        let lost = self.lost_lists.iter().filter(|((origin, outer), _)| concerns(*origin, outer));
        lost.map(|(_, giver)| *giver).collect()
    }

    /// Finds the files of a node that repeats over them.
    fn learn_files(&mut self, index: usize) {
        let node = &self.plan.nodes[index];
        let Some(origin) = node.scope.last().copied() else { return };
        if self.plan.origins[origin].node != index || self.plan.origins[origin].port.is_some() {
            return;
        }
        let outer = &node.scope[..node.scope.len() - 1];
        let Some(all) = combinations(&self.plan, outer, &self.known_items, &self.lost_lists) else { return };
        for items in all.known {
            let key = (origin, outer_items(&self.plan, origin, outer, &items));
            let pattern = match self.remade(node, &items) {
                Ok(Some(made)) => made.reads,
                Ok(None) => node.reads.clone(),
                Err(_) => None,
            };
            let found = pattern.as_ref().map_or(Ok(BTreeMap::new()), file_items);
            let mut found = found.unwrap_or_else(|problem| {
                self.tell(|| Event::Notice { about: node.path.clone(), message: problem });
                BTreeMap::new()
            });
            found.retain(|_, file| file.as_ref().is_none_or(|file| self.is_there(file)));
            if found.is_empty() && self.options.gate.is_none() {
                let path = pattern.as_ref().map_or_else(String::new, |pattern| pattern.path().display().to_string());
                let message = format!("no file matches {path}, so there is nothing to cook for it");
                self.tell(|| Event::Notice { about: node.path.clone(), message });
            }
            if let Some(pattern) = pattern {
                let files = found.iter().filter_map(|(item, file)| Some((item.clone(), file.clone()?)));
                self.listed.insert(pattern.path().to_owned(), files.collect());
            }
            self.known_items.insert(key, found);
        }
    }

    /// The node made anew for an item, where its parameters mention the item.
    fn remade(&self, node: &PlanNode, items: &[String]) -> Result<Option<crate::plan::Made>, String> {
        let (true, Some(item)) = (node.template.mentions_item, items.last()) else { return Ok(None) };
        let template = &node.template;
        let span = template.entry().name_span;
        let kind = Spanned { value: node.kind.clone(), span };
        let (made, mistakes) =
            make(&template.graph, &template.name, &kind, &template.scope, Some(item), &self.overrides, &node.path);
        made.map(Some).ok_or_else(|| mistakes.first().map_or_else(String::new, |mistake| mistake.message.clone()))
    }

    fn make_cell(&mut self, index: usize, items: Vec<String>) {
        let node = &self.plan.nodes[index];
        let name = cell_name(&node.path, &items);
        let made = self.remade(node, &items);
        let settings = match &made {
            Ok(Some(made)) => Arc::new(Settings::of(made.node.as_ref(), &made.card)),
            _ => Arc::clone(
                self.settings.entry(index).or_insert_with(|| Arc::new(Settings::of(node.node.as_ref(), &node.card))),
            ),
        };
        let mut cell = Cell {
            plan: index,
            before: self.session.cells.remove(&name).map(Box::new),
            name,
            node: Arc::clone(&node.node),
            card: Arc::clone(&node.card),
            settings,
            frame: Digest::default(),
            file: node.reads.as_ref().map(|pattern| pattern.path().to_owned()),
            writes: node.writes.clone(),
            links: Vec::with_capacity(node.inputs.len()),
            broken: None,
            plain: None,
            state: State::Waiting,
            made: Made::default(),
            plainly_made: false,
            base_key: Digest::default(),
            cooked: None,
            changed_run: 0,
            seconds: 0.0,
            reads: Vec::new(),
            again_s: 0.0,
            items,
        };
        match made {
            Ok(None) => {}
            Ok(Some(made)) => {
                (cell.node, cell.card) = (made.node, made.card);
                cell.file = made.reads.map(|pattern| pattern.path().to_owned());
                cell.writes = made.writes;
            }
            Err(problem) => cell.broken = Some(problem),
        }
        if let Some(origin) = node.scope.last()
            && self.plan.origins[*origin].node == index
            && self.plan.origins[*origin].port.is_none()
        {
            let depth = cell.items.len() - 1;
            let outer = outer_items(&self.plan, *origin, &node.scope[..depth], &cell.items[..depth]);
            let file = self.known_items.get(&(*origin, outer)).and_then(|files| files.get(&cell.items[depth]));
            cell.file = file.cloned().flatten();
        }
        let mut producers = Few::new();
        for input in &node.inputs {
            let mut link = Link { port: input.port, wires: Vec::new() };
            let gathers = input.port.list.then_some(input.sources.len() > 1);
            for source in &input.sources {
                if gathers.is_some() && !self.lost_lists.is_empty() {
                    producers.extend(self.lost_givers(index, &cell.items, source));
                }
                match wires(&self.plan, &self.directory, (index, &cell.items), source, gathers) {
                    Ok(found) => link.wires.extend(found),
                    Err(problem) => cell.broken = Some(format!("input `{}`: {problem}", input.port.name)),
                }
            }
            if !link.wires.is_empty() || input.port.list && !input.sources.is_empty() {
                cell.links.push(link);
            }
        }
        cell.frame = frame_of(&cell.settings, cell.file.is_some(), &cell.links);
        let id = self.cells.len();
        producers.extend(cell.links.iter().flat_map(|link| &link.wires).map(|wire| wire.cell));
        producers.sort_unstable();
        producers.dedup();
        let mut turn = Turn { plan: index as u32, dirty: true, ..Turn::default() };
        for producer in &producers {
            let producer = &mut self.turns[*producer];
            producer.consumers.push(id);
            producer.open_consumers += 1;
            turn.pending += u32::from(!producer.settled);
        }
        turn.producers = producers;
        cell.plain = self.plain(&cell);
        let (items, pending) = (cell.items.clone(), turn.pending);
        self.turns.push(turn);
        self.cells.push(cell);
        self.of_plan[index].push(id);
        self.directory.insert((index, items), id);
        if pending == 0 {
            self.mark(id);
        }
    }

    /// Takes the items of a finished cell's list outputs, where nodes repeat over them.
    pub(super) fn learn_items(&mut self, id: CellId) {
        let cell = &self.cells[id];
        let Some(origins) = self.list_origins.get(&cell.plan) else { return };
        let mut learned = false;
        for origin in origins {
            let Some(port) = &self.plan.origins[*origin].port else { continue };
            let key = (*origin, cell.items.clone());
            let names: BTreeMap<String, Option<PathBuf>> = match &cell.state {
                State::Done(_) => {
                    let Some((_, SlotSet::List(items))) = cell.outputs().find(|(name, _)| name == port) else {
                        continue;
                    };
                    items.keys().map(|name| (name.clone(), None)).collect()
                }
                // Cells of known items are there; they are skipped one by one.
                State::Failed(_) if self.known_items.contains_key(&key) => continue,
                State::Failed(_) => {
                    learned |= self.lost_lists.insert(key, id).is_none();
                    continue;
                }
                State::Unknown => {
                    // A plan goes on with the items that the last cook saw.
                    let record = cell.before.as_ref().and_then(|before| before.action.outputs.get(port));
                    let names = record.iter().flat_map(|record| record.values());
                    names.map(|(name, _)| (name.to_owned(), None)).collect()
                }
                State::Waiting => continue,
            };
            match self.known_items.get(&key) {
                Some(known) if *known == names => continue,
                // Cells stand, or are left out, for what the list held before.
                Some(_) => self.items_changed = true,
                None => self.items_changed |= self.lost_lists.remove(&key).is_some(),
            }
            self.known_items.insert(key, names);
            learned = true;
        }
        if learned && !self.items_changed {
            self.unfold();
        }
    }
}
