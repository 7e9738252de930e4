//! The editor in a real terminal: driven through tmux, looked at by what it captures.
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use std::fs;
use std::path::{Path, PathBuf};
use whole_system::Pane;

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");
const GRAPH: &str = r#"(
    grimace: 1,
    nodes: {
        // The head.
        "actor": (kind: "sample_actor", with: (takes: 1, frames: /* short */ 60)),
        "rig":   (kind: "skin_jaw", in: {"rig": "actor.rig"}), // its jaw
    },
)
"#;

fn open(name: &str, graph: &Path, size: (u16, u16)) -> Option<Pane> {
    Pane::open(PROGRAM, name, graph, &[], size)
}

fn project() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let graph = folder.path().join("graph.ron");
    fs::write(&graph, GRAPH).unwrap();
    (folder, graph)
}

#[test]
fn a_value_is_edited_cooked_and_saved() {
    let (_folder, graph) = project();
    let Some(pane) = open("edit", &graph, (100, 30)) else { return };
    pane.wait_for("stale");
    pane.press(&["r"]);
    pane.wait_for("2 cooked");
    pane.press(&["/", "a", "c", "Enter", "e"]);
    // To the parameter `frames`, as the form lists it.
    pane.wait_for("frames");
    for _ in 0..5 {
        pane.press(&["j"]);
    }
    pane.press(&["Enter"]);
    pane.wait_for("enter take");
    pane.press(&["C-u", "7", "2", "Enter"]);
    pane.wait_for("unsaved");
    pane.press(&["s"]);
    pane.wait_for(" saved /");
    assert_eq!(fs::read_to_string(&graph).unwrap(), GRAPH.replace("*/ 60", "*/ 72"));
    pane.press(&["q"]);
}

#[test]
fn a_killed_editor_loses_no_edit() {
    let (_folder, graph) = project();
    let Some(pane) = open("kill", &graph, (80, 24)) else { return };
    pane.wait_for("actor");
    pane.press(&["/", "r", "i", "g", "Enter", "n", "C-u"]);
    pane.press(&["j", "a", "w", "Enter"]);
    pane.wait_for("unsaved");
    pane.kill();
    assert_eq!(fs::read_to_string(&graph).unwrap(), GRAPH);
    let Some(pane) = open("again", &graph, (80, 24)) else { return };
    pane.wait_for("bring them back");
    pane.press(&["r"]);
    pane.wait_for("unsaved");
    pane.press(&["s"]);
    pane.wait_for(" saved /");
    assert_eq!(fs::read_to_string(&graph).unwrap(), GRAPH.replace("\"rig\":   (", "\"jaw\":   ("));
}

#[test]
fn a_file_that_changes_on_disk_is_merged() {
    let (_folder, graph) = project();
    let Some(pane) = open("merge", &graph, (100, 30)) else { return };
    pane.wait_for("actor");
    pane.press(&["/", "r", "i", "g", "Enter", "n", "C-u", "j", "a", "w", "Enter"]);
    pane.wait_for("unsaved");
    fs::write(&graph, GRAPH.replace("    grimace: 1,", "    grimace: 1,\n    doc: \"another hand\",")).unwrap();
    pane.wait_for("stand together");
    pane.press(&["s"]);
    pane.wait_for(" saved /");
    let saved = fs::read_to_string(&graph).unwrap();
    assert!(saved.contains("another hand") && saved.contains("\"jaw\":"), "{saved}");
}

#[test]
fn a_take_is_solved_from_the_first_key_on_without_leaving_the_editor() {
    let (folder, graph) = project();
    let Some(pane) = open("solve", &graph, (110, 36)) else { return };
    pane.wait_for("2 nodes");
    // Each node is added at an output, which it is wired to; what it needs beside that is wired by name.
    let add = |ports: usize, kind: &str| {
        pane.press(&vec!["."; ports]);
        pane.press(&["a"]);
        pane.type_text(kind);
        pane.press(&["Enter", "Enter"]);
        pane.wait_for(&format!("added {kind}"));
    };
    let wire = |source: &str| {
        pane.press(&["w"]);
        pane.type_text(source);
        pane.press(&["Enter"]);
        pane.wait_for("wire ");
    };
    pane.press(&["/", "r", "i", "g", "Enter"]);
    add(2, "attach_markers");
    wire("actor.neutral");
    add(3, "match_markers");
    wire("actor.takes");
    wire("rig.rig");
    add(4, "save_curves");
    pane.press(&["e", "Enter"]);
    pane.wait_for("enter take");
    pane.press(&["C-u"]);
    pane.type_text("\"out/{take}.csv\"");
    pane.press(&["Enter", "Escape"]);
    pane.wait_until("5 nodes without a mistake", |shown| shown.contains("5 nodes"));
    pane.press(&["r"]);
    pane.wait_for("5 cooked");
    pane.press(&["s"]);
    pane.wait_for(" saved /");
    pane.press(&["q"]);
    let solved = fs::read_to_string(folder.path().join("out/take_00.csv")).unwrap();
    let rows = solved.lines().filter(|line| line.starts_with(|letter: char| letter.is_ascii_digit())).count();
    assert_eq!(rows, 60, "a row a frame: {solved}");
    assert!(solved.contains("jawOpen"), "{solved}");
    assert!(fs::read_to_string(&graph).unwrap().contains("// its jaw"));
}
