//! A graph at rest is known by one file; whatever a cook depends on wakes it.

use crate::world::Project;
use graph_core::cook::{BLOCK_FRAMES, Event, Options, Rest};
use graph_core::document::Override;
use std::fs;
use std::time::Duration;

const GRAPH: &str = r#"(
    grimace: 1,
    params: { "by": 3.0, "takes": "takes/*.txt" },
    nodes: {
        "takes": (kind: "read", with: (path: "${takes}")),
        "solve": (for_each: "takes", graph: "solve.ron", with: (by: "${by}")),
        "save":  (kind: "write", in: {"series": "solve.series"}, with: (path: "out/${ENV:CARGO_PKG_NAME}/{take}.txt")),
    },
)"#;

const SOLVE: &str = r#"(
    grimace: 1,
    params: { "by": 1.0 },
    inputs: { "take": "Series" },
    outputs: { "series": "scale" },
    nodes: { "scale": (kind: "scale", in: {"series": "take"}, with: (by: "${by}")) },
)"#;

fn find(project: &Project, set: &[&str], options: &Options) -> Option<Rest> {
    let overrides: Vec<Override> = set.iter().map(|text| Override::parse(text).unwrap()).collect();
    Rest::find(&project.store(), &project.path("graph.ron"), &overrides, options)
}

/// Longer than the coarsest clock of a file system: what is younger is read again, since it may change unseen.
fn let_files_age() {
    std::thread::sleep(Duration::from_millis(2_050));
}

fn project() -> Project {
    let project = Project::new(GRAPH);
    project.write("solve.ron", SOLVE);
    project.series("takes/a.txt", 40, |t| t as f64);
    project.series("takes/b.txt", 70, |t| (t * t) as f64);
    project
}

type Edit = fn(&Project);

/// Each wakes the graph.
const EDITS: [(&str, Edit); 9] = [
    ("the graph", |project| project.write("graph.ron", &GRAPH.replace("3.0", "4.0"))),
    ("a nested graph", |project| project.write("solve.ron", &SOLVE.replace("take\"})", "take\" })"))),
    ("a take, its size as before", |project| {
        project.series("takes/a.txt", 40, |t| if t == 3 { 4.0 } else { t as f64 });
    }),
    ("one more take", |project| project.series("takes/c.txt", 5, |t| t as f64)),
    ("a vanished take", |project| fs::remove_file(project.path("takes/b.txt")).unwrap()),
    ("a written file that vanished", |project| fs::remove_file(project.path("out/graph-core/a.txt")).unwrap()),
    ("a written file that was edited", |project| project.write("out/graph-core/a.txt", "mine")),
    ("a sidecar that vanished", |project| fs::remove_file(project.path("out/graph-core/a.txt.json")).unwrap()),
    ("a store without its sessions", |project| fs::remove_dir_all(project.path("store/sessions")).unwrap()),
];

#[test]
fn what_a_cook_depends_on_wakes_the_graph_and_nothing_else_does() {
    let projects: Vec<Project> = EDITS.iter().map(|_| project()).collect();
    for project in &projects {
        project.cook();
        assert!(find(project, &[], &project.options).is_none(), "files this young may change unseen");
    }
    let_files_age();
    for (project, (name, edit)) in projects.iter().zip(EDITS) {
        let again = project.cook();
        assert_eq!((again.summary.cooked, again.summary.written), (0, 0), "{name}: {:#?}", again.events);
        let rest = find(project, &[], &project.options).unwrap_or_else(|| panic!("before {name}"));
        let mut told = Vec::new();
        let seen = std::sync::Mutex::new(&mut told);
        let summary = rest.tell(&|event| seen.lock().unwrap().push(event));
        let cached = |events: &[Event]| {
            let mut cells: Vec<_> =
                events.iter().filter(|event| matches!(event, Event::Cached { .. })).cloned().collect();
            cells.sort_by_key(|event| format!("{event:?}"));
            cells
        };
        assert_eq!(cached(&told), cached(&again.events));
        assert_eq!((summary.cached, summary.blocks_cached), (again.summary.cached, again.summary.blocks_cached));
        assert!(find(project, &["by=4"], &project.options).is_none());
        assert!(find(project, &[], &Options { only: vec!["takes".into()], ..project.options.clone() }).is_none());
        assert!(find(project, &[], &Options { block_frames: BLOCK_FRAMES + 1, ..project.options.clone() }).is_none());
        assert!(find(project, &[], &Options { jobs: 7, ..project.options.clone() }).is_some());
        edit(project);
        assert!(find(project, &[], &project.options).is_none(), "{name} wakes it");
    }
}

#[test]
fn a_file_that_could_not_be_written_is_written_in_the_next_cook() {
    let project = project();
    project.cook();
    let_files_age();
    // A folder stands where the new file is made before it is renamed; the old one stays as it is.
    let made = project.path(&format!("out/graph-core/.a.txt.{}.part", std::process::id()));
    fs::create_dir(&made).unwrap();
    let failed = project.cook_with(&["by=5"]);
    assert_eq!(failed.summary.failed, 1, "{:#?}", failed.events);
    fs::remove_dir(&made).unwrap();
    assert!(find(&project, &["by=5"], &project.options).is_none());
    assert_eq!(project.cook_with(&["by=5"]).summary.failed, 0);
    assert!(project.read("out/graph-core/a.txt").starts_with("0\n5\n10\n"));
}

#[test]
fn a_cook_that_has_something_to_tell_tells_it_again() {
    let failing = project();
    failing.write("takes/a.txt", "no number\n");
    let empty = project();
    empty.write("graph.ron", &GRAPH.replace("takes/*.txt", "nowhere/*.txt"));
    let_files_age();
    for project in [&failing, &empty] {
        project.cook();
        assert!(find(project, &[], &project.options).is_none());
    }
}
