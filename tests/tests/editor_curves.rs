//! Curve work in a real terminal: keys set, moved, deleted and taken back over a solve of `graphs/fdls`, and what that writes.
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use whole_system::{Pane, Project, root};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");
/// A small actor and small networks: what they solve does not matter here.
const SMALL: [&str; 8] = [
    "epochs=1",
    "actor.takes=1",
    "actor.frames=96",
    "actor.density=0.5",
    "actor.rom_frames=600",
    "train.train.width=16",
    "train.train.blocks=1",
    "train.mixed_frames=0",
];

fn project() -> Project {
    let project = Project::new(PROGRAM);
    project.copy(&root().join("graphs/fdls"), "fdls");
    project
}

fn open(project: &Project, name: &str, size: (u16, u16)) -> Option<Pane> {
    let (store, out) = (project.path("store"), project.path("solved"));
    let (store, out) = (store.to_str().unwrap(), out.to_str().unwrap());
    let mut arguments = vec!["--store", store, "--out", out];
    arguments.extend(SMALL.iter().flat_map(|set| ["--set", *set]));
    Pane::open(PROGRAM, name, &project.path("fdls/graph.ron"), &arguments, size)
}

/// Begins work on the solved curves of the first take, and goes to frame 40 of the jaw.
fn begin(pane: &Pane) {
    pane.wait_for("nodes");
    pane.press(&["/"]);
    pane.type_text("solve");
    pane.press(&["Enter", "v"]);
    pane.wait_for("mm off by region");
    pane.press(&["Home", "L", "L", "L", "L", "/"]);
    pane.type_text("jawOpen");
    pane.press(&["Enter"]);
    pane.wait_for("jawOpen 0.");
}

fn jaw(project: &Project, row: usize) -> f64 {
    let text = project.read("solved/take_00.csv");
    let mut rows = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
    let column = rows.next().unwrap().iter().position(|name| *name == "jawOpen").unwrap();
    rows.nth(row).unwrap()[column].parse().unwrap()
}

#[test]
fn keys_are_set_moved_deleted_and_taken_back_and_the_curves_follow() {
    let project = project();
    let before = project.read("fdls/edits.ron");
    let Some(pane) = open(&project, "keys", (80, 24)) else { return };
    begin(&pane);
    // A key is set by its value, and the curves follow without being asked for.
    pane.press(&["Enter", "C-u"]);
    pane.type_text("0.9");
    pane.press(&["Enter"]);
    let shown = pane.wait_for("jawOpen 0.900");
    assert!(shown.contains("◆ 0.900 ±8") && shown.contains("1 keys"), "{shown}");
    // Moved in time and nudged; the view goes with it.
    pane.press(&[">", ">", "-"]);
    pane.wait_until("the key two frames on", |shown| shown.contains("jawOpen 0.890") && !shown.contains("newer"));
    assert_eq!(project.read("fdls/edits.ron"), before, "nothing is written before it is saved");
    // Deleted, and taken back.
    pane.press(&["d"]);
    pane.wait_until("no key", |shown| !shown.contains("jawOpen 0.890") && shown.contains(" 0 keys"));
    pane.press(&["u"]);
    pane.wait_for("jawOpen 0.890");
    // The worst frame is where the key pulls the jaw away from the markers.
    pane.press(&["Home", "n"]);
    pane.wait_for("worst 1 of ");
    pane.press(&["s"]);
    pane.wait_for(" saved /");
    let written = project.read("fdls/edits.ron");
    assert!(written.contains("\"jawOpen\": [(frame: ") && written.contains("value: 0.89)"), "{written}");
    assert!(written.starts_with(before.lines().next().unwrap()), "what stood there stays: {written}");
    // The files follow with the next cook of the graph.
    pane.press(&["Escape"]);
    pane.wait_for("graph solve_take.ron");
    pane.press(&["r"]);
    pane.wait_until("the cook's end", |shown| shown.contains(" cooked, ") && shown.contains("up to date in"));
    assert!((jaw(&project, 42) - 0.89).abs() < 1e-6, "{}", jaw(&project, 42));
    pane.press(&["q"]);
}

#[test]
fn a_killed_editor_loses_no_key() {
    let project = project();
    let before = project.read("fdls/edits.ron");
    let Some(pane) = open(&project, "killed", (100, 30)) else { return };
    begin(&pane);
    pane.press(&["+", "a"]);
    pane.wait_for("1 keys, 1 anchors");
    pane.kill();
    assert_eq!(project.read("fdls/edits.ron"), before);
    let Some(pane) = open(&project, "again", (100, 30)) else { return };
    pane.wait_for("bring them back");
    pane.press(&["r"]);
    pane.wait_for("unsaved");
    pane.press(&["s"]);
    pane.wait_for(" saved /");
    let written = project.read("fdls/edits.ron");
    assert!(written.contains("\"jawOpen\": [(frame: ") && written.contains("anchors: [(frame: "), "{written}");
    pane.press(&["q"]);
}
