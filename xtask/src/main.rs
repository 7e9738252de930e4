//! `cargo xtask`: the chores of this repository: every check in one command, the generated manual, new nodes.
//!
//! It stands outside the flow of data and depends on no other crate of the workspace, so that it still builds where
//! those do not.

mod ci;
mod docs;
mod failure;
mod new_node;
mod repository;
mod say;
mod tidy;

use failure::Failure;
use repository::Repository;
use std::process::ExitCode;

const USAGE: &str = "\
cargo xtask ci [STEP…]            run all checks, or those named: fmt tidy clippy rustdoc machete deny build docs test
cargo xtask docs [--check]        write docs/nodes.md from what the nodes say of themselves, or see whether it is stale
cargo xtask new-node FOLDER NAME  write nodes/src/FOLDER/NAME.rs, a node that compiles and passes its test
cargo xtask tidy                  look for dead paths in pages, unfinished marks, overlong files and the like";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Checks) => ExitCode::FAILURE,
        Err(failure) => {
            say::error(&failure.to_string());
            match failure {
                Failure::Usage(_) => say::error(&format!("\n{USAGE}")),
                Failure::CommandLine(_) => {}
                _ => return ExitCode::FAILURE,
            }
            ExitCode::from(2)
        }
    }
}

fn run(words: &[&str]) -> Result<(), Failure> {
    let repository = Repository::here();
    match words {
        ["ci", steps @ ..] => ci::run(&repository, steps),
        ["docs"] => docs::write(&repository, &mut docs::program(&repository)),
        ["docs", "--check"] => docs::check(&repository, &mut docs::program(&repository)),
        ["new-node", folder, name] => new_node::run(&repository, folder, name),
        ["tidy"] => tidy::run(&repository),
        ["help" | "--help" | "-h"] => {
            say::line(USAGE);
            Ok(())
        }
        [] => Err(Failure::Usage("say what to do".into())),
        _ => Err(Failure::Usage(format!("there is no such task: {}", words.join(" ")))),
    }
}
