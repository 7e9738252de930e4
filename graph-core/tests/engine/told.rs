//! What is told of a cook: why each cell was cooked, and what a cook would do.

use crate::cook::takes;
use crate::world::Project;
use graph_core::cook::{Event, Session, story};

#[test]
fn why_follows_a_change_to_its_first_cause() {
    let project = takes();
    project.cook();
    project.series("takes/a.txt", 100, |t| t as f64 + 0.5);
    project.cook();
    let session = Session::load(&project.store(), &project.path("graph.ron"));
    let told = story(&session, "save@a").unwrap();
    let lines: Vec<&str> = told.lines().map(str::trim).collect();
    assert_eq!(lines[0], "save@a was cooked in the last run: its input `series` changed");
    assert_eq!(lines[1], "← solve/blur@a was cooked: its input `series` changed");
    assert_eq!(lines[2], "← solve/scale@a was cooked: its input `series` changed");
    assert!(
        lines[3].starts_with("← takes@a was cooked: its file changed (") && lines[3].ends_with("takes/a.txt)"),
        "{told}"
    );
    assert!(story(&session, "save@b").unwrap().contains("was not cooked in the last run"));
}

#[test]
fn another_version_of_a_kind_is_named_with_the_one_before() {
    let project = Project::new(
        r#"(grimace: 1, nodes: {
            "read":  (kind: "read", with: (path: "a.txt")),
            "work":  (kind: "versioned", in: {"series": "read"}, with: (slot: 1000000)),
            "after": (kind: "scale", in: {"series": "work"}),
        })"#,
    );
    project.series("a.txt", 10, |t| t as f64);
    project.cook();
    crate::world::VERSIONS.lock().unwrap().insert(1_000_000, 2);
    assert_eq!(project.cook().names(), ["after", "work"]);
    let session = Session::load(&project.store(), &project.path("graph.ron"));
    let told = story(&session, "after").unwrap();
    assert!(told.contains("← work was cooked: its kind `versioned` is now version 2, and was 1 ("), "{told}");
    // Version 3 gives what version 2 gave, so the change stops there.
    crate::world::VERSIONS.lock().unwrap().insert(1_000_000, 3);
    assert_eq!(project.cook().names(), ["work"]);
}

#[test]
fn a_dry_run_names_the_cause_and_cooks_nothing() {
    let mut project = takes();
    project.cook();
    project.options.dry = true;
    let cooked = project.cook_with(&["by=9.0"]);
    let told: Vec<_> = cooked
        .events
        .iter()
        .filter_map(|event| match event {
            Event::WouldCook { node, because, sure, .. } => Some((node.as_str(), because.as_str(), *sure)),
            _ => None,
        })
        .collect();
    assert!(told.iter().any(|(node, because, sure)| *node == "solve/scale@a"
        && because == &"parameter `by` changed from 3.0 to 9.0 (--set by=9.0)"
        && *sure));
    assert!(
        told.iter()
            .any(|(node, because, sure)| *node == "total" && because.contains("may give another result") && !sure)
    );
    project.options.dry = false;
    assert_eq!(project.cook().summary.cooked, 0, "planning changed nothing");
}

#[test]
fn a_dry_run_of_what_was_never_cooked_says_so_and_makes_no_store() {
    let mut project = takes();
    project.options.dry = true;
    let cooked = project.cook();
    let new = |event: &&Event| matches!(event, Event::WouldCook { because, sure: true, .. } if because.starts_with("it is new ("));
    assert_eq!(cooked.events.iter().filter(new).count(), 9, "{:#?}", cooked.events);
    assert!(!project.path("store").exists());
}

#[test]
fn a_dry_run_names_a_cells_own_change_before_what_its_inputs_may_bring() {
    let mut project = takes();
    project.cook();
    project.series("takes/a.txt", 100, |t| t as f64 + 1.0);
    project.options.dry = true;
    let cooked = project.cook_with(&["by=9.0"]);
    let scale = cooked.events.iter().find_map(|event| match event {
        Event::WouldCook { node, because, sure, .. } if node == "solve/scale@a" => Some((because.as_str(), *sure)),
        _ => None,
    });
    assert!(scale.is_some_and(|(because, sure)| sure && because.contains("parameter `by` changed")), "{scale:?}");
}
