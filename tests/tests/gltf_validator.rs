//! The animated head that a solve ends in, held against the Khronos glTF validator. (That it moves as the take is a test of
//! `face-io`, which plays the file by itself.)

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use std::process::Command;
use whole_system::{Project, Run, root, skipped};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

const GRAPH: &str = r#"(
    grimace: 1,
    nodes: {
        "actor": (kind: "sample_actor", with: (takes: 1)),
        "jaw":   (kind: "skin_jaw", in: {"rig": "actor.rig"}),
        "save":  (kind: "save_animation", in: {"rig": "jaw", "curves": "actor.truth"}, with: (path: "{take}.glb")),
    },
)"#;

#[test]
fn animated_heads_are_without_errors_and_warnings() {
    if !root().join("tests/validator/node_modules/gltf-validator").is_dir() {
        return skipped("there is no glTF validator; `npm install --prefix tests/validator` brings it");
    }
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    project.run(&["run", "."]).ended_with(0);
    let validate = root().join("tests/validator/validate.js");
    let run = Run::of(Command::new("node").arg(validate).arg(project.path("take_00.glb"))).ended_with(0);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((&report["issues"]["numErrors"], &report["issues"]["numWarnings"]), (&0.into(), &0.into()), "{report}");
    assert_eq!((&report["info"]["animationCount"], &report["info"]["hasMorphTargets"]), (&1.into(), &true.into()));
}
