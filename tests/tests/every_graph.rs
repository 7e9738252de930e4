//! Every ready graph holds together, and the main one runs on the sample actor from nothing to files.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use whole_system::{Project, root, test_data};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

/// Settings under which networks train in seconds: what is tested here is the way, not the quality.
const QUICK: [&str; 10] = [
    "--set",
    "epochs=1",
    "--set",
    "train.train.width=24",
    "--set",
    "train.train.blocks=1",
    "--set",
    "train.mixed_frames=0",
    "--set",
    "actor.takes=2",
];

#[test]
fn every_ready_graph_is_without_mistakes() {
    let data = test_data();
    let mut checked = 0;
    for folder in std::fs::read_dir(root().join("graphs")).unwrap() {
        let graph = folder.unwrap().path().join("graph.ron");
        if !graph.is_file() {
            continue;
        }
        let text = std::fs::read_to_string(&graph).unwrap();
        let needs_solves = text.contains("../fdls_ict/out/");
        if text.contains("shared/data") && (data.is_none() || needs_solves) {
            continue;
        }
        let run = Project::new(PROGRAM).run(&["check", graph.to_str().unwrap()]).ended_with(0);
        assert!(
            run.stderr.contains("no mistakes") || run.stdout.contains("no mistakes"),
            "{}{}",
            run.stdout,
            run.stderr
        );
        checked += 1;
    }
    assert!(checked > 0);
}

#[test]
fn the_sample_actor_is_solved_from_nothing() {
    let project = Project::new(PROGRAM);
    project.copy(&root().join("graphs/fdls"), "fdls");
    let mut arguments = vec!["run", "fdls", "--out", "solved", "--json"];
    arguments.extend(QUICK);
    let first = project.run(&arguments).ended_with(0);
    assert_eq!((first.summary("failed"), first.summary("written")), (0, 8), "{}", first.stderr);
    for file in ["take_00.raw.csv", "take_00.csv", "take_01.glb", "take_01.png"] {
        assert!(project.path("solved").join(file).is_file(), "{file}");
        assert!(project.path("solved").join(format!("{file}.json")).is_file(), "the sidecar of {file}");
    }
    let again = project.run(&arguments).ended_with(0);
    assert_eq!((again.summary("cooked"), again.summary("written")), (0, 0));

    let sheet = project.run(&["inspect", "solved/take_00.glb", "solved/take_00.csv", "--json"]).ended_with(0);
    let kinds: Vec<String> = sheet.events().iter().map(|file| file["kind"].to_string()).collect();
    assert_eq!(kinds, ["\"rig\"", "\"curves\""]);
    assert_eq!(sheet.events()[1]["frames"], 600);
}

/// The overall score of each line of a table of scores, by the first word of its name after the dot.
fn scores(project: &Project, file: &str) -> std::collections::BTreeMap<String, f64> {
    let line = |line: &str| {
        let (name, rest) = line.split_once(',').unwrap();
        let stage = name.split('/').next().unwrap().rsplit('.').next().unwrap();
        (stage.to_owned(), rest.split(',').next().unwrap().parse().unwrap())
    };
    project.read(file).lines().skip(1).map(line).collect()
}

#[test]
fn strain_rigs_are_trained_solved_and_transferred_from_nothing() {
    let project = Project::new(PROGRAM);
    for graph in ["strain_train", "strain_solve", "strain_transfer"] {
        project.copy(&root().join("graphs").join(graph), graph);
        let run = project.run(&["run", graph, "--out", graph, "--json"]).ended_with(0);
        assert_eq!(run.summary("failed"), 0, "{graph}: {}", run.stderr);
    }
    let mm = scores(&project, "strain_train/stages.csv");
    assert!(mm["neutral"] > mm["skinning"] && mm["skinning"] > mm["strain_shapes"], "{mm:?}");
    assert!(mm["pose_shapes"] > mm["strain_shapes"] && mm["strain_shapes"] > 10.0 * mm["refined"], "{mm:?}");
    assert!(mm["linear"] > mm["refined"], "{mm:?}");
    let mm = scores(&project, "strain_transfer/transfer.csv");
    assert!(mm["rest"] > mm["plain"] && mm["plain"] > mm["guided"], "{mm:?}");
}
