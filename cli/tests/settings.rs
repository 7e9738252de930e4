//! Settings in their layers, what is made from the command line (completions, manual pages), logs and profiles.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

mod common;

use common::{GRAPH, Project};
use serde_json::Value;
use std::collections::BTreeMap;

fn explained(project: &Project, arguments: &[&str]) -> BTreeMap<String, Value> {
    let ran = project.run(&[&["config", "explain", "--json"], arguments].concat()).expect(0);
    ran.json().into_iter().map(|line| (line["name"].as_str().unwrap().to_owned(), line)).collect()
}

#[test]
fn later_layers_count_more_and_explain_names_the_line() {
    let project = Project::new(GRAPH);
    assert_eq!(explained(&project, &[])["jobs"]["layer"], "default");
    project
        .write("config/grimace/grimace.ron", "// mine\n(\n    jobs: 2,\n    color: always,\n    log: \"error\",\n)\n");
    project.write("grimace.ron", "( jobs: 3, store: \"studio\" )");
    project.write("show/grimace.ron", "(\n    store: \"cache\",\n)\n");
    project.write("show/shot/graph.ron", "( grimace: 1, nodes: {} )");
    let all = explained(&project, &["--graph", "show/shot/graph.ron"]);
    let of = |name: &str| (all[name]["value"].as_str().unwrap(), all[name]["layer"].as_str().unwrap());
    assert_eq!((of("jobs"), of("color"), of("log")), (("3", "project"), ("always", "user"), ("error", "user")));
    let store = of("store").0;
    assert!(store.ends_with("show/cache"), "relative to the file that says it: {store}");
    assert!(all["store"]["place"].as_str().unwrap().ends_with("show/grimace.ron:2:5"), "{}", all["store"]);
    assert!(all["store"]["hidden"][0]["place"].as_str().unwrap().ends_with("/grimace.ron:1:12"), "{}", all["store"]);

    let output =
        project.command(&["config", "explain", "jobs", "--color", "never"]).env("GRIMACE_JOBS", "5").output().unwrap();
    let ran = common::Ran::of(output).expect(0);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert!(lines[0].starts_with("jobs      5 ") && lines[0].ends_with(" GRIMACE_JOBS"), "{}", ran.out);
    assert!(lines[1].contains(" 3 ") && lines[1].contains("grimace.ron:1:3, which counts less"), "{}", ran.out);
    assert!(lines[2].contains(" 2 ") && lines[2].contains("config/grimace/grimace.ron:3:5"), "{}", ran.out);
    let colour = explained(&project, &["--color", "never"]);
    assert_eq!((&colour["color"]["value"], &colour["color"]["place"]), (&"never".into(), &"--color".into()));
    let ran = project.run(&["config", "explain", "jbos"]).expect(2);
    assert!(ran.err.contains("did you mean `jobs`?"), "{}", ran.err);
}

#[test]
fn settings_are_obeyed_and_enter_no_key() {
    let project = Project::new(GRAPH);
    project.long_takes();
    project.write("grimace.ron", "( store: \"kept\" )");
    assert_eq!(project.run(&["run", "graph.ron", "--json"]).expect(0).summary()["cooked"], 3);
    assert!(project.path("kept/actions").is_dir() && !project.path(".grimace").exists());
    assert!(project.run(&["cache", "stat", "graph.ron"]).expect(0).out.contains("kept"));
    // Everything else that can be set, in every layer: nothing cooks again.
    project.write("grimace.ron", "( store: \"kept\", jobs: 1, color: never, log: trace, log_file: \"cook.log\" )");
    let output = project.command(&["run", "graph.ron", "--json", "--color", "always", "--jobs", "2"]);
    let mut command = output;
    let output = command.env("GRIMACE_JOBS", "3").env("GRIMACE_LOG", "info").output().unwrap();
    let summary = common::Ran::of(output).expect(0).summary();
    assert_eq!((&summary["cooked"], &summary["cached"]), (&0.into(), &3.into()));
    assert!(project.path("cook.log").is_file());
    std::fs::remove_dir_all(project.path("kept/sessions")).unwrap();
    assert_eq!(
        project.run(&["run", "graph.ron", "--json"]).expect(0).summary()["cached"],
        3,
        "not by the session alone"
    );
}

