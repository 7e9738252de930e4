//! One `check` finds every mistake in a graph and in those nested in it, each at its place and with its cure. What it says of
//! the graph in `mistakes/` stands in `mistakes/golden.txt`; after a change that is meant, `GRIMACE_ACCEPT=1 cargo test -p
//! whole-system --test mistakes` writes it anew, to be read before it is committed.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use std::collections::BTreeSet;
use whole_system::{Project, root};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

fn project() -> Project {
    let project = Project::new(PROGRAM);
    for name in ["graph.ron", "inner.ron", "deeper.ron", "takes"] {
        project.copy(&root().join("tests/tests/mistakes").join(name), name);
    }
    project
}

#[test]
fn a_broken_graph_is_told_as_a_whole() {
    let run = project().run(&["check", "graph.ron"]).ended_with(1);
    assert_eq!(run.stdout, "");
    let told: Vec<&str> = run.stderr.lines().map(str::trim_end).collect();
    let told = told.join("\n") + "\n";
    let golden = root().join("tests/tests/mistakes/golden.txt");
    if std::env::var_os("GRIMACE_ACCEPT").is_some() {
        std::fs::write(&golden, &told).unwrap();
    }
    let expected = std::fs::read_to_string(&golden).unwrap();
    let differs = told.lines().zip(expected.lines()).position(|(now, then)| now != then);
    assert!(
        told == expected,
        "it differs from {} from line {:?} on:\n{told}",
        golden.display(),
        differs.map(|line| line + 1)
    );
}

#[test]
fn every_mistake_has_a_place_and_nearly_every_one_a_cure() {
    let run = project().run(&["check", "graph.ron", "--json"]).ended_with(1);
    let mistakes = run.events_of("diagnostic");
    assert!(mistakes.len() >= 20, "{}", mistakes.len());
    let mut codes = BTreeSet::new();
    for mistake in &mistakes {
        assert!(mistake["line"].is_u64() && mistake["column"].is_u64(), "{mistake}");
        codes.insert(mistake["code"].as_str().unwrap());
    }
    assert!(codes.len() >= 15, "{codes:?}");
    // The message itself says what fits.
    let plain = ["out-of-range", "wrong-type"];
    let bare = mistakes
        .iter()
        .find(|mistake| !mistake["help"].is_string() && !plain.contains(&mistake["code"].as_str().unwrap()));
    assert_eq!(bare, None, "it has no cure");
    let files: BTreeSet<&str> = mistakes.iter().map(|mistake| mistake["file"].as_str().unwrap()).collect();
    assert_eq!(files, BTreeSet::from(["graph.ron", "inner.ron", "deeper.ron"]));
}

/// Each mistake is found when all the others are there: mended one by one, no new one appears.
#[test]
fn no_mistake_hides_another() {
    let all = project();
    let count = |project: &Project| project.run(&["check", "graph.ron", "--json"]).events_of("diagnostic").len();
    let before = count(&all);
    let text = all.read("graph.ron");
    let lines: Vec<&str> = text.lines().collect();
    for (index, line) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("        \"")) {
        // Nodes that others are wired to stay.
        if ["takes", "still", "inner", "round", "about", "head", "each", "calm"]
            .iter()
            .any(|name| line.contains(&format!("\"{name}\":")))
        {
            continue;
        }
        let without: Vec<&str> =
            lines.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, line)| *line).collect();
        all.write("graph.ron", without.join("\n"));
        let after = count(&all);
        assert!(after < before, "without `{}` there are {after} mistakes, not fewer than {before}", line.trim());
    }
}
