//! Snapshots as a user meets them: a wrong number fails exactly what depends on it and is named, what may not matter does not, and a
//! result that is cooked again for nothing is noticed by its hit count.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use whole_system::{Project, Run};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");
const WITH_FAULTS: &str = env!("CARGO_BIN_EXE_grimace-with-faults");

/// Three branches of one actor: calmed curves, raw ones, and a picture of the calmed ones.
const GRAPH: &str = r#"(
    grimace: 1,
    params: { "out": "out", "sigma_frames": 1.5, "takes": 2 },
    outputs: { "jitter": "jitter" },
    nodes: {
        "actor":  (kind: "sample_actor", with: (density: 0.5, rom_frames: 600, takes: "${takes}", frames: 60)),
        "rig":    (kind: "skin_jaw", in: {"rig": "actor.rig"}),
        "calm":   (kind: "smooth_curves", in: {"curves": "actor.truth"}, with: (filter: gaussian(sigma_frames: "${sigma_frames}"))),
        "jitter": (kind: "measure_jitter", in: {"markers": "actor.takes"}),
        "save":   (kind: "save_curves", in: {"curves": "calm"}, with: (path: "${out}/{take}.csv")),
        "raw":    (kind: "save_curves", in: {"curves": "actor.truth"}, with: (path: "${out}/{take}.raw.csv")),
        "sheet":  (kind: "render_faces", in: {"rig": "rig", "curves": "calm"}, with: (count: 2, size_px: 64, supersampling: 1)),
        "image":  (kind: "save_images", in: {"image": "sheet"}, with: (path: "${out}/{take}.png")),
    },
)"#;

fn accepted() -> Project {
    let project = Project::new(PROGRAM);
    project.write("show/graph.ron", GRAPH);
    project.run(&["snapshot", "accept", "show", "-q"]).ended_with(0);
    project
}

/// `output@item` of the values that failed.
fn failing(run: &Run) -> BTreeSet<String> {
    let failed = run.events_of("compared").into_iter().filter(|value| value["ok"] == false);
    failed.map(|value| format!("{}@{}", value["output"].as_str().unwrap(), value["item"].as_str().unwrap())).collect()
}

fn last(run: &Run) -> Value {
    run.events().pop().unwrap()
}