#[test]
fn mistakes_in_settings_have_their_place_and_cure() {
    let project = Project::new(GRAPH);
    for (text, parts) in [
        ("(\n    stroe: \"x\",\n)", &["grimace.ron:2:5", "no field `stroe`", "did you mean `store`?"][..]),
        ("( jobs: 0 )", &["grimace.ron:1:9", "`jobs` must be a whole number from 1"]),
        ("( jobs: \"4\" )", &["`jobs` must be a whole number"]),
        ("( color: red )", &["`color` must be one of `auto`, `always`, `never`"]),
        ("( store: 5 )", &["`store` must be a path"]),
        ("( store: \"${ENV:NO_SUCH_VARIABLE_HERE}\" )", &["NO_SUCH_VARIABLE_HERE", "is not set"]),
        ("( log: ", &["grimace.ron:1:"]),
    ] {
        project.write("grimace.ron", text);
        for command in [&["run", "graph.ron"][..], &["config", "explain"]] {
            let ran = project.run(command).expect(2);
            assert!(parts.iter().all(|part| ran.err.contains(part)), "{text}: {}", ran.err);
            assert_eq!(ran.out, "");
        }
    }
    std::fs::remove_file(project.path("grimace.ron")).unwrap();
    for (name, value, part) in [
        ("GRIMACE_JOBS", "many", "must be a whole number"),
        ("GRIMACE_STROE", "x", "did you mean `GRIMACE_STORE`?"),
        ("GRIMACE_LOG", "loud", "`info`"),
    ] {
        let output = project.command(&["check", "graph.ron"]).env(name, value).output().unwrap();
        let ran = common::Ran::of(output).expect(2);
        assert!(ran.err.contains(name) && ran.err.contains(part), "{}", ran.err);
    }
    let output = project.command(&["check", "graph.ron"]).env("GRIMACE_SITE", "ours").env("GRIMACE_JOBS", "").output();
    common::Ran::of(output.unwrap()).expect(0);
}

#[test]
fn shells_and_man_are_told_of_every_command() {
    let project = Project::new(GRAPH);
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = project.run(&["completions", shell]).expect(0).out;
        for word in ["verify", "completions", "profile", "dry-run"] {
            assert!(script.contains(word), "{shell} knows no {word}");
        }
    }
    project.run(&["completions", "tcsh"]).expect(2);
    let page = project.run(&["man"]).expect(0).out;
    assert!(page.contains(".TH grimace 1") && page.contains("grimace\\-run"), "{page}");
    let page = project.run(&["man", "cache", "gc"]).expect(0).out;
    assert!(page.contains("\\-\\-keep") && page.contains("grimace cache gc"), "{page}");
    let ran = project.run(&["man", "cahce"]).expect(2);
    assert!(ran.err.contains("did you mean `cache`?"), "{}", ran.err);
    project.run(&["man", "--into", "man/man1"]).expect(0);
    for page in ["grimace.1", "grimace-run.1", "grimace-cache.1", "grimace-cache-verify.1", "grimace-config-explain.1"]
    {
        assert!(project.path("man/man1").join(page).is_file(), "{page}");
    }
}

