//! Curve work on the cook's thread: which nodes lay keys over a take's curves and measure them, told by following the plan; an
//! engine that cooks these alone and stays, so that a moved key costs the blocks it touches; and what they gave.

use super::cooker::{Ask, Kitchen};
use crate::model::Message;
use crate::model::curves::Desk;
use face_math::data::Curves;
use graph_core::cook::{Engine, Summary, session_name};
use graph_core::document::canonical_parameters;
use graph_core::plan::{Plan, PlanNode};
use std::collections::BTreeSet;
use std::sync::Arc;
use wire::{Data, Value};

/// The nodes that work on curves is about, by their names through all nesting.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Found {
    /// Lays the keys over the curves.
    edit: String,
    /// Picks the take's edits.
    pick: String,
    /// Loads the file of edits.
    load: String,
    /// Measures how far the edited curves are off.
    error: Option<String>,
    /// Whether anchors are taken from the same edits.
    anchored: bool,
}

/// An engine that stands for the work on curves.
pub struct Bench {
    engine: Engine,
    found: Found,
    of: (String, String),
    graphs_revision: u64,
    prepared: bool,
}

impl Kitchen {
    /// Cooks what work on curves shows, tells it, and writes down what is known.
    pub fn work(&mut self, ask: &Ask) -> Result<Summary, String> {
        let done = self.bring_up(ask);
        let desk = match &done {
            Ok(summary) if summary.cancelled => Err("cancelled; v begins again".to_owned()),
            Ok(_) => self.bench.as_mut().map_or_else(|| Err(String::new()), Bench::desk),
            Err(problem) => Err(problem.clone()),
        };
        self.say(Message::Desk { of: ask.of.clone(), revision: ask.revision, desk: desk.map(Arc::new) });
        if let Some(bench) = self.bench.as_mut().filter(|_| done.is_ok()) {
            bench.prepare();
            bench.engine.remember().map_err(|problem| problem.to_string())?;
        }
        done
    }

    fn bring_up(&mut self, ask: &Ask) -> Result<Summary, String> {
        let lease = self.store.lease(&session_name(&self.store, &self.root)).map_err(|problem| problem.to_string())?;
        let stands =
            self.bench.as_ref().is_some_and(|bench| bench.of == ask.of && bench.graphs_revision == ask.graphs_revision);
        if !stands {
            // One engine holds values at a time.
            (self.bench, self.standing) = (None, None);
            let plan = self.plan(&ask.texts)?;
            let found = find(&plan, &ask.of)?;
            let only = [Some(&found.edit), found.error.as_ref()].into_iter().flatten().cloned().collect();
            let engine = self.engine(plan, only).map_err(|problem| problem.to_string())?;
            let (of, graphs_revision) = (ask.of.clone(), ask.graphs_revision);
            self.bench = Some(Bench { engine, found, of, graphs_revision, prepared: false });
        }
        let Some(bench) = &mut self.bench else { return Ok(Summary::default()) };
        bench.engine.hold(&ask.texts);
        bench.engine.rescan();
        let summary = bench.engine.cook().map_err(|problem| problem.to_string());
        if summary.is_err() {
            self.bench = None;
        }
        drop(lease);
        summary
    }
}

impl Bench {
    /// The cell that lays the keys: that of the item that was asked for, or the first where none was known yet.
    fn cell(&self) -> Option<String> {
        let names = self.engine.names(&self.found.edit);
        let asked = self.of.0.split_once('@').map(|(_, item)| format!("{}@{item}", self.found.edit));
        let asked = asked.filter(|asked| names.contains(&asked.as_str()));
        asked.or_else(|| names.first().map(|name| (*name).to_owned()))
    }

    /// What the nodes gave.
    fn desk(&mut self) -> Result<Desk, String> {
        let edit = self.cell().ok_or_else(|| format!("`{}` was not cooked", self.found.edit))?;
        let item = edit.split_once('@').map_or(String::new(), |(_, item)| format!("@{item}"));
        let named = |path: &str| format!("{path}{item}");
        let pick = named(&self.found.pick);
        let take = self.engine.look(&pick).and_then(|cell| {
            let parameters = canonical_parameters(cell.made, &[]);
            serde_json::from_str(parameters.get("take")?).ok()
        });
        let take: String = take.ok_or_else(|| format!("`{pick}` does not say whose edits it picks"))?;
        let load = &self.found.load;
        let load = [load.clone(), named(load)].into_iter().find_map(|name| self.engine.look(&name));
        let file = load.and_then(|cell| cell.reads.map(std::path::Path::to_owned));
        let file = file.ok_or_else(|| format!("`{}` reads no file of edits", self.found.load))?;
        let edited = self.curves(&edit, "curves")?;
        let id = self.engine.look(&edit).map(|cell| cell.id);
        let id = id.ok_or_else(|| format!("`{edit}` was not cooked"))?;
        let given = self.engine.input(id, "curves").map_err(|problem| problem.to_string())?;
        let solved = given.into_iter().find_map(|(_, value)| value.downcast_arc::<Curves>());
        let solved = solved.ok_or_else(|| format!("`{edit}` was given no curves"))?;
        let errors = match self.found.error.as_deref().map(named) {
            Some(error) => Some(self.curves(&error, "error")?),
            None => None,
        };
        Ok(Desk { cell: edit, take, file, edited, solved, errors, anchored: self.found.anchored })
    }

