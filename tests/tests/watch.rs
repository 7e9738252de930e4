//! The watch, through the program: takes that come in any order and at any speed, come again, and go. What it ends with is what
//! `grimace run` makes of the same files; nothing half-written was cooked on the way, and nothing twice.
//!
//! `GRIMACE_WATCH_TAKES` sets how many takes come, `GRIMACE_WATCH_SEED` how.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::Write;
use std::time::Duration;
use whole_system::{Project, Watch};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

const GRAPH: &str = r#"(
    grimace: 1,
    params: { "sigma": 1.5 },
    nodes: {
        "takes": (kind: "load_curves", with: (path: "takes/*.csv")),
        "calm":  (kind: "smooth_curves", in: {"curves": "takes"}, with: (filter: gaussian(sigma_frames: "${sigma}"))),
        "save":  (kind: "save_curves", in: {"curves": "calm"}, with: (path: "out/{take}.csv")),
    },
)"#;

/// A network that takes long to train, beside takes that do not need it.
const TRAINING: &str = r#"
        "actor":   (kind: "sample_actor", with: (density: 0.5, rom_frames: 600, takes: 1, frames: 60)),
        "attach":  (kind: "attach_markers", in: {"rig": "actor.rig", "neutral": "actor.neutral"}),
        "sweep":   (kind: "facs_sweep", in: {"rig": "actor.rig"}),
        "posed":   (kind: "synthesize_markers", in: {"rig": "actor.rig", "attachment": "attach", "curves": "sweep"}),
        "jitter":  (kind: "add_jitter", in: {"markers": "posed", "curves": "sweep"}),
        "learned": (kind: "graph_features", in: {"markers": "jitter.markers", "neutral": "actor.neutral", "regions": "actor.regions"}),
        "train":   (
            kind: "train_regions",
            in: {"features": "learned", "curves": "jitter.curves", "regions": "actor.regions"},
            with: (epochs: 100000, width: 16, blocks: 1),
        ),
"#;

/// A take of so many frames, which no other take of its name has.
fn take(frames: usize) -> String {
    let mut text = "# rate_hz: 60\nframe,jawOpen,smile\n".to_owned();
    for frame in 0..frames {
        writeln!(text, "{frame},0.{:03},0.5", (frame * 37 + frames) % 1000).unwrap();
    }
    text
}

/// The frames of each computation of a cell, in order: `2 channels, 40 frames at 60 Hz`.
fn cooked(events: &[Value], node: &str) -> Vec<usize> {
    let own = events.iter().filter(|event| event["event"] == "cooked" && event["node"] == node);
    own.map(|event| {
        let line = event["outputs"]["curves"].as_str().unwrap();
        line.split(", ").find_map(|part| part.split_once(" frames")).unwrap().0.parse().unwrap()
    })
    .collect()
}

fn written(project: &Project, folder: &str) -> BTreeMap<String, String> {
    let files = fs::read_dir(project.path(folder)).unwrap().map(|file| file.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|ending| ending == "csv"));
    files
        .map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), fs::read_to_string(&path).unwrap()))
        .collect()
}

/// What a cook from nothing makes of the same files.
fn truth(project: &Project) -> BTreeMap<String, String> {
    let fresh = Project::new(PROGRAM);
    fresh.copy(&project.path("takes"), "takes");
    fresh.write("graph.ron", project.read("graph.ron"));
    fresh.run(&["run", "graph.ron"]).ended_with(0);
    written(&fresh, "out")
}

/// The numbers of a generator (`SplitMix64`).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ (mixed >> 31)
}

/// Writes `text` in pieces, with pauses that are shorter than the settle time.
fn write_slowly(project: &Project, name: &str, text: &str, pieces: usize) {
    let mut file = File::create(project.path(name)).unwrap();
    for piece in text.as_bytes().chunks(text.len().div_ceil(pieces)) {
        file.write_all(piece).unwrap();
        std::thread::sleep(Duration::from_millis(40));
    }
}

