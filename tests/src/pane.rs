//! A real terminal with the editor in it: driven through tmux, looked at by what it captures.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// A terminal with the editor in it, on a server of its own that ends with this value.
#[derive(Debug)]
pub struct Pane {
    server: String,
}

impl Pane {
    /// The editor over `graph` with these arguments; `None` where there is no tmux, which fails where `CI` is set.
    ///
    /// # Panics
    /// Where tmux is not installed and `CI` is set.
    #[allow(clippy::print_stderr, reason = "a test that is left out says so")]
    pub fn open(program: &str, name: &str, graph: &Path, arguments: &[&str], size: (u16, u16)) -> Option<Self> {
        let there = Command::new("tmux").arg("-V").output().is_ok_and(|output| output.status.success());
        if !there {
            assert!(std::env::var_os("CI").is_none(), "tmux is not installed");
            eprintln!("SKIPPED: tmux is not installed, so the editor is not tried in a terminal");
            return None;
        }
        let pane = Self { server: format!("grimace-{name}-{}", std::process::id()) };
        let (columns, rows) = (size.0.to_string(), size.1.to_string());
        let arguments: Vec<String> = arguments.iter().map(|argument| format!("'{argument}'")).collect();
        let line = format!("exec '{program}' edit '{}' {}", graph.display(), arguments.join(" "));
        pane.tmux(&["-f", "/dev/null", "new-session", "-d", "-x", &columns, "-y", &rows, &line]);
        Some(pane)
    }

    /// Runs a command of tmux; gives what it says.
    ///
    /// # Panics
    /// Where tmux cannot be started.
    pub fn tmux(&self, arguments: &[&str]) -> String {
        let output = Command::new("tmux").args(["-L", &self.server]).args(arguments).output();
        let output = output.unwrap_or_else(|problem| panic!("tmux: {problem}"));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Kills the editor as `kill -9` does, and waits until it has ended.
    ///
    /// # Panics
    /// Where it cannot be killed, or lives on for two minutes.
    pub fn kill(self) {
        let process = self.tmux(&["display-message", "-p", "#{pane_pid}"]);
        let killed = Command::new("kill").args(["-9", process.trim()]).status();
        assert!(killed.is_ok_and(|status| status.success()), "the editor cannot be killed");
        // What holds much memory takes a while to end. Who does not wait for it finds it as a zombie.
        let lives = || {
            let facts = std::fs::read_to_string(format!("/proc/{}/stat", process.trim())).unwrap_or_default();
            facts.rsplit(')').next().is_some_and(|rest| !rest.is_empty() && !rest.trim_start().starts_with(['Z', 'X']))
        };
        let begun = Instant::now();
        while lives() {
            assert!(begun.elapsed() < Duration::from_mins(2), "the killed editor lives on");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Presses keys by the names that tmux has for them.
    pub fn press(&self, keys: &[&str]) {
        for key in keys {
            self.tmux(&["send-keys", key]);
        }
    }

    /// Types a text letter by letter.
    pub fn type_text(&self, text: &str) {
        self.tmux(&["send-keys", "-l", text]);
    }

    /// Waits until `text` is on the screen, which it gives.
    ///
    /// # Panics
    /// Where it does not come within two minutes.
    pub fn wait_for(&self, text: &str) -> String {
        self.wait_until(text, |shown| shown.contains(text))
    }

    /// Waits until the screen is as it should be, and gives it.
    ///
    /// # Panics
    /// Where that does not come within two minutes.
    pub fn wait_until(&self, what: &str, holds: impl Fn(&str) -> bool) -> String {
        let begun = Instant::now();
        loop {
            let shown = self.tmux(&["capture-pane", "-p"]);
            if holds(&shown) {
                return shown;
            }
            assert!(begun.elapsed() < Duration::from_mins(2), "`{what}` does not come:\n{shown}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Pane {
    fn drop(&mut self) {
        self.tmux(&["kill-server"]);
    }
}
