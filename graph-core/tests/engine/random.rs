//! Random graphs under random edits: after each, what is cooked is exactly what has to be, and every result is that of a
//! cook from nothing, bit for bit.
//!
//! `GRIMACE_CASES` sets how many graphs are tried.

use crate::model::{Dice, Model, Push};
use crate::oracle::{Expected, Oracle};
use crate::world::{Cooked, Project, VERSIONS, cook_at};
use graph_core::cook::{Engine, Event, Options, Session, Tell};
use graph_core::node::Node;
use graph_core::plan::load;
use graph_core::store::{OutputRecord, Store};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

/// A project that follows its model on disk.
struct Studio {
    project: Project,
    written: BTreeMap<String, String>,
}

impl Studio {
    fn new(model: &mut Model) -> Self {
        let mut studio = Self { project: Project::new(""), written: BTreeMap::new() };
        studio.follow(model);
        studio
    }

    /// Writes what differs, and what was touched.
    fn follow(&mut self, model: &mut Model) {
        let mut files = model.graphs();
        files.extend(model.files.clone());
        for name in self.written.keys().filter(|name| !files.contains_key(*name)) {
            std::fs::remove_file(self.project.path(name)).unwrap();
        }
        for (name, text) in &files {
            if self.written.get(name) != Some(text) || model.touched.contains(name) {
                self.project.write(name, text);
            }
        }
        model.touched.clear();
        VERSIONS.lock().unwrap().extend(model.versions.clone());
        self.written = files;
    }

    /// What the session in `store` knows of each cell: its key, and the content of its outputs.
    fn known(&self, store: &Arc<Store>) -> BTreeMap<String, (wire::Digest, Vec<(String, wire::Digest)>)> {
        let session = Session::load(store, &self.project.path("graph.ron"));
        let outputs = |outputs: &BTreeMap<String, OutputRecord>| {
            outputs.iter().map(|(name, record)| (name.clone(), record.digest())).collect()
        };
        session.cells.iter().map(|(name, cell)| (name.clone(), (cell.key, outputs(&cell.action.outputs)))).collect()
    }

    /// Every sound cell is known by the same key and content as after a cook from nothing.
    fn assert_equals_cold(&self, sound: &BTreeSet<String>, jobs: usize, block_frames: usize) {
        let cold = Arc::new(Store::at(&self.project.path(&format!("cold-{jobs}"))));
        let _ = std::fs::remove_dir_all(cold.root());
        let options = Options { jobs, block_frames, ..Options::default() };
        let out = self.outputs();
        cook_at(&self.project.path("graph.ron"), &cold, &options, &[]);
        assert_eq!(self.outputs(), out, "written files");
        let (mut warm, mut cold) = (self.known(&self.project.store()), self.known(&cold));
        warm.retain(|name, _| sound.contains(name));
        cold.retain(|name, _| sound.contains(name));
        assert_eq!(cold.keys().collect::<Vec<_>>(), sound.iter().collect::<Vec<_>>());
        for (name, cold) in cold {
            assert_eq!(warm.get(&name), Some(&cold), "{name} is not what a cook from nothing gives");
        }
    }

    /// The text of everything written.
    fn outputs(&self) -> BTreeMap<String, String> {
        let files = std::fs::read_dir(self.project.path("out")).into_iter().flatten().map(|file| file.unwrap().path());
        files
            .filter(|path| path.extension().is_some_and(|ending| ending == "txt"))
            .map(|path| path.file_name().unwrap().to_string_lossy().into_owned())
            .map(|name| (name.clone(), self.project.read(&format!("out/{name}"))))
            .collect()
    }
}

/// An engine that stays, and what it told since it was last asked.
pub struct Resident {
    pub engine: Engine,
    told: Arc<Mutex<Vec<Event>>>,
}

impl Resident {
    pub fn open(project: &Project, options: &Options) -> Self {
        let told = Arc::new(Mutex::new(Vec::new()));
        let events = Arc::clone(&told);
        let tell: Arc<Tell> = Arc::new(move |event| events.lock().unwrap().push(event));
        let plan = load(&project.path("graph.ron"), &[]).unwrap_or_else(|mistakes| panic!("{mistakes:#?}"));
        let options = Options { resident: true, ..options.clone() };
        let cancel = Arc::new(AtomicBool::new(false));
        let engine = Engine::new(plan, &[], project.store(), options, cancel, Some(tell)).unwrap();
        Self { engine, told }
    }

