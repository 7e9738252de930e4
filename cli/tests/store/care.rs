//! Garbage and pins.

use crate::common::Project;
use crate::{SAVING, age, files, stored, written};
use std::fs;

/// A project that was cooked with three rates, the last of which its session knows.
fn cooked() -> Project {
    let project = crate::project();
    for rate in ["rate=12.0", "rate=48.0", "rate=24.0"] {
        project.run(&["run", "graph.ron", "--set", rate]).expect(0);
    }
    project
}

#[test]
fn the_least_recently_needed_goes_first() {
    let project = cooked();
    let all = stored(&project);
    let older: Vec<_> = files(&project.path(".grimace/actions"));
    for path in &all {
        age(path, 3);
    }
    // Of the three rates, the session names one; the actions of the others were not needed for three days.
    let before = project.run(&["cache", "stat", "--json"]).expect(0).json().remove(0);
    let bytes: u64 =
        ["action_bytes", "pack_bytes", "session_bytes"].iter().map(|part| before[part].as_u64().unwrap()).sum();
    let keep = format!("{}B", bytes - 1);
    let dry = project.run(&["cache", "gc", "--keep", &keep, "--dry-run"]).expect(0);
    assert!(dry.out.starts_with("would remove 1 value, "), "{}", dry.out);
    assert_eq!(stored(&project), all, "a dry run removes nothing");
    let ran = project.run(&["cache", "gc", "graph.ron", "--keep", &keep, "-v"]).expect(0);
    assert!(
        ran.out.contains("removed 1 value, ") && ran.err.contains(", not needed for 72h"),
        "{}{}",
        ran.out,
        ran.err
    );
    assert_eq!(stored(&project).len(), all.len() - 1);
    let cook = project.run(&["run", "graph.ron", "--json"]).expect(0).summary();
    assert_eq!((&cook["cooked"], &cook["cached"]), (&0.into(), &5.into()), "what the last cook needed is still there");

    let ran = project.run(&["cache", "gc", "--keep", "0", "--json"]).expect(0).json();
    let last = ran.last().unwrap();
    assert_eq!((&last["event"], &last["after_bytes"]), (&"collected".into(), &0.into()));
    assert_eq!(last["removed"].as_u64().unwrap() as usize, ran.len() - 1);
    assert_eq!(stored(&project), Vec::<std::path::PathBuf>::new());
    assert_eq!(older.len(), 7);
    let cook = project.run(&["run", "graph.ron", "--json"]).expect(0).summary();
    assert_eq!(cook["cooked"], 5);
}

#[test]
fn a_use_counts_as_need() {
    let project = cooked();
    for path in &stored(&project) {
        age(path, 3);
    }
    // Going back to an earlier rate finds its action in the store.
    let back = project.run(&["run", "graph.ron", "--set", "rate=12.0", "--json"]).expect(0).summary();
    assert_eq!(back["cooked"], 0);
    let day = std::time::Duration::from_hours(24);
    let fresh = |path: &std::path::PathBuf| fs::metadata(path).unwrap().modified().unwrap().elapsed().unwrap() < day;
    let used: Vec<_> = files(&project.path(".grimace/actions")).into_iter().filter(fresh).collect();
    assert_eq!(used.len(), 1, "only what is not in the session is looked up: {used:?}");
}

#[test]
fn results_whose_values_are_gone_are_made_again() {
    let project = cooked();
    let sound = written(&project);
    fs::remove_dir_all(project.path(".grimace/packs")).unwrap();
    fs::remove_dir_all(project.path("out")).unwrap();
    let ran = project.run(&["run", "graph.ron", "--json"]).expect(0).summary();
    assert_eq!((&ran["failed"], &ran["cooked"], &ran["written"]), (&0.into(), &0.into(), &2.into()));
    assert_eq!(written(&project), sound);
}

#[test]
fn a_pinned_graph_keeps_what_it_needs() {
    let project = cooked();
    let unknown = project.run(&["cache", "pin", "grpah.ron"]).expect(2);
    assert!(unknown.err.contains("there is no graph grpah.ron"), "{}", unknown.err);
    project.write("other.ron", SAVING);
    let never = project.run(&["cache", "pin", "other.ron"]).expect(2);
    assert!(never.err.contains("no cook of other.ron is remembered"), "{}", never.err);
    project.run(&["cache", "pin", "graph.ron"]).expect(0);
    let ran = project.run(&["cache", "gc", "--keep", "0"]).expect(0);
    assert!(ran.out.contains("that pinned graphs need"), "{}", ran.out);
    let stat = project.run(&["cache", "stat"]).expect(0);
    assert!(stat.out.contains("pinned: ") && stat.out.contains("graph.ron"), "{}", stat.out);
    fs::remove_dir_all(project.path("out")).unwrap();
    let cook = project.run(&["run", "graph.ron", "--json"]).expect(0).summary();
    let counts = ["cooked", "cached", "remade", "written"].map(|name| cook[name].as_u64().unwrap());
    assert_eq!(counts, [0, 5, 0, 2], "all values of the pinned graph are there");

    // Where it cannot be told what a pinned graph needs, nothing goes.
    let session = files(&project.path(".grimace/sessions")).remove(0);
    let sound = fs::read(&session).unwrap();
    fs::write(&session, &sound[..40]).unwrap();
    let refused = project.run(&["cache", "gc", "--keep", "0"]).expect(2);
    assert!(refused.err.contains("nothing was removed") && refused.err.contains("unpin"), "{}", refused.err);
    fs::write(&session, sound).unwrap();
    fs::remove_file(project.path("graph.ron")).unwrap();
    project.run(&["cache", "unpin", "graph.ron"]).expect(0);
    let again = project.run(&["cache", "unpin", "graph.ron"]).expect(2);
    assert!(again.err.contains("is not pinned") && again.err.contains("no graph is pinned"), "{}", again.err);
    project.run(&["cache", "gc", "--keep", "0"]).expect(0);
    assert_eq!(stored(&project).len(), 0);
}

#[test]
fn sizes_are_checked() {
    let project = cooked();
    for wrong in ["20", "much", "-1GB"] {
        let ran = project.run(&["cache", "gc", &format!("--keep={wrong}")]).expect(2);
        assert!(ran.err.contains("is no size"), "{}", ran.err);
    }
    project.run(&["cache", "gc"]).expect(2);
    assert!(project.run(&["cache", "gc", "--keep", "1TB"]).expect(0).out.contains("now holds"));
}
