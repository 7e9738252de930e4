//! `grimace run`: exit codes, what goes to which stream, JSON, signals.

mod common;

use common::{GRAPH, Project, Ran, WRONG};
use std::time::{Duration, Instant};

#[test]
fn a_cook_tells_people_and_the_second_finds_all_done() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["run", "graph.ron"]).expect(0);
    assert_eq!(ran.out, "", "results only");
    assert!(ran.err.contains("✓ takes@a ") && ran.err.contains("✓ still "), "{}", ran.err);
    let last = ran.err.lines().last().unwrap();
    assert!(last.starts_with("3 cooked, 0 cached in "), "{last}");
    assert!(!ran.err.contains('\u{1b}'), "colours only on a terminal: {}", ran.err);
    assert!(project.path(".grimace").is_dir(), "the store stands beside the graph");

    let again = project.run(&["run", "."]).expect(0);
    assert_eq!(again.err.lines().count(), 1, "{}", again.err);
    assert!(again.err.starts_with("0 cooked, 3 cached in "), "{}", again.err);

    project.take("b", 0.75);
    let touched = project.run(&["run", "graph.ron", "-v"]).expect(0);
    assert!(touched.err.contains("▸ takes@b (load_curves): its file changed (takes/b.csv)"), "{}", touched.err);
    assert!(touched.err.contains("· takes@a (load_curves): up to date"), "{}", touched.err);
    assert!(touched.err.lines().last().unwrap().starts_with("1 cooked, 2 cached in "), "{}", touched.err);
}

#[test]
fn json_goes_to_standard_output_and_ends_with_the_summary() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["run", "graph.ron", "--json"]).expect(0);
    assert_eq!(ran.err, "");
    let events = ran.json();
    assert!(events.iter().all(|event| event["event"].is_string()));
    assert_eq!(events[0]["event"], "planned");
    let summary = ran.summary();
    for count in ["cooked", "cached", "failed", "blocks_cooked", "blocks_cached"] {
        assert!(summary[count].is_u64(), "{count}: {summary}");
    }
    assert!(summary["seconds"].is_f64());
    assert_eq!((&summary["cooked"], &summary["failed"]), (&3.into(), &0.into()));
    let cooked = events.iter().find(|event| event["event"] == "cooked" && event["node"] == "takes@b").unwrap();
    assert_eq!(cooked["kind"], "load_curves");
    assert!(cooked["outputs"]["curves"].as_str().unwrap().contains('2'), "{cooked}");
}

#[test]
fn a_failed_take_fails_alone() {
    let project = Project::new(GRAPH);
    project.write("takes/c.csv", "frame,jawOpen\n1,much\n");
    let ran = project.run(&["run", "graph.ron"]).expect(3);
    assert_eq!(ran.out, "");
    assert!(ran.err.contains("✗ takes@c (load_curves) failed at graph.ron:5:9\n    c.csv: "), "{}", ran.err);
    assert!(ran.err.contains("1 cell failed: takes@c; everything else went on\n3 cooked, 0 cached in "), "{}", ran.err);

    let json = project.run(&["run", "graph.ron", "--json"]).expect(3);
    let failed = json.json().into_iter().find(|event| event["event"] == "failed").unwrap();
    assert_eq!((&failed["node"], &failed["place"]), (&"takes@c".into(), &"graph.ron:5:9".into()));
    assert_eq!((&json.summary()["failed"], &json.summary()["cached"]), (&1.into(), &3.into()));

    let quiet = project.run(&["run", "graph.ron", "--quiet"]).expect(3);
    assert!(quiet.err.starts_with("✗ takes@c"), "{}", quiet.err);
    std::fs::remove_file(project.path("takes/c.csv")).unwrap();
    assert_eq!(project.run(&["run", "graph.ron", "-q"]).expect(0).err, "");
}

#[test]
fn only_some_nodes() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["run", "graph.ron", "--only", "still", "--json", "--jobs", "1"]).expect(0);
    assert_eq!(ran.summary()["cooked"], 1);
    let ran = project.run(&["run", "graph.ron", "--only", "still,tkaes"]).expect(2);
    assert!(ran.err.contains("there is no node `tkaes`") && ran.err.contains("did you mean `takes`?"), "{}", ran.err);
}

