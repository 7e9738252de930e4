//! All commands besides `run`: what they print, and their exit codes.

mod common;

use common::{GRAPH, Project, WRONG};
use std::io::Read;

#[test]
fn check_counts_or_reports() {
    let project = Project::new(GRAPH);
    assert_eq!(project.run(&["check", "graph.ron"]).expect(0).out, "graph.ron: no mistakes (2 nodes)\n");
    let checked = project.run(&["check", ".", "--json"]).expect(0).json();
    assert_eq!((&checked[0]["event"], &checked[0]["nodes"]), (&"checked".into(), &2.into()));

    project.write("graph.ron", WRONG);
    let ran = project.run(&["check", "graph.ron"]).expect(1);
    assert_eq!(ran.out, "");
    assert!(ran.err.contains("graph.ron:4:") && ran.err.contains("graph.ron:5:"), "{}", ran.err);
    let ran = project.run(&["check", "graph.ron", "--color", "always"]).expect(1);
    assert!(ran.err.contains('\u{1b}'), "{}", ran.err);
    let json = project.run(&["check", "graph.ron", "--json"]).expect(1);
    assert_eq!(json.err, "");
    let lines = json.json();
    let (last, mistakes) = lines.split_last().unwrap();
    assert_eq!((&last["event"], &last["mistakes"]), (&"checked".into(), &mistakes.len().into()));
    assert!(mistakes.iter().all(|mistake| mistake["event"] == "diagnostic" && mistake["file"] == "graph.ron"));
}

#[test]
fn plans_say_what_and_why_and_cook_nothing() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["plan", "graph.ron"]).expect(0);
    assert!(ran.out.contains("cook      takes@a  load_curves  it is new"), "{}", ran.out);
    assert!(ran.out.ends_with("3 to cook, 0 cached\n"), "{}", ran.out);
    assert_eq!(ran.err, "");
    project.run(&["run", "graph.ron"]).expect(0);
    let ran = project.run(&["plan", "graph.ron", "--set", "still.rate_hz=30"]).expect(0);
    assert!(ran.out.contains("parameter `rate_hz` changed"), "{}", ran.out);
    assert!(ran.out.ends_with("1 to cook, 2 cached\n"), "{}", ran.out);
    let json = project.run(&["plan", "graph.ron", "--json"]).expect(0);
    assert_eq!(json.summary()["cached"], 3);
}

#[test]
fn why_tells_the_cause() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["why", "graph.ron", "still"]).expect(0);
    assert!(ran.out.contains("has not been cooked yet"), "{}", ran.out);
    assert!(!project.path(".grimace").exists(), "asking makes no store");
    project.run(&["run", "graph.ron"]).expect(0);
    project.take("b", 0.125);
    project.run(&["run", "graph.ron"]).expect(0);
    let ran = project.run(&["why", "graph.ron", "takes@b"]).expect(0);
    assert!(ran.out.contains("its file changed (takes/b.csv)"), "{}", ran.out);
    let items = project.run(&["why", "graph.ron", "takes"]).expect(0);
    assert!(
        items.out.contains("\n  takes@a  last cooked in run 1 of 2\n  takes@b  cooked in the last run"),
        "{}",
        items.out
    );
    let ran = project.run(&["why", "graph.ron", "takes@bb"]).expect(2);
    assert!(ran.err.contains("did you mean `takes@b`?"), "{}", ran.err);
    let ran = project.run(&["why", "graph.ron", "stil"]).expect(2);
    assert!(ran.err.contains("did you mean `still`?"), "{}", ran.err);
    project.write("graph.ron", WRONG);
    project.run(&["why", "graph.ron", "still"]).expect(0);
    project.run(&["why", "nothing.ron", "still"]).expect(1);
}

