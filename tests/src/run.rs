//! What a run of the program said and did.

use serde_json::Value;
use std::process::Command;

/// A run that is over.
#[derive(Debug)]
pub struct Run {
    /// The exit code; `None` where a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Run {
    /// Runs `command` to its end.
    ///
    /// # Panics
    /// Where it cannot be started.
    pub fn of(command: &mut Command) -> Self {
        let output = command.output().unwrap_or_else(|problem| panic!("{command:?}: {problem}"));
        Self {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// The same run, which must have ended with `code`.
    ///
    /// # Panics
    /// Where it ended with another, with all that it said.
    #[allow(clippy::return_self_not_must_use, reason = "it is often called for its check alone")]
    pub fn ended_with(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "\n{}\n{}", self.stdout, self.stderr);
        self
    }

    /// The events that `--json` printed, in their order.
    ///
    /// # Panics
    /// Where a line of standard output is no JSON object.
    pub fn events(&self) -> Vec<Value> {
        let event = |line: &str| match serde_json::from_str(line) {
            Ok(event @ Value::Object(_)) => event,
            _ => panic!("no event: {line}"),
        };
        self.stdout.lines().map(event).collect()
    }

    /// The events called `name`.
    pub fn events_of(&self, name: &str) -> Vec<Value> {
        self.events().into_iter().filter(|event| event["event"] == name).collect()
    }

    /// The cells that were computed, in the order of their names, with the blocks of frames computed in each.
    pub fn cooked(&self) -> Vec<(String, u64)> {
        let cell = |event: &Value| {
            (event["node"].as_str().unwrap_or_default().to_owned(), event["blocks_cooked"].as_u64().unwrap_or(0))
        };
        let mut cooked: Vec<_> = self.events_of("cooked").iter().map(cell).collect();
        cooked.sort_unstable();
        cooked
    }

    /// The number `name` of the summary, which is the last event.
    ///
    /// # Panics
    /// Where the last event is no summary, or holds no such number.
    pub fn summary(&self, name: &str) -> u64 {
        let last = self.events().pop().unwrap_or_default();
        assert_eq!(last["event"], "summary", "the last event is {last}\n{}", self.stderr);
        last[name].as_u64().unwrap_or_else(|| panic!("no number `{name}` in {last}"))
    }
}
