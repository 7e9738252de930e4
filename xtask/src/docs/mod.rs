//! `cargo xtask docs`: the manual of all nodes, written from what the nodes say of themselves.
//!
//! The descriptions come from `grimace nodes --json`, one kind a line in the order of the data's flow, so that this
//! program needs to know no node.

mod page;

use crate::failure::Failure;
use crate::repository::{Repository, output_of};
use crate::say;
use serde::de::Error;
use std::process::Command;

/// Where the manual stands.
const MANUAL: &str = "docs/nodes.md";

/// The program `grimace`, built where it is not up to date.
pub fn program(repository: &Repository) -> Command {
    repository.cargo(["run", "--quiet", "--package", "grimace", "--"])
}

/// Writes the manual from what `program` says.
pub fn write(repository: &Repository, program: &mut Command) -> Result<(), Failure> {
    let (kinds, text) = generate(program)?;
    repository.write(MANUAL, &text)?;
    say::line(&format!("{MANUAL}: {kinds} kinds"));
    Ok(())
}

/// Sees whether the manual is what `program` says.
pub fn check(repository: &Repository, program: &mut Command) -> Result<(), Failure> {
    let (_, text) = generate(program)?;
    let standing = repository.read(MANUAL).unwrap_or_default();
    match first_difference(&standing, &text) {
        None => Ok(()),
        Some((line, there, wanted)) => Err(Failure::Findings(vec![
            format!("{MANUAL}:{line}: the manual is stale"),
            format!("  there:  {there}"),
            format!("  should: {wanted}"),
            "run `cargo xtask docs` and commit what it writes".to_owned(),
        ])),
    }
}

/// The number of kinds, and the manual.
fn generate(program: &mut Command) -> Result<(usize, String), Failure> {
    // Plugins that this machine happens to have are no part of the manual.
    let lines = output_of(program.args(["nodes", "--json"]))?;
    let kinds = lines.lines().map(serde_json::from_str).collect::<Result<Vec<page::Kind>, _>>();
    let kinds = kinds.and_then(|kinds| {
        let kinds: Vec<page::Kind> = kinds.into_iter().filter(|kind| !kind.is_plugin()).collect();
        if kinds.is_empty() { Err(serde_json::Error::custom("no kinds were listed")) } else { Ok(kinds) }
    });
    let kinds = kinds.map_err(|problem| Failure::Command {
        command: "grimace nodes --json".into(),
        problem: format!("wrote something that is no description: {problem}"),
    })?;
    Ok((kinds.len(), page::render(&kinds)))
}

/// The first line that differs, counted from 1, as it stands and as it should.
fn first_difference<'a>(standing: &'a str, wanted: &'a str) -> Option<(usize, &'a str, &'a str)> {
    if standing == wanted {
        return None;
    }
    let (mut there, mut should) = (standing.lines(), wanted.lines());
    for line in 1.. {
        match (there.next(), should.next()) {
            (None, None) => return Some((line, "(another line end)", "")),
            (one, other) if one != other => return Some((line, one.unwrap_or(""), other.unwrap_or(""))),
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::first_difference;

    #[test]
    fn the_first_differing_line_is_found() {
        assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
        assert_eq!(first_difference("a\nb\n", "a\nc\n"), Some((2, "b", "c")));
        assert_eq!(first_difference("a\n", "a\nc\n"), Some((2, "", "c")));
        assert_eq!(first_difference("a", "a\n").map(|found| found.0), Some(2));
    }
}
