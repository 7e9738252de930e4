//! Runs all tests, shows them as they go, and counts them.

use super::Done;
use super::tally::Reader;
use crate::failure::Failure;
use crate::repository::{Repository, shown};
use crate::say;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

/// Runs all tests of the workspace.
pub fn run(repository: &Repository) -> Result<Done, Failure> {
    let mut command = repository.cargo(["test", "--workspace", "--no-fail-fast", "--", "--show-output"]);
    let failed = |problem: String| Failure::Command { command: "cargo test".into(), problem };
    let mut child = command.stdout(Stdio::piped()).spawn().map_err(|problem| failed(problem.to_string()))?;
    let mut reader = Reader::default();
    if let Some(output) = child.stdout.take() {
        let mut lines = BufReader::new(output);
        let mut bytes = Vec::new();
        // Tests may print bytes that are no text.
        while lines.read_until(b'\n', &mut bytes).map_err(|problem| failed(problem.to_string()))? > 0 {
            let line = String::from_utf8_lossy(&bytes).into_owned();
            if reader.take(&line) {
                say::line(line.trim_end());
            }
            bytes.clear();
        }
    }
    let status = child.wait().map_err(|problem| failed(problem.to_string()))?;
    let mut tally = reader.tally;
    if !status.success() && tally.failed == 0 {
        // A test binary that did not build, or ended without a result, has failed too.
        say::error(&format!("`{}` ended with {status}, though no test said that it failed", shown(&command)));
        tally.failed = 1;
    }
    Ok(Done::Tests(tally))
}
