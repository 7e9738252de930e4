//! Cooks small projects, and asserts by the events which cells and blocks ran.

use crate::world::Project;
use graph_core::cook::{Engine, Event, Options, Session};
use graph_core::plan::load;
use std::sync::Arc;

const TAKES: &str = r#"(
    grimace: 1,
    params: { "takes": "takes/*.txt", "by": 3.0 },
    nodes: {
        "takes": (kind: "read", with: (path: "${takes}")),
        "solve": (for_each: "takes", graph: "solve.ron", with: (by: "${by}")),
        "total": (kind: "sum", in: {"series": "solve.series"}),
        "save":  (kind: "write", in: {"series": "solve.series"}, with: (path: "out/{take}.txt")),
    },
)"#;

const SOLVE: &str = r#"(
    grimace: 1,
    params: { "by": 1.0 },
    inputs: { "take": "Series" },
    outputs: { "series": "blur" },
    nodes: {
        "scale": (kind: "scale", in: {"series": "take"}, with: (by: "${by}")),
        "blur":  (kind: "blur", in: {"series": "scale"}, with: (halo: 2)),
    },
)"#;

pub fn takes() -> Project {
    let project = Project::new(TAKES);
    project.write("solve.ron", SOLVE);
    project.series("takes/a.txt", 100, |t| t as f64);
    project.series("takes/b.txt", 70, |t| (t * t) as f64);
    project
}

#[test]
fn a_second_cook_does_nothing_and_the_files_are_right() {
    let project = takes();
    let first = project.cook();
    assert_eq!(first.summary.failed, 0, "{:#?}", first.events);
    assert_eq!((first.summary.cooked, first.summary.cached, first.summary.written), (9, 0, 2));
    assert_eq!(first.summary.blocks_cooked, 2 * (4 + 3));
    assert!(project.read("out/a.txt").starts_with("3\n4.5\n6\n9\n"));
    let again = project.cook();
    assert_eq!((again.summary.cooked, again.summary.cached, again.summary.written), (0, 9, 0), "{:#?}", again.events);
    assert_eq!(again.summary.blocks_cached, 2 * (4 + 3));
}

#[test]
fn one_more_take_cooks_its_own_cone() {
    let project = takes();
    project.cook();
    project.series("takes/c.txt", 40, |t| -(t as f64));
    let names = project.cook().names();
    assert_eq!(names, ["save@c", "solve/blur@c", "solve/scale@c", "takes@c", "total"]);
    std::fs::remove_file(project.path("takes/c.txt")).unwrap();
    assert_eq!(project.cook().names(), Vec::<String>::new(), "without it, everything is known again");
}

#[test]
fn one_edited_frame_cooks_the_touched_blocks() {
    let project = takes();
    project.cook();
    project.series("takes/a.txt", 100, |t| if t == 40 { -1.0 } else { t as f64 });
    let cooked = project.cook();
    let expected = [("save@a", 0), ("solve/blur@a", 1), ("solve/scale@a", 1), ("takes@a", 0), ("total", 0)];
    assert_eq!(cooked.cooked(), expected.map(|(name, blocks)| (name.to_owned(), blocks)));
    // Frame 33 lies within the halo of the block before its own.
    project.series("takes/a.txt", 100, |t| match t {
        40 => -1.0,
        33 => 7.0,
        _ => t as f64,
    });
    let cooked = project.cook();
    assert!(cooked.cooked().contains(&("solve/blur@a".to_owned(), 2)), "{:?}", cooked.cooked());
    let incremental = project.read("out/a.txt");
    std::fs::remove_dir_all(project.path("store")).unwrap();
    project.cook();
    assert_eq!(project.read("out/a.txt"), incremental);
}

#[test]
fn an_equal_result_stops_the_change() {
    let project = Project::new(
        r#"(grimace: 1, nodes: {
            "read":  (kind: "read", with: (path: "a.txt")),
            "round": (kind: "round", in: {"series": "read"}),
            "scale": (kind: "scale", in: {"series": "round"}),
        })"#,
    );
    project.series("a.txt", 100, |t| t as f64);
    project.cook();
    project.series("a.txt", 100, |t| t as f64 + if t == 50 { 0.1 } else { 0.0 });
    assert_eq!(project.cook().cooked(), [("read".to_owned(), 0), ("round".to_owned(), 1)]);
}

