//! A folder of OBJ files as a rig: one item a file, so that an edited or added shape costs itself and the joining.

use whole_system::Project;

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

const GRAPH: &str = r#"(
    grimace: 1,
    nodes: {
        "sculpts": (kind: "load_rig", with: (path: "obj/*.obj", neutral: "rest.obj", unit: "cm")),
        "rig":     (kind: "join_shapes", in: {"heads": "sculpts"}),
        "rom":     (kind: "facs_sweep", in: {"rig": "rig"}),
        "save":    (kind: "save_animation", in: {"rig": "rig", "curves": "rom"}, with: (path: "rig.glb")),
    },
)"#;

/// A square whose first corner is lifted.
fn sculpt(lift: f32) -> String {
    format!("v 0 0 {lift}\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
}

#[test]
fn an_edited_shape_costs_itself_and_the_joining() {
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    for (name, lift) in [("rest", 0.0), ("a", 1.0), ("b", 2.0), ("a+b", 3.5), ("a@0.5", 0.75)] {
        project.write(&format!("obj/{name}.obj"), sculpt(lift));
    }
    project.run(&["run", "."]).ended_with(0);
    let facts = project.run(&["inspect", "rig.glb", "--json"]).ended_with(0).stdout;
    let facts: serde_json::Value = serde_json::from_str(&facts).unwrap_or_default();
    assert_eq!(facts["names"], serde_json::json!(["a", "b"]), "{facts}");
    assert_eq!((&facts["combinations"], &facts["in_betweens"]), (&1.into(), &1.into()), "{facts}");
    assert!(facts["frames"].as_u64().is_some_and(|frames| frames > 1), "{facts}");

    project.write("obj/b.obj", sculpt(2.25));
    let cooked = project.run(&["run", ".", "--json"]).ended_with(0).cooked();
    let names: Vec<&str> = cooked.iter().map(|(name, _)| name.as_str()).collect();
    assert!(names.contains(&"sculpts@b") && names.contains(&"rig"), "{names:?}");
    assert!(!names.contains(&"sculpts@a"), "{names:?}");

    project.write("obj/c.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    let run = project.run(&["run", "."]).ended_with(3);
    assert!(run.stderr.contains("c.obj") && run.stderr.contains("3 vertices"), "{}", run.stderr);
}