#[test]
fn what_was_accepted_is_readable_and_agrees() {
    let project = accepted();
    let files: BTreeSet<String> = fs::read_dir(project.path("show/golden/outputs"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let expected = ["actor.truth.ron", "calm.curves.ron", "jitter.noise.ron", "sheet.image.ron"];
    assert_eq!(files, expected.map(str::to_owned).into_iter().collect());
    let text = project.read("show/golden/outputs/calm.curves.ron");
    for part in ["kind: \"Curves\"", "\"take_00\": (", "60 frames from 0 at 60 Hz", "\"jawOpen\": (missing: 0, low: "] {
        assert!(text.contains(part), "{part}");
    }
    assert!(
        !project.path("out").exists() && !project.path("show/out").exists(),
        "a snapshot writes no file of the graph"
    );
    let again = project.run(&["snapshot", "check", "show", "--json"]).ended_with(0);
    assert_eq!((last(&again)["equal"].as_u64(), last(&again)["differing"].as_u64()), (Some(7), Some(0)));
    // Taken once more, nothing is written.
    let accepted = project.run(&["snapshot", "accept", "show", "--json"]).ended_with(0);
    assert_eq!(last(&accepted)["changed"], serde_json::json!([]));
}

#[test]
fn a_wrong_constant_fails_what_depends_on_it_and_is_named() {
    let project = accepted();
    // A width that someone mistyped.
    project.write("show/graph.ron", GRAPH.replace("\"sigma_frames\": 1.5", "\"sigma_frames\": 15.0"));
    let run = project.run(&["snapshot", "check", "show", "--json"]).ended_with(1);
    let expected = ["calm.curves@take_00", "calm.curves@take_01", "sheet.image@take_00", "sheet.image@take_01"];
    assert_eq!(failing(&run), expected.map(str::to_owned).into_iter().collect());
    for value in run.events_of("compared").iter().filter(|value| value["ok"] == false) {
        let first = &value["first"];
        let item = value["item"].as_str().unwrap();
        assert_eq!(
            (first["node"].as_str(), first["kind"].as_str()),
            (Some(format!("calm@{item}").as_str()), Some("smooth_curves"))
        );
        assert_eq!(first["because"], "its parameter `filter` changed");
        assert!(first["place"].as_str().unwrap().ends_with("graph.ron:8:9"), "{first}");
        let plot = fs::read_to_string(project.path(value["plot"].as_str().unwrap())).unwrap();
        assert!(plot.starts_with("<svg") && plot.contains("accepted") && plot.contains("found"));
        let worst = &value["differences"][0];
        for part in ["table", "column", "place", "expected", "found"] {
            assert!(worst[part].is_string(), "{worst}");
        }
    }
    let told = project.run(&["snapshot", "check", "show", "-q"]).ended_with(1).stdout;
    for part in [
        "✗ calm.curves@take_00 (Curves)",
        "frame ",
        "tolerance 0.001",
        "first to differ: calm@take_00 (smooth_curves)",
        "drawn in",
    ] {
        assert!(told.contains(part), "{part} in {told}");
    }
    // Put right again, all agree, and the plots are gone.
    project.write("show/graph.ron", GRAPH);
    project.run(&["snapshot", "check", "show", "-q"]).ended_with(0);
    assert_eq!(fs::read_dir(project.path("show/golden/failed")).unwrap().count(), 0);
}

#[test]
fn threads_stores_folders_and_the_order_of_files_fail_nothing() {
    let project = Project::new(PROGRAM);
    let graph = GRAPH.replace(
        "(kind: \"save_curves\", in: {\"curves\": \"actor.truth\"}",
        "(kind: \"save_curves\", in: {\"curves\": \"takes\"}",
    );
    let graph = graph.replace(
        "    nodes: {\n",
        "    nodes: {\n        \"takes\": (kind: \"load_curves\", with: (path: \"takes/*.csv\")),\n",
    );
    project.write("show/graph.ron", &graph);
    let curve = |rise: f64| {
        (0..40).fold(String::from("# rate_hz: 60\nframe,jawOpen\n"), |text, frame| {
            text + &format!("{frame},{}\n", f64::from(frame) * rise)
        })
    };
    for (name, rise) in [("b", 0.01), ("a", 0.02)] {
        project.write(&format!("show/takes/{name}.csv"), curve(rise));
    }
    project.run(&["snapshot", "accept", "show", "-q", "-j", "2"]).ended_with(0);
    let check = |arguments: &[&str]| {
        let arguments: Vec<&str> = ["snapshot", "check"].iter().chain(arguments).copied().collect();
        let run = project.run(&[&arguments[..], &["--json"]].concat()).ended_with(0);
        assert_eq!(last(&run)["equal"], last(&run)["values"], "{}", run.stdout);
    };
    check(&["show", "-j", "1"]);
    check(&["show", "--store", "elsewhere", "-j", "3"]);
    // The same project elsewhere, its files written in another order.
    project.copy(&project.path("show/golden"), "moved/golden");
    project.write("moved/graph.ron", &graph);
    for (name, rise) in [("a", 0.02), ("b", 0.01)] {
        project.write(&format!("moved/takes/{name}.csv"), curve(rise));
    }
    check(&["moved"]);
}

#[test]
fn a_result_that_is_cooked_again_for_nothing_fails_by_its_hit_count() {
    let project = Project::new(WITH_FAULTS);
    let graph = |restless: &str| {
        let pass = format!(
            "    nodes: {{\n        \"pass\": (kind: \"pass_curves\", in: {{\"curves\": \"calm\"}}, with: (restless: {restless})),\n"
        );
        GRAPH
            .replace("    nodes: {\n", &pass)
            .replace("in: {\"curves\": \"calm\"}, with: (path", "in: {\"curves\": \"pass\"}, with: (path")
    };
    project.write("show/graph.ron", graph("0.0"));
    project.run(&["snapshot", "accept", "show", "-q"]).ended_with(0);
    project.run(&["snapshot", "check", "show", "-q"]).ended_with(0);
    project.write("show/graph.ron", graph("0.5"));
    let run = project.run(&["snapshot", "check", "show", "--json"]).ended_with(1);
    assert_eq!(failing(&run), BTreeSet::new(), "its results are right");
    let second = &run.events_of("second_cook")[0];
    assert_eq!((second["ok"].as_bool(), second["found"]["cooked"].as_u64()), (Some(false), Some(2)));
    assert_eq!(second["cooked"], serde_json::json!(["pass@take_00", "pass@take_01"]));
    let told = project.run(&["snapshot", "check", "show", "-q"]).ended_with(1).stdout;
    assert!(told.contains("second cook computed 2 cells") && told.contains("pass@take_00"), "{told}");
}

#[test]
fn tolerances_set_by_hand_count_and_stay() {
    let project = accepted();
    let golden = "show/golden/outputs/calm.curves.ron";
    let loose = |text: String| text.replace("tolerances: {}", "tolerances: {\"weights\": (absolute: 2.0)}");
    project.write(golden, loose(project.read(golden)));
    let picture = "show/golden/outputs/sheet.image.ron";
    project
        .write(picture, project.read(picture).replace("tolerances: {}", "tolerances: {\"raster\": (absolute: 255.0)}"));
    project.write("show/graph.ron", GRAPH.replace("\"sigma_frames\": 1.5", "\"sigma_frames\": 2.0"));
    let run = project.run(&["snapshot", "check", "show", "--json"]).ended_with(0);
    assert_eq!(last(&run)["within"], 4);
    project.run(&["snapshot", "accept", "show", "-q"]).ended_with(0);
    assert!(project.read(golden).contains("tolerances: {\"weights\": (absolute: 2, relative: 0)}"));
}

#[test]
fn what_was_set_is_set_again_and_other_items_are_noticed() {
    let project = Project::new(PROGRAM);
    project.write("show/graph.ron", GRAPH);
    project.run(&["snapshot", "accept", "show", "-q", "--set", "takes=1"]).ended_with(0);
    assert!(project.read("show/golden/snapshot.ron").contains("set: [\"takes=1\"]"));
    let run = project.run(&["snapshot", "check", "show", "--json"]).ended_with(0);
    assert_eq!(last(&run)["values"], 4);
    let more = project.run(&["snapshot", "check", "show", "--json", "--set", "takes=2"]).ended_with(1);
    let fates: BTreeSet<String> =
        more.events_of("compared").iter().map(|value| value["agreement"].to_string()).collect();
    assert!(fates.contains("\"new\""), "{fates:?}");
}

#[test]
fn what_cannot_be_checked_is_told() {
    let project = Project::new(PROGRAM);
    project.write("show/graph.ron", GRAPH);
    let none = project.run(&["snapshot", "check", "show"]).ended_with(1);
    assert!(none.stderr.contains("there is no snapshot") && none.stderr.contains("accept"), "{}", none.stderr);
    project.write("bare.ron", "(grimace: 1, nodes: { \"actor\": (kind: \"sample_actor\") })");
    let bare = project.run(&["snapshot", "accept", "bare.ron"]).ended_with(2);
    assert!(bare.stderr.contains("outputs:"), "{}", bare.stderr);
    let wrong = GRAPH.replace("\"jitter\": \"jitter\"", "\"jitter\": \"jiter\"");
    project.write("show/graph.ron", wrong);
    let wrong = project.run(&["check", "show"]).ended_with(1);
    assert!(wrong.stderr.contains("did you mean `jitter`?"), "{}", wrong.stderr);
    project.write("show/graph.ron", GRAPH);
    project.run(&["snapshot", "accept", "show", "-q", "--set", "takes=1"]).ended_with(0);
    project.write("show/golden/snapshot.ron", "(set: [], second_cook: 7)");
    let broken = project.run(&["snapshot", "check", "show"]).ended_with(1);
    assert!(broken.stderr.contains("snapshot.ron:1:"), "{}", broken.stderr);
    assert!(Path::new(&project.path("show/golden")).is_dir());
}