#[test]
fn a_changed_parameter_goes_back_to_known_results() {
    let project = takes();
    project.cook();
    let names = project.cook_with(&["by=4.0"]).names();
    assert_eq!(names.len(), 7, "{names:?}");
    assert_eq!(project.cook().summary.cooked, 0, "the store still knows the first results");
    assert!(project.read("out/a.txt").starts_with("3\n4.5\n"), "and the files follow");
    assert_eq!(project.cook_with(&["solve.scale.by=5.0"]).summary.cooked, 7);
}

#[test]
fn list_outputs_repeat_what_follows() {
    let project = Project::new(
        r#"(grimace: 1, nodes: {
            "read":  (kind: "read", with: (path: "a.txt")),
            "split": (kind: "split", in: {"series": "read"}),
            "scale": (kind: "scale", in: {"series": "split"}),
            "all":   (kind: "sum", in: {"series": "split"}),
            "total": (kind: "sum", in: {"series": "scale"}),
            "add":   (kind: "add", in: {"series": "scale", "number": "total"}),
            "both":  (kind: "sum", in: {"series": ["scale", "add"]}),
        })"#,
    );
    project.series("a.txt", 35, |t| t as f64);
    let cooked = project.cook();
    assert_eq!(cooked.summary.failed, 0, "{:#?}", cooked.events);
    let scaled: Vec<_> = (0..4).map(|run| format!("scale@run{run}")).collect();
    assert!(scaled.iter().all(|name| cooked.names().contains(name)), "{:?}", cooked.names());
    let told = |name: &str| {
        cooked.events.iter().find_map(|event| match event {
            Event::Cooked { node, outputs, .. } if node == name => outputs.get("number").cloned(),
            _ => None,
        })
    };
    assert_eq!(told("all").as_deref(), Some("595"));
    assert_eq!(told("total").as_deref(), Some("1190"));
    assert_eq!(told("both").as_deref(), Some((1190.0 + 1190.0 + 35.0 * 1190.0).to_string().as_str()));
    project.series("a.txt", 36, |t| t as f64);
    let names = project.cook().names();
    assert!(names.contains(&"scale@run3".to_owned()) && !names.contains(&"scale@run0".to_owned()), "{names:?}");
}

#[test]
fn a_failing_item_fails_alone() {
    let project = takes();
    project.write("takes/bad.txt", "1\ntwo\n");
    let cooked = project.cook();
    assert_eq!((cooked.summary.failed, cooked.summary.written), (1, 2));
    let failed = cooked.events.iter().find_map(|event| match event {
        Event::Failed { node, error, place, .. } => Some((node.clone(), error.clone(), place.clone())),
        _ => None,
    });
    let (node, error, place) = failed.unwrap();
    assert_eq!(node, "takes@bad");
    assert!(error.contains("`two` is no number"), "{error}");
    assert!(place.ends_with("graph.ron:5:9"), "{place}");
    assert!(cooked.events.iter().any(|event| matches!(event, Event::Skipped { node, .. } if node == "total")));
    project.write("takes/bad.txt", "1\n2\n");
    let names = project.cook().names();
    assert_eq!(names, ["save@bad", "solve/blur@bad", "solve/scale@bad", "takes@bad", "total"]);
}

#[test]
fn a_panic_fails_alone_too() {
    let project = takes();
    let cooked = project.cook_with(&["solve.scale.by=2000.0"]);
    assert_eq!(cooked.summary.failed, 2, "{:#?}", cooked.events);
    assert!(
        cooked
            .events
            .iter()
            .any(|event| matches!(event, Event::Failed { error, .. } if error.contains("far too large")))
    );
}

#[test]
fn damaged_and_vanished_values_are_made_again() {
    let project = takes();
    project.cook();
    let mut packs = Vec::new();
    for folder in std::fs::read_dir(project.path("store/packs")).unwrap() {
        packs.extend(std::fs::read_dir(folder.unwrap().path()).unwrap().map(|file| file.unwrap().path()));
    }
    for (index, pack) in packs.iter().enumerate() {
        if index % 2 == 0 {
            let mut bytes = std::fs::read(pack).unwrap();
            let last = bytes.len() - 1;
            bytes[last] ^= 1;
            std::fs::write(pack, bytes).unwrap();
        } else {
            std::fs::remove_file(pack).unwrap();
        }
    }
    assert_eq!(project.cook().summary.cooked, 0, "no value is asked for, so none is missed");
    let cooked = project.cook_with(&["total.offset=1.0"]);
    assert_eq!((cooked.names(), cooked.summary.failed), (vec!["total".to_owned()], 0));
    assert!(cooked.summary.remade > 0);
    std::fs::remove_dir_all(project.path("out")).unwrap();
    let cooked = project.cook_with(&["total.offset=1.0"]);
    assert_eq!((cooked.summary.cooked, cooked.summary.written), (0, 2), "the files are written again");
}