#[test]
fn nodes_are_listed_and_described() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["nodes"]).expect(0);
    assert!(ran.out.starts_with("load\n  load_"), "{}", ran.out);
    let all = project.run(&["nodes", "--json"]).expect(0).json();
    assert_eq!(all.len(), ran.out.lines().filter(|line| line.starts_with("  ")).count());
    for kind in &all {
        assert!(kind["doc"].as_str().is_some_and(|doc| doc.len() > 20), "{kind}");
        assert!(!kind["outputs"].as_array().unwrap().is_empty(), "{kind}");
        for parameter in kind["parameters"].as_array().unwrap() {
            assert!(!parameter["doc"].as_str().unwrap().is_empty(), "{}.{parameter}", kind["name"]);
        }
    }
    let page = project.run(&["nodes", "load_curves"]).expect(0).out;
    for part in
        ["Outputs\n  curves", "Parameters\n  path (must be given)", "rate_hz = None  a number", "Loads animation"]
    {
        assert!(page.contains(part), "{part}: {page}");
    }
    assert!(page.lines().all(|line| line.chars().count() <= 100 || line.contains("  a ")), "{page}");
    let one = project.run(&["nodes", "load_curves", "--json"]).expect(0).json();
    assert_eq!((one.len(), &one[0]["name"]), (1, &"load_curves".into()));
    let ran = project.run(&["nodes", "load_curve"]).expect(2);
    assert!(ran.err.contains("did you mean `load_curves`?"), "{}", ran.err);
}

#[test]
fn dot_draws() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["dot", "graph.ron"]).expect(0);
    assert!(ran.out.starts_with("digraph") && ran.out.contains("takes\\nload_curves"), "{}", ran.out);
    project.write("graph.ron", WRONG);
    assert_eq!(project.run(&["dot", "graph.ron"]).expect(1).out, "");
}

#[test]
fn inspect_shows_what_it_can() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["inspect", "takes/a.csv", "missing.c3d", "takes/b.csv"]).expect(1);
    assert!(ran.out.contains("takes/a.csv: curves") && ran.out.contains("takes/b.csv: curves"), "{}", ran.out);
    assert!(ran.err.contains("missing.c3d: cannot be read"), "{}", ran.err);
    let json = project.run(&["inspect", "--json", "takes/a.csv", "takes/b.csv"]).expect(0).json();
    assert_eq!(json.len(), 2);
    assert_eq!((&json[0]["file"], &json[0]["kind"]), (&"takes/a.csv".into(), &"curves".into()));
    assert_eq!((&json[0]["frames"], &json[0]["rate_hz"]), (&2.into(), &60.0.into()));
    assert_eq!(json[0]["names"], serde_json::json!(["jawOpen", "mouthSmile_L"]));
    let json = project.run(&["inspect", "--json", "takes"]).expect(1).json();
    assert!(json[0]["error"].as_str().unwrap().contains("folder"), "{json:?}");
}

#[test]
fn the_store_is_counted() {
    let project = Project::new(GRAPH);
    project.long_takes();
    let ran = project.run(&["cache", "stat", "graph.ron"]).expect(2);
    assert!(ran.err.contains("there is no store at .grimace"), "{}", ran.err);
    project.run(&["run", "graph.ron"]).expect(0);
    let ran = project.run(&["cache", "stat"]).expect(0);
    assert!(ran.out.contains("results") && ran.out.contains("together"), "{}", ran.out);
    let json = project.run(&["cache", "stat", "graph.ron", "--json"]).expect(0).json();
    assert_eq!(json[0]["actions"], 3);
    assert!(json[0]["action_bytes"].as_u64().unwrap() > 0);
}

#[test]
fn a_reader_may_leave_early() {
    let project = Project::new(GRAPH);
    for arguments in [&["nodes", "--json"][..], &["nodes"], &["run", "graph.ron", "--json"]] {
        let mut child = project.command(arguments).spawn().unwrap();
        let mut out = child.stdout.take().unwrap();
        let mut first = [0];
        assert_eq!(out.read(&mut first).unwrap(), 1);
        drop(out);
        let ran = common::Ran::of(child.wait_with_output().unwrap());
        assert!(!ran.err.contains("panicked"), "{}", ran.err);
        assert_eq!(ran.err, "");
    }
}