#[test]
fn logs_hold_the_events_and_nothing_where_they_are_off() {
    let project = Project::new(GRAPH);
    let quiet = project.run(&["run", "graph.ron", "--json"]).expect(0);
    assert_eq!(quiet.err, "");
    project.take("b", 0.75);
    project.write("takes/c.csv", "frame,jawOpen\n1,much\n");
    let ran = project.run(&["run", "graph.ron", "--json", "--log", "debug", "--log-file", "cook.jsonl"]).expect(3);
    assert_eq!(ran.err, "");
    let text = std::fs::read_to_string(project.path("cook.jsonl")).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let logged = |message: &str| lines.iter().filter(|line| line["message"] == message).count();
    for message in ["planned", "started", "cooked", "cached", "failed", "summary"] {
        let told = ran.json().iter().filter(|event| event["event"] == message).count();
        assert_eq!(logged(message), told, "{message}: {text}");
    }
    let failed = lines.iter().find(|line| line["message"] == "failed").unwrap();
    assert_eq!((&failed["level"], &failed["node"]), (&"ERROR".into(), &"takes@c".into()));

    let ran = project.run(&["run", "graph.ron", "--json", "--log", "error"]).expect(3);
    assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
    assert!(ran.err.contains("ERROR") && ran.err.contains("takes@c") && !ran.err.contains('\u{1b}'), "{}", ran.err);
    let ran = project.run(&["run", "graph.ron", "--log", "info", "--log-file", "no/such/folder/x"]).expect(2);
    assert!(ran.err.contains("--log-file"), "{}", ran.err);
}

/// A graph whose nodes work by blocks of frames, with takes long enough for several.
const BLOCKS: &str = r#"(
    grimace: 1,
    nodes: {
        "actor": (kind: "sample_actor", with: (takes: 2, frames: 160)),
        "rig": (kind: "skin_jaw", in: {"rig": "actor.rig"}),
        "attach": (kind: "attach_markers", in: {"rig": "rig", "neutral": "actor.neutral"}),
        "error": (
            kind: "marker_error",
            in: {"curves": "actor.truth", "markers": "actor.takes", "rig": "rig", "attachment": "attach"},
        ),
    },
)"#;

#[test]
fn profiles_show_every_computed_block_on_its_thread() {
    let project = Project::new(BLOCKS);
    let ran = project.run(&["run", "graph.ron", "--json", "--jobs", "3", "--profile", "cook.json"]).expect(0);
    let profile: Value = serde_json::from_slice(&std::fs::read(project.path("cook.json")).unwrap()).unwrap();
    let events = profile["traceEvents"].as_array().unwrap();
    let of = |phase: &str| events.iter().filter(|event| event["ph"] == phase).collect::<Vec<_>>();
    let summary = ran.summary();
    let spans = of("X");
    let blocks = spans.iter().filter(|span| span["args"]["end"].is_u64()).count();
    assert_eq!(blocks as u64, summary["blocks_cooked"].as_u64().unwrap(), "a span a block");
    let cells: std::collections::BTreeSet<&str> = spans.iter().map(|span| span["name"].as_str().unwrap()).collect();
    assert_eq!(cells.len() as u64, summary["cooked"].as_u64().unwrap(), "{cells:?}");
    let mut threads: BTreeMap<u64, Vec<(f64, f64)>> = BTreeMap::new();
    for span in &spans {
        let (start, duration) = (span["ts"].as_f64().unwrap(), span["dur"].as_f64().unwrap());
        assert!(start >= 0.0 && duration >= 0.0, "{span}");
        assert!(start + duration <= 1e6 * summary["seconds"].as_f64().unwrap() + 5e6, "{span}");
        threads.entry(span["tid"].as_u64().unwrap()).or_default().push((start, start + duration));
    }
    for (thread, mut spans) in threads {
        // By their beginning, the longer first: each lies within those that are still open, or after them.
        spans.sort_by(|one, other| one.0.total_cmp(&other.0).then(other.1.total_cmp(&one.1)));
        let mut open: Vec<f64> = Vec::new();
        for (start, end) in spans {
            open.retain(|until| *until > start);
            assert!(open.iter().all(|until| end <= *until), "spans cross on thread {thread}");
            open.push(end);
        }
        let named = of("M").iter().any(|name| name["tid"] == thread);
        assert!(named, "thread {thread} has no name");
    }
    assert!(of("C").iter().any(|counter| counter["name"] == "cells"));
    let again = project.run(&["run", "graph.ron", "--json", "--profile", "again.json"]).expect(0);
    assert_eq!(again.summary()["cooked"], 0);
    let ran = project.run(&["run", "graph.ron", "--profile", "no/such/folder.json"]).expect(2);
    assert!(ran.err.contains("--profile"), "{}", ran.err);
}
