//! The editor in a real terminal: driven through tmux, looked at by what it captures.
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

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

/// A terminal with the editor in it, on a server of its own.
struct Pane {
    server: String,
}

impl Pane {
    /// `None` where there is no tmux.
    #[allow(clippy::print_stderr, reason = "a test that is left out says so")]
    fn open(name: &str, graph: &Path, size: (u16, u16)) -> Option<Self> {
        let there = Command::new("tmux").arg("-V").output().is_ok_and(|output| output.status.success());
        if !there {
            assert!(std::env::var_os("CI").is_none(), "tmux is not installed");
            eprintln!("SKIPPED: tmux is not installed, so the editor is not tried in a terminal");
            return None;
        }
        let pane = Self { server: format!("grimace-{name}-{}", std::process::id()) };
        let (columns, rows) = (size.0.to_string(), size.1.to_string());
        let line = format!("exec '{PROGRAM}' edit '{}'", graph.display());
        pane.tmux(&["-f", "/dev/null", "new-session", "-d", "-x", &columns, "-y", &rows, &line]);
        Some(pane)
    }

    fn tmux(&self, arguments: &[&str]) -> String {
        let output = Command::new("tmux").args(["-L", &self.server]).args(arguments).output().unwrap();
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    fn press(&self, keys: &[&str]) {
        for key in keys {
            self.tmux(&["send-keys", key]);
        }
    }

    /// Waits until `text` is on the screen.
    fn wait_for(&self, text: &str) -> String {
        let begun = Instant::now();
        loop {
            let shown = self.tmux(&["capture-pane", "-p"]);
            if shown.contains(text) {
                return shown;
            }
            assert!(begun.elapsed() < Duration::from_mins(1), "`{text}` does not come:\n{shown}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Pane {
    fn drop(&mut self) {
        self.tmux(&["kill-server"]);
    }
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
    let Some(pane) = Pane::open("edit", &graph, (100, 30)) else { return };
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
    let Some(pane) = Pane::open("kill", &graph, (80, 24)) else { return };
    pane.wait_for("actor");
    pane.press(&["/", "r", "i", "g", "Enter", "n", "C-u"]);
    pane.press(&["j", "a", "w", "Enter"]);
    pane.wait_for("unsaved");
    let process = pane.tmux(&["display-message", "-p", "#{pane_pid}"]);
    Command::new("kill").args(["-9", process.trim()]).status().unwrap();
    drop(pane);
    assert_eq!(fs::read_to_string(&graph).unwrap(), GRAPH);
    let Some(pane) = Pane::open("again", &graph, (80, 24)) else { return };
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
    let Some(pane) = Pane::open("merge", &graph, (100, 30)) else { return };
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
