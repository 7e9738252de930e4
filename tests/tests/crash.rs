//! Cooks that end before they are done: killed at any moment, or cancelled. The next cook needs no help, goes on where the last
//! one was, and ends in the same bits.
//!
//! `GRIMACE_KILLS` sets how many cooks are killed. (What damage, full disks, read-only disks, leases and many processes at once
//! do to the store is tested in `cli/tests/store`.)
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use whole_system::Project;

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

/// A take solved by networks that are trained for it; checkpoints are written as often as can be.
const GRAPH: &str = r#"(
    grimace: 1,
    params: { "epochs": 12 },
    nodes: {
        "actor":    (kind: "sample_actor", with: (density: 0.5, rom_frames: 600, takes: 2, frames: 90)),
        "attach":   (kind: "attach_markers", in: {"rig": "actor.rig", "neutral": "actor.neutral"}),
        "sweep":    (kind: "facs_sweep", in: {"rig": "actor.rig"}),
        "posed":    (kind: "synthesize_markers", in: {"rig": "actor.rig", "attachment": "attach", "curves": "sweep"}),
        "jitter":   (kind: "add_jitter", in: {"markers": "posed", "curves": "sweep"}),
        "learned":  (kind: "graph_features", in: {"markers": "jitter.markers", "neutral": "actor.neutral", "regions": "actor.regions"}),
        "train":    (
            kind: "train_regions",
            in: {"features": "learned", "curves": "jitter.curves", "regions": "actor.regions"},
            with: (epochs: "${epochs}", width: 16, blocks: 1, checkpoint_s: 0.05),
        ),
        "features": (kind: "graph_features", in: {"markers": "actor.takes", "neutral": "actor.neutral", "regions": "actor.regions"}),
        "jaw":      (kind: "solve_jaw", in: {"features": "features", "networks": "train"}),
        "raw":      (kind: "solve_regions", in: {"features": "features", "networks": "train", "jaw": "jaw"}),
        "save":     (kind: "save_curves", in: {"curves": "raw"}, with: (path: "out/{take}.csv")),
    },
)"#;

fn project() -> Project {
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    project
}

/// What was written.
fn written(project: &Project) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(project.path("out")).unwrap().map(|file| file.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|ending| ending == "csv"));
    files.map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap())).collect()
}

fn forget(project: &Project) {
    for folder in [".grimace", "out"] {
        if project.path(folder).exists() {
            fs::remove_dir_all(project.path(folder)).unwrap();
        }
    }
}

fn start(project: &Project, arguments: &[&str]) -> Child {
    let mut command = project.command();
    command.args(["run", "graph.ron", "--json"]).args(arguments);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap()
}

/// The numbers of a generator (`SplitMix64`), between 0 and 1.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (mixed ^ (mixed >> 31)) as f64 / u64::MAX as f64
}

#[test]
fn a_killed_cook_leaves_nothing_to_mend() {
    let kills: usize = std::env::var("GRIMACE_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(8);
    let project = project();
    let since = Instant::now();
    project.run(&["run", "graph.ron"]).ended_with(0);
    let whole = since.elapsed();
    let truth = written(&project);
    assert_eq!(truth.len(), 2);
    forget(&project);
    let (mut state, mut killed, mut rounds) = (7, 0, 0);
    while killed < kills {
        // Up to four kills on the way to one result; a cook may get done before it is killed.
        for _ in 0..=(random(&mut state) * 4.0) as usize {
            let mut child = start(&project, &["--jobs", if random(&mut state) < 0.5 { "1" } else { "2" }]);
            std::thread::sleep(whole.mul_f64(random(&mut state)));
            killed += usize::from(child.try_wait().unwrap().is_none());
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let next = project.run(&["run", "graph.ron", "--json"]).ended_with(0);
        assert_eq!((next.summary("failed"), next.events_of("notice")), (0, Vec::new()), "after {killed} kills");
        assert_eq!(written(&project), truth, "after {killed} kills");
        let again = project.run(&["run", "graph.ron", "--json"]).ended_with(0);
        assert_eq!((again.summary("cooked"), again.summary("written")), (0, 0), "after {killed} kills");
        project.run(&["cache", "verify"]).ended_with(0);
        project.run(&["cache", "gc", "--keep", "100GB"]).ended_with(0);
        for folder in ["temporary", "leases"] {
            let left = fs::read_dir(project.path(".grimace").join(folder)).into_iter().flatten().count();
            assert_eq!(left, 0, "{folder} after {killed} kills");
        }
        rounds += 1;
        // Half of the rounds begin from nothing; the others train anew over a store that holds the rest.
        if rounds % 2 == 0 {
            forget(&project);
        } else {
            for part in ["actions", "packs", "sessions"] {
                fs::remove_dir_all(project.path(".grimace").join(part)).unwrap();
            }
            fs::remove_dir_all(project.path("out")).unwrap();
        }
    }
}

/// Reads events until `train` is at least so far; that fraction.
fn until(events: &mut impl Iterator<Item = Value>, fraction: f64) -> f64 {
    let far = events.find_map(|event| {
        let own = event["event"] == "progress" && event["node"] == "train";
        event["fraction"].as_f64().filter(|far| own && *far >= fraction)
    });
    far.unwrap_or_else(|| panic!("the training never came to {fraction}"))
}

fn events(child: &mut Child) -> impl Iterator<Item = Value> + use<> {
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    lines.map(|line| serde_json::from_str(&line.unwrap()).unwrap())
}

/// Epochs that take minutes.
const LONG: [&str; 2] = ["--set", "epochs=20000"];

#[test]
fn a_killed_training_goes_on_from_its_checkpoint() {
    let project = project();
    let mut reached = 0.0;
    for wanted in [0.004, 0.008, 0.012] {
        let mut child = start(&project, &LONG);
        let mut told = events(&mut child);
        // Regions tell one after the other how far they are; a few epochs of minutes of training are nothing beside it.
        let first = (0..40).map(|_| until(&mut told, 0.0)).fold(0.0, f64::max);
        // Checkpoints are written every twentieth of a second, so that at most a little is lost.
        assert!(first >= reached * 0.5, "it began at {first} after it had come to {reached}");
        reached = until(&mut told, wanted);
        child.kill().unwrap();
        child.wait().unwrap();
    }
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn one_signal_reaches_a_training_and_two_leave_at_once() {
    let project = project();
    let mut fastest = Duration::MAX;
    for _ in 0..3 {
        let mut child = start(&project, &LONG);
        let mut told = events(&mut child);
        until(&mut told, 0.0);
        let since = Instant::now();
        interrupt(&child);
        let last = told.last().unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130));
        fastest = fastest.min(since.elapsed());
        assert_eq!((&last["event"], &last["cancelled"]), (&"summary".into(), &true.into()));
    }
    // A node hears of it within 200 ms; what was cooked is then remembered. The machine may be busy, so the best of three counts.
    assert!(fastest < Duration::from_millis(300), "it took {fastest:?} from the signal to the end");

    let mut child = start(&project, &LONG);
    let mut told = events(&mut child);
    until(&mut told, 0.0);
    let since = Instant::now();
    interrupt(&child);
    let _ = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    told.for_each(drop);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(since.elapsed() < Duration::from_secs(1), "leaving took {:?}", since.elapsed());
}