    pub fn cook(&mut self) -> Cooked {
        let summary = self.engine.cook().unwrap();
        self.engine.remember().unwrap();
        Cooked { events: std::mem::take(&mut self.told.lock().unwrap()), summary }
    }
}

/// Whether what was cooked is what had to be. Where cheap results are not kept, going back to an earlier state may cook again.
fn assert_cooked(expected: &Expected, cooked: &Cooked, keep_cheap: bool) {
    let done: BTreeMap<String, usize> = cooked.cooked().into_iter().collect();
    assert_eq!(done.len(), cooked.cooked().len(), "a cell was cooked twice");
    assert_eq!(cooked.summary.failed, expected.failed, "{:#?}", cooked.events);
    for (key, cells) in &expected.fresh {
        let one = cells.iter().any(|cell| done.contains_key(cell));
        assert!(one, "none of {cells:?} was cooked, and their result was never known: {key}");
    }
    let fresh: BTreeSet<&String> = expected.fresh.values().flatten().collect();
    for (name, blocks) in &done {
        let may = if keep_cheap { fresh.contains(name) } else { expected.changed.contains(name) };
        assert!(may, "{name} was cooked for nothing");
        let (fewest, most) = expected.blocks[name];
        assert!((fewest..=most).contains(blocks), "{name} cooked {blocks} blocks, and needed {fewest} to {most}");
    }
}

fn try_case(nodes: &[u64], edits: &[u64], way: u64) {
    let mut dice = Dice(way);
    let (resident, keep_cheap) = (dice.below(2) == 0, dice.below(4) > 0);
    let block_frames = [32, 7][dice.below(2)];
    let mut model = Model::new(nodes);
    let mut studio = Studio::new(&mut model);
    let mut options = Options { jobs: 2, block_frames, keep_cheap, ..Options::default() };
    let mut engine = resident.then(|| Resident::open(&studio.project, &options));
    let mut oracle = Oracle::default();
    for edit in std::iter::once(None).chain(edits.iter().map(Some)) {
        let push = edit.map(|edit| model.edit(&mut Dice(*edit)));
        studio.follow(&mut model);
        let (expected, cells) = oracle.expect(&model, block_frames);
        options.jobs = [1, 2, 8][dice.below(3)];
        let cooked = if let Some(standing) = &mut engine {
            match push {
                Some(Push::Exchange(id)) => {
                    let work = &model.nodes[&id].work;
                    let node = serde_json::json!({ work.kind(): work.json() });
                    let node: Box<dyn Node> = serde_json::from_value(node).unwrap();
                    standing.engine.exchange(&model.path(id), &node.into()).unwrap();
                }
                Some(Push::Rescan) => standing.engine.rescan(),
                Some(Push::Reload) => *standing = Resident::open(&studio.project, &options),
                None => {}
            }
            standing.cook()
        } else {
            cook_at(&studio.project.path("graph.ron"), &studio.project.store(), &options, &[])
        };
        let state = || format!("{}\nafter {push:?}", studio.written["graph.ron"]);
        let told = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            assert_cooked(&expected, &cooked, keep_cheap);
            studio.assert_equals_cold(&expected.sound, options.jobs, block_frames);
        }));
        assert!(told.is_ok(), "in this graph:\n{}\ncooked: {:?}\nresident: {resident}", state(), cooked.cooked());
        oracle.learn(cells, &cooked.names().into_iter().collect());
    }
    let (expected, _) = oracle.expect(&model, block_frames);
    for jobs in [1, 2, 8] {
        studio.assert_equals_cold(&expected.sound, jobs, block_frames);
    }
}

fn cases() -> u32 {
    std::env::var("GRIMACE_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(24)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), max_shrink_iters: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn edits_cook_exactly_what_they_touch_and_give_what_a_cook_from_nothing_gives(
        nodes in prop::collection::vec(any::<u64>(), 2..20),
        edits in prop::collection::vec(any::<u64>(), 1..12),
        way in any::<u64>(),
    ) {
        try_case(&nodes, &edits, way);
    }
}