#[test]
fn a_wrong_graph_is_not_cooked() {
    let project = Project::new(WRONG);
    let ran = project.run(&["run", "graph.ron"]).expect(1);
    assert_eq!(ran.out, "");
    assert!(ran.err.contains("graph.ron:4:") && ran.err.contains("did you mean `load_curves`?"), "{}", ran.err);
    assert!(!project.path(".grimace").exists(), "nothing was cooked");
    let json = project.run(&["run", "graph.ron", "--json"]).expect(1);
    let events = json.json();
    assert_eq!(events.iter().filter(|event| event["event"] == "diagnostic").count(), events.len() - 1);
    assert!(events.iter().any(|event| event["code"] == "unknown-kind" && event["line"] == 4), "{events:?}");
    assert_eq!(json.summary()["cooked"], 0);
    assert_eq!(json.err, "");
    let ran = project.run(&["run", "grpah.ron"]).expect(1);
    assert!(ran.err.contains("did you mean `graph.ron`?"), "{}", ran.err);
}

#[test]
fn what_is_set_is_checked() {
    let project = Project::new(GRAPH);
    let ran = project.run(&["run", "graph.ron", "--set", "takes=takes/a*.csv", "--json"]).expect(0);
    assert_eq!(ran.summary()["cooked"], 2);
    let ran = project.run(&["run", "graph.ron", "--set", "still.rate_hz=30", "--only", "still", "--json"]).expect(0);
    assert_eq!(ran.summary()["cooked"], 1);
    for wrong in ["takes", "tkaes=x", "still.rate=24", "nobody.rate_hz=24"] {
        let ran = project.run(&["run", "graph.ron", "--set", wrong]);
        let ran = ran.expect(2);
        assert!(ran.err.contains(&format!("`--set {wrong}`")), "{wrong}: {}", ran.err);
    }
    let ran = project.run(&["run", "graph.ron", "--out", "elsewhere"]).expect(2);
    assert!(ran.err.contains("`--out elsewhere`") && ran.err.contains("${out}/"), "{}", ran.err);
}

/// Writes each take anew.
const SAVING: &str = r#"(
    grimace: 1,
    params: { "out": "out" },
    nodes: {
        "takes": (kind: "load_curves", with: (path: "../takes/*.csv")),
        "save": (kind: "save_curves", in: {"curves": "takes"}, with: (path: "${out}/{take}.csv")),
    },
)"#;

#[test]
fn files_are_written_where_they_are_wanted() {
    let project = Project::new(GRAPH);
    project.write("shot/graph.ron", SAVING);
    let ran = project.run(&["run", "shot"]).expect(0);
    assert!(ran.err.trim_end().ends_with("; wrote 2 files under shot/out/"), "{}", ran.err);
    assert!(project.path("shot/out/a.csv").is_file() && project.path("shot/out/b.csv.json").is_file());
    // What is named on the command line starts from the working folder.
    let ran = project.run(&["run", "shot", "--out", "else where"]).expect(0);
    assert!(ran.err.contains("→ else where/a.csv  "), "{}", ran.err);
    assert!(project.path("else where/a.csv").is_file());
    let wrote: Vec<_> = project.run(&["run", "shot", "--out", "third", "--json"]).expect(0).json();
    let wrote = wrote.iter().filter(|event| event["event"] == "wrote").map(|event| event["path"].as_str().unwrap());
    let mut wrote: Vec<_> = wrote.collect();
    wrote.sort_unstable();
    assert_eq!(wrote, ["third/a.csv", "third/b.csv"]);
    let same = project.run(&["run", "shot", "--out", "third", "--json"]).expect(0).summary();
    assert_eq!((&same["cooked"], &same["cached"], &same["written"]), (&0.into(), &4.into(), &0.into()));
}