#[test]
fn takes_that_come_in_any_way_end_in_the_right_outputs() {
    let takes: usize = std::env::var("GRIMACE_WATCH_TAKES").ok().and_then(|text| text.parse().ok()).unwrap_or(200);
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    fs::create_dir_all(project.path("takes")).unwrap();
    // Longer than any pause of those who write, on a machine that has other things to do, too.
    let mut watch = Watch::start(&project, &["--settle", "0.6"]);
    watch.until_waiting_for(0);
    let seed = std::env::var("GRIMACE_WATCH_SEED").ok().and_then(|text| text.parse().ok());
    let (mut state, mut frames) = (seed.unwrap_or(11), 40);
    // Complete contents of each take, by their frames. Some may be replaced before they were cooked.
    let mut complete: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let mut gone = BTreeSet::new();
    let mut threads = Vec::new();
    let project = std::sync::Arc::new(project);
    for index in 0..takes {
        let name = format!("take_{index:03}");
        let mut fresh = || {
            frames += 1;
            complete.entry(name.clone()).or_default().push(frames);
            take(frames)
        };
        let file = format!("takes/{name}.csv");
        match random(&mut state) % 8 {
            0 => {
                // A slow copy.
                let (text, project) = (fresh(), std::sync::Arc::clone(&project));
                threads.push(std::thread::spawn(move || write_slowly(&project, &file, &text, 12)));
            }
            1 => {
                // Renamed into place.
                project.write("part", fresh());
                fs::rename(project.path("part"), project.path(&file)).unwrap();
            }
            2 => {
                // Cut short, and completed later.
                let text = fresh();
                project.write(&file, &text[..text.len() / 2]);
                let project = std::sync::Arc::clone(&project);
                threads.push(std::thread::spawn(move || {
                    std::thread::sleep(Duration::from_millis(150));
                    project.write(&file, &text);
                }));
            }
            3 => {
                // Edited within the second.
                project.write(&file, fresh());
                project.write(&file, fresh());
            }
            4 => {
                // Gone again: before it is complete, or about then, or after.
                project.write(&file, fresh());
                let project = std::sync::Arc::clone(&project);
                gone.insert(name);
                let wait = Duration::from_millis(200 + random(&mut state) % 800);
                threads.push(std::thread::spawn(move || {
                    std::thread::sleep(wait);
                    fs::remove_file(project.path(&file)).unwrap();
                }));
            }
            5 => {
                // Another one renamed into its place, about when the first is complete.
                project.write(&file, fresh());
                let (text, project) = (fresh(), std::sync::Arc::clone(&project));
                let wait = Duration::from_millis(400 + random(&mut state) % 400);
                threads.push(std::thread::spawn(move || {
                    std::thread::sleep(wait);
                    let part = format!("part_{index}");
                    project.write(&part, text);
                    fs::rename(project.path(&part), project.path(&file)).unwrap();
                }));
            }
            _ => project.write(&file, fresh()),
        }
        std::thread::sleep(Duration::from_millis(random(&mut state) % 60));
    }
    for thread in threads {
        thread.join().unwrap();
    }
    watch.until_waiting_for(takes - gone.len());
    // A burst, one of them with what another holds.
    for index in 0..50 {
        project.write(&format!("takes/burst_{index:02}.csv"), take(500 + index.min(48)));
    }
    // The same content written again.
    let again = complete.keys().find(|name| !gone.contains(*name)).unwrap().clone();
    let same = project.read(&format!("takes/{again}.csv"));
    project.write(&format!("takes/{again}.csv"), same);
    watch.until_waiting_for(takes - gone.len() + 50);
    let events = watch.stop(0);

    let mut made = written(&project, "out");
    made.retain(|name, _| !gone.contains(name));
    assert_eq!(made, truth(&project));
    for (name, allowed) in &complete {
        let loaded = cooked(&events, &format!("takes@{name}"));
        let distinct: BTreeSet<_> = loaded.iter().collect();
        assert_eq!(distinct.len(), loaded.len(), "{name} was cooked twice: {loaded:?}");
        assert!(loaded.iter().all(|frames| allowed.contains(frames)), "{name}: {loaded:?}, complete were {allowed:?}");
        assert!(gone.contains(name) || loaded.last() == allowed.last(), "{name}: {loaded:?}");
        // One that was replaced meanwhile may have been stale before it went on.
        let calmed = cooked(&events, &format!("calm@{name}"));
        let mut rest = loaded.iter();
        assert!(calmed.iter().all(|frames| rest.any(|one| one == frames)), "{name}: {calmed:?} of {loaded:?}");
        assert!(gone.contains(name) || calmed.last() == loaded.last(), "{name}: {calmed:?} of {loaded:?}");
    }
    let failed: Vec<_> = events.iter().filter(|event| event["event"] == "failed").collect();
    assert!(failed.is_empty(), "{failed:#?}");
    // Each cook ends in its summary, and each waiting comes after one.
    let ends = events.iter().filter(|event| event["event"] == "summary").count();
    assert!(ends >= events.iter().filter(|event| event["event"] == "waiting").count());
}

