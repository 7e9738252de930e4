//! What is in a key and what is not, as a user meets it: folders, stores, hosts and settings change none; the content of
//! source files changes it, however quickly and quietly they were edited.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use whole_system::{Project, Run};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

const GRAPH: &str = r#"(
    grimace: 1,
    params: { "out": "out" },
    nodes: {
        "actor": (kind: "sample_actor", with: (density: 0.5, rom_frames: 600, takes: 1, frames: 60)),
        "rig":   (kind: "skin_jaw", in: {"rig": "actor.rig"}),
        "takes": (kind: "load_curves", with: (path: "takes/*.csv")),
        "calm":  (graph: "calm.ron", in: {"curves": "takes"}),
        "save":  (kind: "save_curves", in: {"curves": "calm"}, with: (path: "${out}/{take}.csv")),
        "truth": (kind: "save_curves", in: {"curves": "actor.truth"}, with: (path: "${out}/{take}.truth.csv")),
    },
)"#;

const CALM: &str = r#"(
    grimace: 1,
    inputs: { "curves": "Curves" },
    outputs: { "curves": "calm" },
    nodes: { "calm": (kind: "smooth_curves", in: {"curves": "curves"}) },
)"#;

/// Arguments, and variables of the environment.
type Settings<'a> = (&'a [&'a str], &'a [(&'a str, &'a str)]);

/// Cells of the graph with two takes.
const CELLS: u64 = 2 + 2 * 3 + 1;

fn project() -> Project {
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    project.write("calm.ron", CALM);
    take(&project, "a", "0.5");
    take(&project, "b", "0.7");
    project
}

fn take(project: &Project, name: &str, weight: &str) {
    let frames: Vec<String> = (0..100).map(|frame| format!("{frame},{weight},{}\n", frame % 3)).collect();
    let frames = frames.concat();
    project.write(&format!("takes/{name}.csv"), format!("# rate_hz: 60\nframe,jawOpen,mouthSmile_L\n{frames}"));
}

fn cook(project: &Project) -> Run {
    project.run(&["run", "graph.ron", "--json"]).ended_with(0)
}

/// The keys of all written files, as their sidecars tell them.
fn keys(folder: &Path) -> BTreeMap<String, Value> {
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let sidecars = files.filter(|path| path.extension().is_some_and(|ending| ending == "json"));
    sidecars
        .map(|path| {
            let sidecar: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
            assert!(sidecar["key"].is_string(), "{sidecar}");
            (path.file_name().unwrap().to_string_lossy().into_owned(), sidecar["key"].clone())
        })
        .collect()
}

#[test]
fn a_project_in_another_folder_recooks_nothing() {
    let project = project();
    assert_eq!(cook(&project).summary("cooked"), CELLS);
    let copy = Project::new(PROGRAM);
    copy.copy(&project.path("."), "a folder/with another name");
    let graph = "a folder/with another name/graph.ron";
    let store = copy.path("a folder/with another name/.grimace");
    let run = Run::of(copy.command().args(["run", graph, "--json"]).env("GRIMACE_STORE", &store)).ended_with(0);
    assert_eq!((run.summary("cooked"), run.summary("cached"), run.summary("written")), (0, CELLS, 0));
    // The store alone goes along: the session of another path is not found, what it was dear to make is.
    let other = Project::new(PROGRAM);
    for name in ["graph.ron", "calm.ron", "takes"] {
        other.copy(&project.path(name), &format!("elsewhere/{name}"));
    }
    other.copy(&project.path(".grimace"), "store");
    let run = other.run(&["run", "elsewhere", "--store", "store", "--json"]).ended_with(0);
    let cooked: Vec<String> = run.cooked().into_iter().map(|(name, _)| name).collect();
    assert!(!cooked.iter().any(|name| name == "actor" || name == "rig"), "{cooked:?}");
    assert_eq!(keys(&other.path("elsewhere/out")), keys(&project.path("out")));
}

