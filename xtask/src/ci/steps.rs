//! The checks other than tests.

use super::Done;
use crate::failure::Failure;
use crate::repository::{Repository, output_of, run};
use crate::{docs as manual, tidy as tidiness};
use serde_json::Value;
use std::process::Stdio;

/// Every Rust file is laid out by rustfmt. Files are named one by one, since `cargo fmt` sees only what a `mod` reaches.
pub fn fmt(repository: &Repository) -> Result<Done, Failure> {
    let mut command = repository.program("rustfmt");
    command.args(["--check", "--files-with-diff", "--edition", "2024"]);
    command.args(repository.files()?.iter().filter(|file| is_rust(file)));
    let output = command.stderr(Stdio::inherit()).output();
    let output = output.map_err(|problem| Failure::Command {
        command: "rustfmt".into(),
        problem: format!("cannot be started ({problem}); `rustup component add rustfmt` installs it"),
    })?;
    let mut wrong: Vec<String> = String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect();
    wrong.sort_unstable();
    wrong.dedup();
    if wrong.is_empty() && output.status.success() {
        return Ok(Done::Fine);
    }
    wrong.push("these files are not laid out by rustfmt: run `rustfmt --edition 2024` on them".into());
    Err(Failure::Findings(wrong))
}

fn is_rust(file: &str) -> bool {
    std::path::Path::new(file).extension().is_some_and(|extension| extension == "rs")
}

/// Lints, tests and examples included.
pub fn clippy(repository: &Repository) -> Result<Done, Failure> {
    run(&mut repository.cargo(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    Ok(Done::Fine)
}

/// Documentation without a warning, private items included.
pub fn rustdoc(repository: &Repository) -> Result<Done, Failure> {
    let mut command = repository.cargo(["doc", "--workspace", "--no-deps", "--document-private-items"]);
    run(command.env("RUSTDOCFLAGS", "-D warnings"))?;
    Ok(Done::Fine)
}

/// All that the tests need, so that the time of the tests is their own.
pub fn build(repository: &Repository) -> Result<Done, Failure> {
    run(&mut repository.cargo(BUILD))?;
    Ok(Done::Fine)
}

const BUILD: [&str; 4] = ["test", "--workspace", "--no-run", "--quiet"];
/// The program `grimace` as the whole-system tests build it.
const PROGRAM: &str = "grimace-under-test";

/// The generated manual is what the nodes say. The program that lists them is the one built for the tests: by itself
/// it would be built with other features of its dependencies, and thus once more.
pub fn docs(repository: &Repository) -> Result<Done, Failure> {
    manual::check(repository, &mut repository.program(program(repository)?))?;
    Ok(Done::Fine)
}

/// Graphs that hold a snapshot give what they gave when it was accepted. They are cooked from nothing, in a store of their own.
pub fn snapshots(repository: &Repository) -> Result<Done, Failure> {
    let program = program(repository)?;
    let store = repository.path("target/snapshots");
    if store.exists() {
        std::fs::remove_dir_all(&store).map_err(|problem| Failure::File { path: store.clone(), problem })?;
    }
    for file in repository.files()? {
        if let Some(graph) = file.strip_suffix("/golden/snapshot.ron").filter(|graph| graph.starts_with("graphs/")) {
            let mut command = repository.program(&program);
            run(command.args(["snapshot", "check", graph, "-q", "--store"]).arg(&store))?;
        }
    }
    Ok(Done::Fine)
}

/// The program `grimace` as it was built for the tests.
fn program(repository: &Repository) -> Result<String, Failure> {
    let messages = output_of(repository.cargo(BUILD).arg("--message-format=json-render-diagnostics"))?;
    let program = messages.lines().find_map(|line| {
        let message: Value = serde_json::from_str(line).ok()?;
        let is_ours = message["target"]["name"] == PROGRAM;
        message["executable"].as_str().filter(|_| is_ours).map(str::to_owned)
    });
    program.ok_or_else(|| Failure::Command {
        command: "cargo test --no-run".into(),
        problem: format!("built no {PROGRAM}"),
    })
}

/// The repository's own rules.
pub fn tidy(repository: &Repository) -> Result<Done, Failure> {
    tidiness::run(repository)?;
    Ok(Done::Fine)
}

/// Unused dependencies, by cargo-machete.
pub fn machete(repository: &Repository) -> Result<Done, Failure> {
    if !installed(repository, "machete") {
        return Ok(Done::Left(
            "cargo-machete is not installed; `cargo install cargo-machete --locked` does that".into(),
        ));
    }
    run(&mut repository.cargo(["machete"]))?;
    Ok(Done::Fine)
}

/// Licences, banned crates and sources, by cargo-deny. Advisories are left out, since they need a database from the
/// network.
pub fn deny(repository: &Repository) -> Result<Done, Failure> {
    if !installed(repository, "deny") {
        return Ok(Done::Left("cargo-deny is not installed; `cargo install cargo-deny --locked` does that".into()));
    }
    run(&mut repository.cargo(["deny", "check", "licenses", "bans", "sources"]))?;
    Ok(Done::Fine)
}

fn installed(repository: &Repository, tool: &str) -> bool {
    output_of(&mut repository.cargo(["--list"]))
        .is_ok_and(|list| list.lines().any(|line| line.split_whitespace().next() == Some(tool)))
}