#[test]
fn it_outlives_broken_graphs_corrupt_takes_and_lost_folders() {
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    project.write("takes/a.csv", take(40));
    let mut watch = Watch::start(&project, &[]);
    watch.until_waiting_for(1);
    // A take that is none: it fails alone.
    project.write("takes/b.csv", "frame,jawOpen\n0,wide\n");
    project.write("takes/c.csv", take(42));
    let failed = watch.until("failure", |event| event["event"] == "failed");
    assert_eq!(failed["node"], "takes@b");
    watch.until_waiting_for(3);
    assert_eq!(written(&project, "out").len(), 2);
    project.write("takes/b.csv", take(41));
    watch.until("cooked b", |event| event["event"] == "wrote" && event["node"] == "save@b");
    // A graph that is wrong: what was made stays, and a take that comes is cooked by the last good one.
    watch.until_waiting_for(3);
    project.write("graph.ron", GRAPH.replace("smooth_curves", "smooth_curve"));
    watch.until("diagnostic", |event| event["event"] == "diagnostic" && event["code"] == "unknown-kind");
    project.write("takes/d.csv", take(43));
    watch.until("cooked d", |event| event["event"] == "wrote" && event["node"] == "save@d");
    // Mended, with another parameter.
    project.write("graph.ron", GRAPH.replace("\"sigma\": 1.5", "\"sigma\": 2.5"));
    watch.until("the edit", |event| event["event"] == "wrote" && event["node"] == "save@a");
    watch.until_waiting_for(4);
    assert_eq!(written(&project, "out"), truth(&project));
    // The folder goes, and comes again.
    fs::remove_dir_all(project.path("takes")).unwrap();
    watch.until_waiting_for(0);
    project.write("takes/e.csv", take(44));
    watch.until("cooked e", |event| event["event"] == "wrote" && event["node"] == "save@e");
    watch.signal("HUP");
    watch.until("rescan", |event| event["event"] == "rescan" && event["because"].as_str().unwrap().contains("SIGHUP"));
    watch.until_waiting_for(1);
    watch.stop(0);
}

/// A graph that takes cook through another one, measured against a file that is no take.
const NESTING: &str = r#"(
    grimace: 1,
    nodes: {
        "truth": (kind: "load_curves", with: (path: "truth.csv")),
        "takes": (kind: "load_curves", with: (path: "takes/*.csv")),
        "calm":  (for_each: "takes", graph: "calm.ron"),
        "score": (kind: "curve_error", in: {"curves": "calm.curves", "truth": "truth"}),
        "save":  (kind: "save_curves", in: {"curves": "calm.curves"}, with: (path: "out/{take}.csv")),
    },
)"#;

const NESTED: &str = r#"(
    grimace: 1,
    inputs: { "take": "Curves" },
    outputs: { "curves": "smooth" },
    nodes: {
        "smooth": (kind: "smooth_curves", in: {"curves": "take"}, with: (filter: gaussian(sigma_frames: 1.5))),
    },
)"#;