#[test]
fn no_setting_changes_a_key() {
    let project = project();
    cook(&project);
    let truth = keys(&project.path("out"));
    assert_eq!(truth.len(), 3, "{truth:?}");
    let settings: [Settings<'_>; 8] = [
        (&["--jobs", "1"], &[]),
        (&["--jobs", "7", "--verbose"], &[]),
        (&["--log", "trace", "--log-file", "log.jsonl"], &[]),
        (&["--profile", "profile.json"], &[]),
        (&["--memory", "1GB"], &[]),
        (
            &[],
            &[
                ("HOSTNAME", "farm-07"),
                ("HOST", "farm-07"),
                ("USER", "nobody"),
                ("LANG", "de_DE.UTF-8"),
                ("TZ", "Asia/Tokyo"),
            ],
        ),
        (&["--color", "always"], &[("GRIMACE_LOG", "debug"), ("RAYON_NUM_THREADS", "3"), ("RUST_LOG", "trace")]),
        (&["--set", "calm.calm.channels=[]"], &[("TMPDIR", "/var/tmp")]),
    ];
    for (arguments, environment) in settings {
        let run = |more: &[&str]| {
            let mut command = project.command();
            command.args(["run", "graph.ron", "--json"]).args(arguments).args(more);
            Run::of(command.envs(environment.iter().copied())).ended_with(0)
        };
        // A graph at rest would not even be asked for its keys.
        let _ = fs::remove_dir_all(project.path(".grimace/rests"));
        let same = run(&[]);
        assert_eq!((same.summary("cooked"), same.summary("written")), (0, 0), "{arguments:?} {environment:?}");
        let fresh = run(&["--store", "another", "--out", "again"]);
        assert_eq!(fresh.summary("cooked"), CELLS, "{arguments:?} {environment:?}");
        assert_eq!(keys(&project.path("again")), truth, "{arguments:?} {environment:?}");
        fs::remove_dir_all(project.path("another")).unwrap();
        fs::remove_dir_all(project.path("again")).unwrap();
    }
    // Where files go is no part of a key either.
    let moved = project.run(&["run", "graph.ron", "--out", "moved", "--json"]).ended_with(0);
    assert_eq!((moved.summary("cooked"), moved.summary("written")), (0, 3));
    assert_eq!(keys(&project.path("moved")), truth);
}

#[test]
fn an_edit_of_the_same_size_in_the_same_second_is_noticed() {
    let project = project();
    cook(&project);
    for weight in ["0.6", "0.7", "0.8", "0.9"] {
        take(&project, "a", weight);
        let run = cook(&project);
        let cooked: Vec<String> = run.cooked().into_iter().map(|(name, _)| name).collect();
        assert!(cooked.contains(&"takes@a".to_owned()) || weight == "0.7", "{weight}: {cooked:?}");
        assert!(cooked.iter().all(|name| name.ends_with("@a")), "{cooked:?}");
        assert!(project.read("out/a.csv").contains(weight), "{weight}");
    }
    // Even where the time of the edit is set back to what it was.
    let path = project.path("takes/a.csv");
    let old = File::open(&path).unwrap().metadata().unwrap().modified().unwrap();
    let text = fs::read_to_string(&path).unwrap().replace("0.9", "0.3");
    fs::write(&path, text).unwrap();
    File::options().append(true).open(&path).unwrap().set_modified(old).unwrap();
    assert!(cook(&project).cooked().iter().any(|(name, _)| name == "takes@a"));
    assert!(project.read("out/a.csv").contains("0.3"));
}

#[test]
fn a_touched_file_and_one_written_anew_with_the_same_content_recook_nothing() {
    let project = project();
    cook(&project);
    let path = project.path("takes/a.csv");
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(100);
    File::options().append(true).open(&path).unwrap().set_modified(later).unwrap();
    assert_eq!(cook(&project).summary("cooked"), 0);
    let bytes = fs::read(&path).unwrap();
    fs::remove_file(&path).unwrap();
    fs::write(project.path("takes/new"), bytes).unwrap();
    fs::rename(project.path("takes/new"), &path).unwrap();
    let run = cook(&project);
    assert_eq!((run.summary("cooked"), run.summary("cached"), run.summary("written")), (0, CELLS, 0));
}