    /// Has at hand what the nodes need that a key reaches, so that the first key waits no longer than the next.
    fn prepare(&mut self) {
        if std::mem::replace(&mut self.prepared, true) {
            return;
        }
        let plan = self.engine.plan();
        let mut reached = BTreeSet::new();
        for (at, node) in plan.nodes.iter().enumerate() {
            let keyed = edits_of(plan, at).is_some_and(|(pick, _)| plan.nodes[pick].path == self.found.pick);
            if keyed || node.inputs.iter().flat_map(|input| &input.sources).any(|source| reached.contains(&source.node))
            {
                reached.insert(at);
            }
        }
        let item = self.cell().and_then(|cell| Some(format!("@{}", cell.split_once('@')?.1))).unwrap_or_default();
        let names = reached.into_iter().map(|at| format!("{}{item}", plan.nodes[at].path));
        let cells: Vec<usize> = names.filter_map(|name| self.engine.look(&name).map(|cell| cell.id)).collect();
        for cell in cells {
            // What cannot be had now is told when it is needed.
            drop(self.engine.prepare(cell));
        }
    }

    fn curves(&mut self, cell: &str, port: &str) -> Result<Arc<Curves>, String> {
        let values = self.engine.values(cell, port).map_err(|problem| problem.to_string())?;
        let value = values.into_values().next().and_then(<dyn Value>::downcast_arc::<Curves>);
        value.ok_or_else(|| format!("`{cell}.{port}` is not the curves of one take"))
    }
}

/// The nodes that lay keys over the curves on the output `of`, over those which it comes from, or over those made of it.
fn find(plan: &Plan, of: &(String, String)) -> Result<Found, String> {
    let path = of.0.split_once('@').map_or(of.0.as_str(), |(path, _)| path);
    let start = plan.nodes.iter().position(|node| node.path == path);
    let start = start.ok_or_else(|| format!("there is no node `{path}` in the graph"))?;
    let is_curves =
        plan.nodes[start].card.outputs.iter().any(|port| port.name == of.1 && port.kind.name == Curves::NAME);
    if !is_curves {
        return Err(format!("`{path}.{}` gives no curves", of.1));
    }
    // Plan nodes stand after those they need, so one walk each way meets all.
    let takes = |node: &PlanNode, from: &BTreeSet<usize>| curve_sources(node).any(|source| from.contains(&source));
    let mut after = BTreeSet::from([start]);
    for (at, node) in plan.nodes.iter().enumerate().skip(start + 1) {
        if takes(node, &after) {
            after.insert(at);
        }
    }
    let mut before = BTreeSet::from([start]);
    for at in (0..=start).rev() {
        if before.contains(&at) {
            before.extend(curve_sources(&plan.nodes[at]));
        }
    }
    let edits = |at: &usize| Some((*at, edits_of(plan, *at)?));
    let last = after.iter().rev().find_map(edits).or_else(|| before.iter().rev().find_map(edits));
    let (edit, (pick, load)) = last.ok_or_else(|| {
        "no `edit_curves` of the graph lays keys over these curves that `load_edits` loads and `pick_edits` picks"
            .to_owned()
    })?;
    let measures = |node: &&PlanNode| {
        node.kind == "marker_error" && source(node, "curves") == Some(edit) && node.scope == plan.nodes[edit].scope
    };
    let anchors = |node: &PlanNode| node.kind == "set_anchors" && source(node, "edits") == Some(pick);
    let name = |at: usize| plan.nodes[at].path.clone();
    Ok(Found {
        edit: name(edit),
        pick: name(pick),
        load: name(load),
        error: plan.nodes.iter().find(measures).map(|node| node.path.clone()),
        anchored: plan.nodes.iter().any(anchors),
    })
}

/// The nodes whose curves a node takes.
fn curve_sources(node: &PlanNode) -> impl Iterator<Item = usize> + '_ {
    let inputs = node.inputs.iter().filter(|input| input.port.kind.name == Curves::NAME);
    inputs.flat_map(|input| &input.sources).map(|source| source.node)
}

/// The one node that an input is connected to.
fn source(node: &PlanNode, port: &str) -> Option<usize> {
    node.inputs.iter().find(|input| input.port.name == port)?.sources.first().map(|source| source.node)
}

/// The nodes that pick and load the edits of an `edit_curves`.
fn edits_of(plan: &Plan, at: usize) -> Option<(usize, usize)> {
    let of_kind = |at: usize, kind: &str| (plan.nodes[at].kind == kind).then_some(at);
    of_kind(at, "edit_curves")?;
    let pick = of_kind(source(&plan.nodes[at], "edits")?, "pick_edits")?;
    let load = of_kind(source(&plan.nodes[pick], "edits")?, "load_edits")?;
    Some((pick, load))
}

#[cfg(test)]
mod tests {
    use super::*;
    use graph_core::plan::load;

    #[test]
    fn the_last_keys_over_curves_are_found_from_wherever_the_curves_are() {
        let graph = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs/fdls/graph.ron");
        let plan = load(&graph, &[]).unwrap();
        let from = |cell: &str, port: &str| find(&plan, &(cell.to_owned(), port.to_owned()));
        let last = Found {
            edit: "solve/solve/edited".to_owned(),
            pick: "solve/own_edits".to_owned(),
            load: "edits".to_owned(),
            error: Some("solve/error".to_owned()),
            anchored: true,
        };
        for (cell, port) in [
            ("solve/solve/edited@take_00", "curves"),
            ("solve/solve/fine", "curves"),
            ("solve/solve/raw@take_00", "curves"),
            ("solve/solve/jaw_edit", "curves"),
            ("solve/solve/jaw", "jaw"),
            ("solve/error@take_00", "error"),
        ] {
            assert_eq!(from(cell, port), Ok(last.clone()), "{cell}.{port}");
        }
        assert!(from("actor", "truth").unwrap_err().contains("no `edit_curves`"));
        assert!(from("rig", "rig").unwrap_err().contains("gives no curves"));
        assert!(from("nobody", "curves").unwrap_err().contains("no node `nobody`"));
    }
}
