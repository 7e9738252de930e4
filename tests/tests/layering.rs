//! The direction of dependencies: what ARCHITECTURE.md says that a folder must not know, it does not know.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use whole_system::Workspace;

/// A package of the house.
struct Room {
    package: &'static str,
    /// The packages of the house that it may name.
    stands_on: &'static [&'static str],
    /// What must not be below it, at any depth, beside what it may not name.
    must_not_know: &'static [&'static str],
    /// What must not stand in its sources, outside of tests.
    must_not_say: &'static [&'static str],
}

const TERMINALS: &[&str] = &["ratatui", "crossterm", "clap", "console", "indicatif", "wasmtime"];
/// What a pure computation does not touch.
const THE_MACHINE: &[&str] =
    &["std::fs", "std::time", "std::net", "std::env", "std::process", "std::thread", "stdout()", "stderr()"];
/// The same for code that may run threads of its own.
const THE_OUTSIDE: &[&str] = &["std::fs", "std::time", "std::net", "std::env", "std::process", "stdout()", "stderr()"];
/// The same for nodes, which may pace their checkpoints; what time it is stays out of their results.
const THE_OUTSIDE_BUT_STOPWATCHES: &[&str] =
    &["std::fs", "SystemTime", "std::net", "std::env", "std::process", "std::thread", "stdout()", "stderr()"];
/// The engine reads files and clocks, and neither prints nor runs programs.
const PEOPLE: &[&str] = &["std::net", "process::Command", "stdout()", "stderr()"];

/// The house, from the ground up.
const HOUSE: &[Room] = &[
    Room {
        package: "wire",
        stands_on: &[],
        must_not_know: &["rayon", "dfdx", "ratatui", "clap", "console", "wasmtime", "typetag"],
        must_not_say: THE_MACHINE,
    },
    Room { package: "plot", stands_on: &[], must_not_know: TERMINALS, must_not_say: THE_MACHINE },
    Room { package: "graph-core", stands_on: &["wire"], must_not_know: TERMINALS, must_not_say: PEOPLE },
    Room { package: "face-math", stands_on: &["wire"], must_not_know: TERMINALS, must_not_say: THE_MACHINE },
    Room { package: "face-io", stands_on: &["wire", "face-math"], must_not_know: TERMINALS, must_not_say: THE_MACHINE },
    Room { package: "learn", stands_on: &[], must_not_know: TERMINALS, must_not_say: THE_OUTSIDE },
    Room {
        package: "sample-head",
        stands_on: &["wire", "face-math"],
        must_not_know: TERMINALS,
        must_not_say: THE_MACHINE,
    },
    Room {
        package: "nodes",
        stands_on: &["wire", "plot", "graph-core", "face-math", "face-io", "learn", "sample-head"],
        must_not_know: TERMINALS,
        must_not_say: THE_OUTSIDE_BUT_STOPWATCHES,
    },
    Room {
        package: "report",
        stands_on: &["wire", "plot", "graph-core", "face-math", "face-io", "nodes"],
        must_not_know: TERMINALS,
        must_not_say: THE_MACHINE,
    },
    Room {
        package: "editor-tui",
        stands_on: &["wire", "graph-core", "face-math", "nodes"],
        must_not_know: &["clap", "console", "indicatif"],
        must_not_say: &["std::net", "process::Command"],
    },
    // It runs foreign code and compilers, and knows no node, no network and no terminal.
    Room {
        package: "plugin-host",
        stands_on: &["wire", "graph-core", "face-math"],
        must_not_know: &["ratatui", "clap", "console", "dfdx", "wasmtime-wasi"],
        must_not_say: &["std::net", "stdout()", "stderr()"],
    },
    Room {
        package: "grimace",
        stands_on: &[
            "wire",
            "plot",
            "graph-core",
            "face-math",
            "face-io",
            "nodes",
            "report",
            "editor-tui",
            "plugin-host",
        ],
        must_not_know: &[],
        must_not_say: &[],
    },
    Room {
        package: "whole-system",
        stands_on: &[
            "wire",
            "graph-core",
            "face-math",
            "face-io",
            "learn",
            "sample-head",
            "nodes",
            "editor-tui",
            "plugin-host",
            "grimace",
        ],
        must_not_know: &[],
        must_not_say: &[],
    },
    Room { package: "xtask", stands_on: &[], must_not_know: &[], must_not_say: &[] },
];