#[test]
fn a_copied_project_recooks_nothing() {
    let project = takes();
    project.cook();
    let copy = tempfile::tempdir().unwrap();
    let status = std::process::Command::new("cp").arg("-r").arg(project.path(".")).arg(copy.path()).status().unwrap();
    assert!(status.success());
    let store = std::sync::Arc::new(graph_core::store::Store::at(&copy.path().join("store")));
    let cooked = crate::world::cook_at(&copy.path().join("graph.ron"), &store, &project.options, &[]);
    assert_eq!(cooked.summary.cooked, 0, "{:?}", cooked.names());
}

#[test]
fn a_list_that_fails_for_one_item_fails_alone() {
    let project = Project::new(
        r#"(grimace: 1, nodes: {
            "takes": (kind: "read", with: (path: "takes/*.txt")),
            "split": (kind: "split", in: {"series": "takes"}),
            "scale": (kind: "scale", in: {"series": "split"}),
            "total": (kind: "sum", in: {"series": "scale"}),
        })"#,
    );
    project.series("takes/a.txt", 20, |t| t as f64);
    project.write("takes/b.txt", "bad");
    let cooked = project.cook();
    assert_eq!(cooked.names(), ["scale@a/run0", "scale@a/run1", "split@a", "takes@a"]);
    let skipped: Vec<&str> = cooked
        .events
        .iter()
        .filter_map(|event| match event {
            Event::Skipped { node, because } if because == "takes@b" => Some(node.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(skipped, ["split@b", "scale@b", "total"]);
    project.series("takes/b.txt", 10, |t| t as f64 + 0.5);
    assert_eq!(project.cook().names(), ["scale@b/run0", "split@b", "takes@b", "total"]);
}

#[test]
fn a_file_changed_by_hand_is_kept() {
    let project = takes();
    project.cook();
    project.write("out/a.txt", "my own numbers\n");
    let cooked = project.cook();
    assert_eq!((cooked.summary.cooked, cooked.summary.written), (0, 1));
    assert_eq!(project.read("out/a.txt.kept-1"), "my own numbers\n");
    assert!(project.read("out/a.txt").starts_with("3\n"));
    let sidecar: serde_json::Value = serde_json::from_str(&project.read("out/a.txt.json")).unwrap();
    assert_eq!(sidecar["node"], "save@a");
    assert_eq!(sidecar["sources"].as_object().unwrap().len(), 1);
}

#[test]
fn results_are_the_same_for_any_number_of_threads_and_size_of_blocks() {
    let mut outputs = Vec::new();
    for (jobs, block_frames) in [(1, 32), (2, 1), (8, 7), (2, 1000)] {
        let mut project = takes();
        (project.options.jobs, project.options.block_frames) = (jobs, block_frames);
        project.cook();
        outputs.push((project.read("out/a.txt"), project.read("out/b.txt")));
    }
    assert!(outputs.iter().all(|output| *output == outputs[0]));
}

#[test]
fn results_are_the_same_where_cheap_ones_are_not_kept() {
    let (kept, mut cheap) = (takes(), takes());
    cheap.options.keep_cheap = false;
    for set in [&["by=3.0"][..], &["by=7.0"], &["by=3.0"]] {
        kept.cook_with(set);
        let cooked = cheap.cook_with(set);
        assert_eq!(cooked.summary.failed, 0, "{:#?}", cooked.events);
        assert_eq!(
            (cheap.read("out/a.txt"), cheap.read("out/b.txt")),
            (kept.read("out/a.txt"), kept.read("out/b.txt"))
        );
        assert_eq!(cheap.cook_with(set).summary.cooked, 0, "nothing changed");
    }
}

#[test]
fn values_that_memory_has_no_room_for_are_let_go_and_read_again() {
    const TAKE_BYTES: u64 = 5_000 * 8;
    let of_take = |take: usize| {
        format!(
            "\"read{take}\": (kind: \"read\", with: (path: \"takes/{take}.txt\")),\n\
             \"scale{take}\": (kind: \"scale\", in: {{\"series\": \"read{take}\"}}),\n"
        )
    };
    let gathered: Vec<String> = (0..20).map(|take| format!("\"scale{take}\"")).collect();
    let gathered = gathered.join(", ");
    let nodes: String = (0..20).map(of_take).collect();
    let cooked = [None, Some(8 * TAKE_BYTES)].map(|memory_bytes| {
        let total = format!("\"total\": (kind: \"sum\", in: {{\"series\": [{gathered}]}})");
        let mut project = Project::new(&format!("(grimace: 1, nodes: {{\n{nodes}{total}}})"));
        project.options = Options { memory_bytes, resident: true, ..project.options.clone() };
        for take in 0..20 {
            project.series(&format!("takes/{take}.txt"), 5_000, |t| (t * take) as f64);
        }
        let plan = load(&project.path("graph.ron"), &[]).unwrap();
        let mut engine =
            Engine::new(plan, &[], project.store(), project.options.clone(), Arc::default(), None).unwrap();
        assert_eq!(engine.cook().unwrap().cooked, 41);
        let held = engine.held_bytes();
        // All that is kept, and so all that was computed, by its digests.
        engine.remember().unwrap();
        let session = Session::load(&project.store(), &project.path("graph.ron"));
        (held, session.cells["total"].action.outputs.clone())
    });
    assert_eq!(cooked[0].1, cooked[1].1);
    assert!(cooked[0].0 >= 40 * TAKE_BYTES, "{} bytes", cooked[0].0);
    // The sum takes all twenty at once, whatever there is room for; afterwards they go again.
    assert!(cooked[1].0 <= 5 * TAKE_BYTES, "{} bytes", cooked[1].0);
}

#[test]
fn values_that_are_kept_nowhere_are_let_go_once_nobody_asks_for_them() {
    const FRAMES: usize = 40_000;
    let of_take = |take: usize| {
        format!(
            "\"read{take}\": (kind: \"read\", with: (path: \"takes/{take}.txt\")),\n\
             \"scale{take}\": (kind: \"scale\", in: {{\"series\": \"read{take}\"}}),\n\
             \"sum{take}\": (kind: \"sum\", in: {{\"series\": [\"scale{take}\"]}}),\n"
        )
    };
    let nodes: String = (0..20).map(of_take).collect();
    let mut project = Project::new(&format!("(grimace: 1, nodes: {{\n{nodes}}})"));
    let budget = 8 * 8 * FRAMES as u64;
    let memory_bytes = Some(budget);
    // Scaled values are computed sooner than read, so the store has none of them.
    project.options = Options { memory_bytes, resident: true, keep_cheap: false, jobs: 2, ..Options::default() };
    for take in 0..20 {
        project.series(&format!("takes/{take}.txt"), FRAMES, |t| (t * take) as f64);
    }
    let plan = load(&project.path("graph.ron"), &[]).unwrap();
    let mut engine = Engine::new(plan, &[], project.store(), project.options.clone(), Arc::default(), None).unwrap();
    let summary = engine.cook().unwrap();
    assert_eq!((summary.cooked, summary.failed), (60, 0));
    assert!(engine.held_bytes() <= budget, "{} bytes", engine.held_bytes());
    // They are there again for who looks at them.
    for take in [0, 19] {
        let values = engine.values(&format!("scale{take}"), "series").unwrap();
        assert_eq!(values[""].axis().unwrap().count, FRAMES);
    }
}

#[test]
fn what_two_nodes_compute_alike_is_computed_once() {
    let nodes = |count: usize, node: &dyn Fn(usize) -> String| (0..count).map(node).collect::<Vec<_>>().join(",\n");
    let alike = nodes(6, &|node| format!("\"sum{node}\": (kind: \"sum\", in: {{\"series\": [\"read\"]}})"));
    let read = "\"read\": (kind: \"read\", with: (path: \"take.txt\"))";
    let project = Project::new(&format!("(grimace: 1, nodes: {{\n{alike},\n{read}}})"));
    project.series("take.txt", 40, |t| t as f64);
    let cooked = project.cook();
    assert_eq!((cooked.summary.cooked, cooked.summary.cached), (2, 5), "{:#?}", cooked.events);
    // One that fails makes each of them fail, and holds up nothing.
    project.write("take.txt", "no number\n");
    let failed = project.cook();
    assert_eq!((failed.summary.failed, failed.summary.skipped), (1, 6), "{:#?}", failed.events);
    let panics =
        nodes(3, &|node| format!("\"scale{node}\": (kind: \"scale\", in: {{\"series\": \"read\"}}, with: (by: 2000))"));
    project.write("graph.ron", &format!("(grimace: 1, nodes: {{\n{panics},\n{read}}})"));
    project.series("take.txt", 40, |t| t as f64);
    let failed = project.cook();
    assert_eq!((failed.summary.failed, failed.summary.cached), (3, 1), "{:#?}", failed.events);
}