#[test]
fn the_store_is_where_it_is_wanted() {
    let project = Project::new(GRAPH);
    project.long_takes();
    project.run(&["run", "graph.ron", "--store", "kept"]).expect(0);
    assert!(project.path("kept/actions").is_dir() && !project.path(".grimace").exists());
    let output = project.command(&["run", "graph.ron", "--json"]).env("GRIMACE_STORE", "kept").output().unwrap();
    assert_eq!(common::Ran::of(output).summary()["cached"], 3);
    project.write("file", "no folder");
    let ran = project.run(&["run", "graph.ron", "--store", "file"]).expect(2);
    assert!(ran.err.contains("--store"), "{}", ran.err);
}

#[test]
fn a_wrong_command_line() {
    let project = Project::new(GRAPH);
    for wrong in [&["cook"][..], &[], &["run"], &["run", "graph.ron", "--jobs", "0"], &["run", "graph.ron", "--nope"]] {
        let ran = project.run(wrong).expect(2);
        assert_eq!(ran.out, "");
        assert!(ran.err.contains("--help") || ran.err.contains("Usage"), "{}", ran.err);
    }
    let ran = project.run(&["--version"]).expect(0);
    assert_eq!(ran.out, format!("grimace {}\n", env!("CARGO_PKG_VERSION")));
}

/// A graph that cooks for minutes, with a node that is done at once.
const LONG: &str = r#"(
    grimace: 1,
    nodes: { "actor": (kind: "sample_actor", with: (takes: 1000, frames: 100000)) },
)"#;

#[test]
fn what_asks_for_more_memory_than_there_may_be_is_refused() {
    let project = Project::new(LONG);
    let ran = project.run(&["run", "graph.ron", "--memory", "2GB"]).expect(3);
    assert!(ran.err.contains("parameter `takes`: this takes ") && ran.err.contains("may take 2.0 GB"), "{}", ran.err);
    assert!(project.run(&["run", "graph.ron", "--memory", "much"]).expect(2).err.contains("is no size"));
}

#[cfg(unix)]
#[test]
fn the_first_signal_cancels_and_the_second_leaves_at_once() {
    use std::process::Command;
    let project = Project::new(LONG);
    let signal = |pid: u32, name: &str| {
        assert!(Command::new("kill").args([name, &pid.to_string()]).status().unwrap().success());
    };
    let mut child = project.command(&["run", "graph.ron", "--memory", "1TB"]).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    assert!(child.try_wait().unwrap().is_none(), "the graph should cook for long");
    signal(child.id(), "-INT");
    std::thread::sleep(Duration::from_millis(300));
    if child.try_wait().unwrap().is_none() {
        signal(child.id(), "-INT");
    }
    let since = Instant::now();
    let ran = common::Ran::of(child.wait_with_output().unwrap());
    assert_eq!(ran.code, Some(130), "{}", ran.err);
    assert!(since.elapsed() < Duration::from_secs(2), "leaving took {:?}", since.elapsed());
    assert!(ran.err.contains("cancelling"), "{}", ran.err);
}

#[test]
fn a_variable_of_the_environment_wakes_a_graph_at_rest() {
    let project = Project::new(&GRAPH.replace("takes/*.csv", "${ENV:SHOT_TAKES}/*.csv"));
    project.write("reshoot/a.csv", "# rate_hz: 60\nframe,jawOpen\n1,0\n");
    let names = |folder: &str| {
        let ran = Ran::of(project.command(&["run", "graph.ron", "--json"]).env("SHOT_TAKES", folder).output().unwrap())
            .expect(0);
        let cells = ran.json().into_iter().filter_map(|event| event["node"].as_str().map(str::to_owned));
        cells.collect::<std::collections::BTreeSet<_>>()
    };
    names("takes");
    // Files younger than the clock's grain are never taken to be as they were.
    std::thread::sleep(Duration::from_millis(2_050));
    let all = ["still", "takes@a", "takes@b"].map(str::to_owned);
    assert_eq!(names("takes"), all.clone().into());
    assert_eq!(names("takes"), all.into());
    assert_eq!(names("reshoot"), ["still", "takes@a"].map(str::to_owned).into());
}
