//! `cargo xtask ci`: every check of the repository, each timed; one failing check does not keep the others from running.

mod steps;
mod tally;
mod test;

use crate::failure::Failure;
use crate::repository::Repository;
use crate::say;
use std::time::{Duration, Instant};
use tally::Tally;

/// A check: its name, and what runs it.
struct Step {
    name: &'static str,
    run: fn(&Repository) -> Result<Done, Failure>,
}

/// What became of a check that found nothing wrong.
enum Done {
    /// It ran.
    Fine,
    /// It could not run here, and why.
    Left(String),
    /// Tests ran.
    Tests(Tally),
}

/// All checks, the quick ones first.
const STEPS: [Step; 10] = [
    Step { name: "fmt", run: steps::fmt },
    Step { name: "tidy", run: steps::tidy },
    Step { name: "clippy", run: steps::clippy },
    Step { name: "rustdoc", run: steps::rustdoc },
    Step { name: "machete", run: steps::machete },
    Step { name: "deny", run: steps::deny },
    Step { name: "build", run: steps::build },
    Step { name: "docs", run: steps::docs },
    Step { name: "snapshot", run: steps::snapshots },
    Step { name: "test", run: test::run },
];

/// Runs the checks called `wanted`, or all. Where tests ran, the last line is `N passed, N failed, N skipped`.
pub fn run(repository: &Repository, wanted: &[&str]) -> Result<(), Failure> {
    if let Some(unknown) = wanted.iter().find(|name| STEPS.iter().all(|step| step.name != **name)) {
        let known: Vec<_> = STEPS.iter().map(|step| step.name).collect();
        return Err(Failure::CommandLine(format!("there is no step `{unknown}`; there are {}", known.join(", "))));
    }
    let start = Instant::now();
    let (mut lines, mut sound, mut tests) = (Vec::new(), true, None);
    for step in STEPS.iter().filter(|step| wanted.is_empty() || wanted.contains(&step.name)) {
        say::line(&format!("── {} ──", step.name));
        let begun = Instant::now();
        let result = (step.run)(repository);
        let became = match result {
            Ok(Done::Fine) => "ok".to_owned(),
            Ok(Done::Left(why)) => format!("NOT RUN: {why}"),
            Ok(Done::Tests(tally)) => {
                sound &= tally.failed == 0;
                tests = Some(tally);
                if tally.failed == 0 { "ok" } else { "FAILED" }.to_owned()
            }
            Err(failure) => {
                sound = false;
                say::error(&failure.to_string());
                "FAILED".to_owned()
            }
        };
        let line = format!("{:<8} {:>9}  {became}", step.name, told(begun.elapsed()));
        say::line(&line);
        lines.push(line);
    }
    say::line(&format!("\n{}\n{:<8} {:>9}", lines.join("\n"), "all", told(start.elapsed())));
    if let Some(tally) = tests {
        say::line(&tally.to_string());
    }
    if sound { Ok(()) } else { Err(Failure::Checks) }
}

/// `1 min 02 s`, or `3.4 s`.
fn told(time: Duration) -> String {
    let seconds = time.as_secs();
    if seconds < 60 {
        format!("{:.1} s", time.as_secs_f64())
    } else {
        format!("{} min {:02} s", seconds / 60, seconds % 60)
    }
}
