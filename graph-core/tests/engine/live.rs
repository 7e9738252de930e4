//! Takes that change under a cook of a watch: they leave until they have arrived again, and fail nothing. What changes while
//! long computations run does not wait for them.

use crate::cook::takes;
use crate::world::Project;
use graph_core::cook::{Change, Engine, Event, Summary};
use graph_core::files::{Gate, Signature};
use graph_core::plan::load;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

/// A gate that lets in the takes of `project` as they are now.
fn open_to(project: &Project, gate: &Gate, names: &[&str]) {
    let paths = names.iter().map(|name| project.path(&format!("takes/{name}.txt")));
    gate.open_to(paths.map(|path| (path.clone(), Signature::of(&path).unwrap())).collect());
}

/// Cooks `takes` with both let in, while `meddle` sees each event before the engine goes on.
fn meddled(
    jobs: usize,
    meddle: impl Fn(&Project, &Event) + Send + Sync + 'static,
) -> (Arc<Project>, Summary, Vec<Event>) {
    let mut project = takes();
    let gate = Arc::new(Gate::default());
    open_to(&project, &gate, &["a", "b"]);
    project.options.gate = Some(gate);
    (project.options.resident, project.options.jobs) = (true, jobs);
    let project = Arc::new(project);
    let events = Arc::new(Mutex::new(Vec::new()));
    let (told, at) = (Arc::clone(&events), Arc::clone(&project));
    let tell = move |event: Event| {
        meddle(&at, &event);
        told.lock().unwrap().push(event);
    };
    let plan = load(&project.path("graph.ron"), &[]).unwrap();
    let options = project.options.clone();
    let mut engine = Engine::new(plan, &[], project.store(), options, Arc::default(), Some(Arc::new(tell))).unwrap();
    let summary = engine.cook().unwrap();
    drop(engine);
    let events = events.lock().unwrap().clone();
    (project, summary, events)
}

/// Only the first take was cooked, and nothing failed.
fn only_a(project: &Project, summary: &Summary, events: &[Event]) {
    assert_eq!((summary.failed, summary.skipped), (0, 0), "{events:#?}");
    assert!(!events.iter().any(|event| matches!(event, Event::Failed { .. } | Event::Skipped { .. })), "{events:#?}");
    assert!(project.path("out/a.txt").exists() && !project.path("out/b.txt").exists());
    let names = events.iter().filter_map(|event| match event {
        Event::Cooked { node, .. } => Some(node.as_str()),
        _ => None,
    });
    let names: Vec<_> = names.collect();
    let distinct: BTreeSet<_> = names.iter().collect();
    assert_eq!(distinct.len(), names.len(), "{names:?}");
    assert_eq!(names.len(), 5, "{names:?}");
}

#[test]
fn a_take_that_vanishes_between_listing_and_reading_leaves() {
    for jobs in [1, 2] {
        let (project, summary, events) = meddled(jobs, |project, event| {
            if matches!(event, Event::Planned { .. }) {
                let _ = std::fs::remove_file(project.path("takes/b.txt"));
            }
        });
        only_a(&project, &summary, &events);
    }
}

#[test]
fn a_take_that_vanishes_or_is_written_again_as_its_job_begins_leaves() {
    let is_b = |event: &Event| matches!(event, Event::Started { node, .. } if node == "takes@b");
    for jobs in [1, 2] {
        let (project, summary, events) = meddled(jobs, move |project, event| {
            if is_b(event) {
                std::fs::remove_file(project.path("takes/b.txt")).unwrap();
            }
        });
        only_a(&project, &summary, &events);
        let (project, summary, events) = meddled(jobs, move |project, event| {
            if is_b(event) {
                project.write("takes/b.txt", "1\n2\n");
            }
        });
        only_a(&project, &summary, &events);
    }
}

#[test]
fn a_take_that_is_no_take_fails_and_one_that_comes_meanwhile_is_cooked() {
    let mut project = takes();
    project.write("takes/b.txt", "no number\n");
    let gate = Arc::new(Gate::default());
    open_to(&project, &gate, &["a", "b"]);
    (project.options.gate, project.options.resident) = (Some(Arc::clone(&gate)), true);
    let plan = load(&project.path("graph.ron"), &[]).unwrap();
    let options = project.options.clone();
    let mut engine = Engine::new(plan, &[], project.store(), options, Arc::default(), None).unwrap();
    let changes = engine.changes();
    assert_eq!(engine.cook().unwrap().failed, 1);
    project.series("takes/c.txt", 40, |t| t as f64);
    open_to(&project, &gate, &["a", "b", "c"]);
    changes.tell(Change::Files);
    let summary = engine.cook().unwrap();
    assert_eq!((summary.failed, engine.changes_taken()), (1, 1));
    assert!(project.path("out/c.txt").exists());
    project.series("takes/b.txt", 70, |t| t as f64);
    changes.tell(Change::Files);
    // Not let in so far: there is no such take.
    assert_eq!(engine.cook().unwrap().failed, 0);
    assert!(!project.path("out/b.txt").exists());
    open_to(&project, &gate, &["a", "b", "c"]);
    changes.tell(Change::Files);
    assert_eq!(engine.cook().unwrap().failed, 0);
    assert!(project.path("out/b.txt").exists());
}
