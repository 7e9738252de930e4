//! The examples of docs/manual.md do what the manual says that they do.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use whole_system::{Project, root};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

/// The blocks of RON in the manual, in their order.
fn examples() -> Vec<String> {
    let manual = std::fs::read_to_string(root().join("docs/manual.md")).unwrap();
    let blocks = manual.split("```ron\n").skip(1);
    blocks.map(|rest| rest.split("```").next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn the_first_cook_writes_its_takes_and_a_third_one_costs_its_own_nodes() {
    let project = Project::new(PROGRAM);
    project.write("graph.ron", &examples()[0]);
    project.run(&["check", "graph.ron"]).ended_with(0);
    let curves = ["run", "graph.ron", "--json", "--only", "curves,error"];
    let first = project.run(&curves).ended_with(0);
    assert_eq!((first.summary("cooked"), first.summary("written")), (7, 2));
    let second = project.run(&curves).ended_with(0);
    assert_eq!((second.summary("cooked"), second.summary("cached")), (0, 7));
    let third = project.run(&[&curves[..], &["--set", "takes=3"]].concat()).ended_with(0);
    let cooked: Vec<String> = third.cooked().into_iter().map(|(name, _)| name).collect();
    assert_eq!(cooked, ["actor", "curves@take_02", "error@take_02"]);
    assert_eq!((third.summary("blocks_cooked"), third.summary("blocks_cached")), (8, 16));
    assert!(project.read("out/take_02.csv").starts_with("# rate_hz: 60"));
    let sidecar: serde_json::Value = serde_json::from_str(&project.read("out/take_02.csv.json")).unwrap();
    assert_eq!((&sidecar["node"], &sidecar["kind"]), (&"curves@take_02".into(), &"save_curves".into()));
}

#[test]
fn the_nested_graph_is_cooked_once_an_item() {
    let project = Project::new(PROGRAM);
    let examples = examples();
    let (entries, nested) = (&examples[1], &examples[2]);
    let graph = format!(
        r#"(grimace: 1, params: {{ "out": "out" }}, nodes: {{
            "actor": (kind: "sample_actor", with: (takes: 1)),
            "rig": (kind: "skin_jaw", in: {{"rig": "actor.rig"}}),
            {entries}
        }})"#
    );
    // Curves with all channels of the head: those that drove the takes of the first example.
    project.write("first.ron", &examples[0]);
    project.run(&["run", "first.ron", "--only", "curves"]).ended_with(0);
    project.copy(&project.path("out/take_00.csv"), "rom/smile.csv");
    project.copy(&project.path("out/take_01.csv"), "rom/frown.csv");
    project.write("graph.ron", graph);
    project.write("one.ron", nested);
    let cooked = project.run(&["run", ".", "--json", "--only", "each/head"]).ended_with(0);
    let names: Vec<String> = cooked.cooked().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["actor", "curves@frown", "curves@smile", "each/head@frown", "each/head@smile", "rig"]);
    assert!(project.path("out/smile.glb").is_file() && project.path("out/frown.glb.json").is_file());
}

#[test]
fn exit_codes_are_those_of_the_manual() {
    let project = Project::new(PROGRAM);
    project.write("wrong.ron", "(grimace: 1, nodes: { \"actor\": (kind: \"sample_actr\") })");
    project.run(&["check", "wrong.ron"]).ended_with(1);
    project.run(&["run", "nowhere.ron"]).ended_with(1);
    project.run(&["frobnicate"]).ended_with(2);
    project
        .write("graph.ron", "(grimace: 1, nodes: { \"rom\": (kind: \"load_curves\", with: (path: \"rom/*.csv\")) })");
    project.run(&["run", ".", "--only", "rig"]).ended_with(2);
    project.write("rom/bad.csv", "# rate_hz: 60\nframe,a\n0,x\n");
    let failed = project.run(&["run", ".", "--json"]).ended_with(3);
    assert_eq!(failed.events_of("failed")[0]["node"], "rom@bad");
    assert_eq!(failed.summary("failed"), 1);
    project.write("rom/bad.csv", "# rate_hz: 60\nframe,a\n0,1\n");
    project.run(&["run", "."]).ended_with(0);
}
