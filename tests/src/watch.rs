//! A watch that runs beside a test, and what it says.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use crate::Project;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_mins(1);

/// A watch that runs, and what it has said so far.
#[derive(Debug)]
pub struct Watch {
    child: Child,
    lines: Receiver<String>,
    /// What it said, as far as it was asked for.
    pub events: Vec<Value>,
}

impl Watch {
    /// Starts `grimace watch graph.ron --json` in the project; it settles after 0.3 s where the arguments say nothing else.
    ///
    /// # Panics
    /// Where it cannot be started.
    pub fn start(project: &Project, arguments: &[&str]) -> Self {
        let mut command = project.command();
        command.args(["watch", "graph.ron", "--json"]).args(arguments);
        if !arguments.contains(&"--settle") {
            command.args(["--settle", "0.3"]);
        }
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
        let (sender, lines) = channel();
        let out = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || out.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Self { child, lines, events: Vec::new() }
    }

    /// Takes in what it says until something fits.
    ///
    /// # Panics
    /// Where nothing does within a minute.
    pub fn until(&mut self, what: &str, fits: impl Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let line = self.lines.recv_timeout(left).unwrap_or_else(|_| panic!("no {what}:\n{:#?}", self.events));
            self.events.push(serde_json::from_str(&line).unwrap());
            let event = self.events.last().unwrap();
            if fits(event) {
                return event.clone();
            }
        }
    }

    /// Takes in what it says until it waits with so many files complete.
    ///
    /// # Panics
    /// Where it does not within a minute.
    pub fn until_waiting_for(&mut self, files: usize) {
        self.until(&format!("waiting for {files} files"), |event| {
            event["event"] == "waiting" && event["files"] == files && event["settling"] == 0
        });
    }

    /// Sends it a signal: `INT`, `HUP`.
    ///
    /// # Panics
    /// Where it cannot be sent.
    pub fn signal(&self, name: &str) {
        Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status().unwrap();
    }

    /// Ends it; all that it said.
    ///
    /// # Panics
    /// Where it ends with another code.
    pub fn stop(mut self, code: i32) -> Vec<Value> {
        self.signal("INT");
        assert_eq!(self.child.wait().unwrap().code(), Some(code));
        let said = self.lines.iter().map(|line| serde_json::from_str(&line).unwrap());
        let mut events = std::mem::take(&mut self.events);
        events.extend(said);
        events
    }
}