#[test]
fn every_package_has_its_place() {
    let members: BTreeSet<String> = Workspace::load().members.into_keys().collect();
    let known: BTreeSet<String> = HOUSE.iter().map(|room| room.package.to_owned()).collect();
    assert_eq!(members, known, "say in this file, and in ARCHITECTURE.md, what a new package stands on");
}

#[test]
fn packages_stand_only_on_what_is_below_them() {
    let workspace = Workspace::load();
    let mut below = BTreeSet::new();
    for room in HOUSE {
        assert!(room.stands_on.iter().all(|package| below.contains(package)), "{} points back", room.package);
        below.insert(room.package);
        for needed in workspace.direct(room.package) {
            let is_ours = workspace.members.contains_key(needed);
            assert!(!is_ours || room.stands_on.contains(&needed), "`{}` must not know `{needed}`", room.package);
        }
    }
}

#[test]
fn packages_do_not_build_on_what_they_must_not_know() {
    let workspace = Workspace::load();
    for room in HOUSE {
        let all = workspace.all(room.package);
        if let Some(unwanted) = room.must_not_know.iter().find(|unwanted| all.contains_key(**unwanted)) {
            let chain = workspace.chain(room.package, unwanted);
            panic!("`{}` must not know `{unwanted}`: {chain}", room.package);
        }
    }
}

#[test]
fn networks_come_from_learn_alone() {
    let workspace = Workspace::load();
    for package in workspace.members.keys() {
        let knows = workspace.direct(package).contains("dfdx");
        assert_eq!(knows, package == "learn", "dfdx stands below `learn`, and `{package}` asks that for networks");
    }
}

#[test]
fn nothing_but_its_tests_builds_on_the_program() {
    let workspace = Workspace::load();
    let users: Vec<_> = workspace.members.keys().filter(|name| workspace.direct(name).contains("grimace")).collect();
    assert_eq!(users, ["whole-system"]);
}

#[test]
fn sources_do_not_reach_for_what_is_not_theirs() {
    let workspace = Workspace::load();
    let mut found = Vec::new();
    for room in HOUSE {
        for file in sources(&workspace.members[room.package].join("src")) {
            let text = std::fs::read_to_string(&file).unwrap();
            for (number, line) in outside_of_tests(&text) {
                for word in room.must_not_say.iter().filter(|word| says(line, word)) {
                    found.push(format!("{}:{number}: `{}` must not use {word}", file.display(), room.package));
                }
            }
        }
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn the_page_says_of_every_package_what_it_must_not_know() {
    let page = std::fs::read_to_string(whole_system::root().join("ARCHITECTURE.md")).unwrap();
    for room in HOUSE {
        let folder = match room.package {
            "grimace" => "cli",
            "whole-system" => "tests",
            "plugin-host" => "plugins/host",
            other => other,
        };
        let section = page.split(&format!("\n## `{folder}/`")).nth(1);
        let section = section.unwrap_or_else(|| panic!("ARCHITECTURE.md has no section on `{folder}/`"));
        let section = section.split("\n## ").next().unwrap_or_default();
        assert!(section.contains("Must not know:"), "ARCHITECTURE.md does not say what `{folder}/` must not know");
    }
}

/// Whether a line of code names `word`, alone or in a list such as `use std::{fs, io};`.
fn says(line: &str, word: &str) -> bool {
    let listed = || {
        let (module, name) = word.split_once("::")?;
        let rest = line.trim().strip_prefix("use ")?.strip_prefix(module)?.strip_prefix("::{")?;
        Some(rest.split(|letter: char| !letter.is_alphanumeric() && letter != '_').any(|part| part == name))
    };
    line.contains(word) || listed().unwrap_or(false)
}

#[test]
fn words_are_found_in_lists_too() {
    assert!(says("use std::{fs, io};", "std::fs") && says("    std::fs::read(path)", "std::fs"));
    assert!(!says("use std::{fsx, io};", "std::fs") && !says("use face_io::{fs};", "std::fs"));
}

/// All Rust files of a folder, those of tests left out.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") && !name.contains("test") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// The lines before a file's tests, without comments.
fn outside_of_tests(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line));
    let code = lines.take_while(|(_, line)| *line != "#[cfg(test)]");
    code.filter(|(_, line)| !line.trim_start().starts_with("//"))
}