#[test]
fn edits_of_nested_graphs_and_of_files_that_are_no_takes_are_taken() {
    let project = Project::new(PROGRAM);
    for (file, text) in [("graph.ron", NESTING), ("calm.ron", NESTED), ("truth.csv", &take(40))] {
        project.write(file, text);
    }
    project.write("takes/a.csv", take(40));
    project.write("takes/b.csv", take(40).replace("0.5", "0.75"));
    let mut watch = Watch::start(&project, &[]);
    let nodes = |events: &[Value]| -> Vec<String> {
        let mut nodes: Vec<String> = events
            .iter()
            .filter(|event| event["event"] == "cooked")
            .map(|event| event["node"].as_str().unwrap().to_owned())
            .collect();
        nodes.sort();
        nodes
    };
    // `truth` counts as a file, too.
    watch.until_waiting_for(3);
    let first = written(&project, "out");
    watch.events.clear();
    project.write("truth.csv", take(40).replace("0.5", "0.25"));
    watch.until("the asset", |event| event["event"] == "summary" && event["cooked"] != 0);
    watch.until_waiting_for(3);
    assert_eq!(nodes(&watch.events), ["score@a", "score@b", "truth"]);
    watch.events.clear();
    project.write("calm.ron", NESTED.replace("1.5", "2.5"));
    watch.until("the nested graph", |event| event["event"] == "wrote" && event["node"] == "save@b");
    watch.until_waiting_for(3);
    assert_eq!(nodes(&watch.events), ["calm/smooth@a", "calm/smooth@b", "save@a", "save@b", "score@a", "score@b"]);
    // One that is wrong shows where, and is mended.
    watch.events.clear();
    project.write("calm.ron", NESTED.replace("smooth_curves", "smooth_curve"));
    let said = watch.until("diagnostic", |event| event["event"] == "diagnostic");
    assert!(said.to_string().contains("calm.ron"), "{said}");
    project.write("calm.ron", NESTED);
    watch.until("the first results", |event| event["event"] == "wrote" && event["node"] == "save@b");
    watch.until_waiting_for(3);
    assert_eq!(written(&project, "out"), first);
    watch.stop(0);
}

#[test]
fn polling_sees_the_same() {
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    let mut watch = Watch::start(&project, &["--poll"]);
    let waiting = watch.until("waiting", |event| event["event"] == "waiting");
    assert_eq!(waiting["polling"], true);
    write_slowly(project_with_takes(&project), "takes/a.csv", &take(40), 10);
    watch.until("cooked a", |event| event["event"] == "wrote");
    let events = watch.stop(0);
    assert_eq!(cooked(&events, "takes@a"), [40]);
}

fn project_with_takes(project: &Project) -> &Project {
    fs::create_dir_all(project.path("takes")).unwrap();
    project
}

#[test]
fn a_take_is_not_held_up_by_a_training_that_goes_on() {
    let project = Project::new(PROGRAM);
    let graph = GRAPH.replacen("nodes: {", &format!("nodes: {{{TRAINING}"), 1);
    project.write("graph.ron", &graph);
    fs::create_dir_all(project.path("takes")).unwrap();
    let mut watch = Watch::start(&project, &[]);
    watch.until("training", |event| event["event"] == "progress" && event["node"] == "train");
    project.write("takes/a.csv", take(40));
    watch.until("cooked a", |event| event["event"] == "wrote" && event["node"] == "save@a");
    // The training that ran goes on.
    watch.until("more training", |event| event["event"] == "progress" && event["node"] == "train");
    // An edit that has nothing to do with it leaves it alone, too.
    project.write("graph.ron", graph.replace("\"sigma\": 1.5", "\"sigma\": 2.5"));
    watch.until("cooked a anew", |event| event["event"] == "wrote" && event["node"] == "save@a");
    assert_eq!(started(&watch.events, "train"), 1);
    // One that makes it stale stops it.
    project.write("graph.ron", graph.replace("epochs: 100000", "epochs: 2"));
    watch.until("the short training", |event| event["event"] == "cooked" && event["node"] == "train");
    watch.until_waiting_for(1);
    assert_eq!(started(&watch.events, "train"), 2);
    // A cook that is cut short says so by the exit code.
    project.write("graph.ron", graph.replace("epochs: 100000", "epochs: 99999"));
    watch.until("training", |event| event["event"] == "progress" && event["node"] == "train");
    let events = watch.stop(130);
    assert!(events.iter().any(|event| event["event"] == "summary" && event["cancelled"] == true));
}

fn started(events: &[Value], node: &str) -> usize {
    events.iter().filter(|event| event["event"] == "started" && event["node"] == node).count()
}
