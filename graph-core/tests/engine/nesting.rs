//! Nested graphs: what their wires may refer to, and the mistakes that only nesting makes possible.

use crate::world::Project;
use graph_core::document::Diagnostics;
use graph_core::plan::load;

/// The mistakes in the project's graph: code, `file:line:col` and message of each.
fn mistakes(project: &Project) -> Vec<String> {
    let Diagnostics(all) = load(&project.path("graph.ron"), &[]).unwrap_err();
    all.iter().map(|mistake| format!("{}: {}", mistake.code, mistake.message)).collect()
}

#[test]
fn wires_kinds_and_nested_files_may_be_parameters() {
    let project = Project::new(
        r#"(
            grimace: 1,
            params: { "work": "scale", "source": "one", "file": "inner" },
            nodes: {
                "one":   (kind: "read", with: (path: "one.txt")),
                "two":   (kind: "read", with: (path: "two.txt")),
                "inner": (graph: "${file}.ron", in: {"series": "${source}"}),
                "out":   (kind: "${work}", in: {"series": "inner"}, with: (by: 10.0)),
                "save":  (kind: "write", in: {"series": "out"}, with: (path: "out.txt")),
            },
        )"#,
    );
    let inner = |by: &str| {
        r#"(grimace: 1, inputs: {"series": "Series"}, outputs: {"series": "scale"},
            nodes: {"scale": (kind: "scale", in: {"series": "series"}, with: (by: BY))})"#
            .replace("BY", by)
    };
    project.write("inner.ron", &inner("1.0"));
    project.write("other.ron", &inner("-1.0"));
    project.series("one.txt", 2, |t| t as f64);
    project.series("two.txt", 2, |t| t as f64 + 5.0);
    project.cook();
    assert_eq!(project.read("out.txt"), "0\n10\n");
    project.cook_with(&["source=two", &format!("file={}", project.path("other").display())]);
    assert_eq!(project.read("out.txt"), "-50\n-60\n");
}

#[test]
fn nested_inputs_are_held_against_the_types_they_declare() {
    let project = Project::new(
        r#"(
            grimace: 1,
            nodes: {
                "read":  (kind: "read", with: (path: "one.txt")),
                "total": (kind: "sum", in: {"series": "read"}),
                "inner": (graph: "inner.ron", in: {"series": "total", "more": "read"}),
            },
        )"#,
    );
    project.series("one.txt", 2, |t| t as f64);
    project.write(
        "inner.ron",
        r#"(grimace: 1, inputs: {"series": "Series", "more": "Serie"}, outputs: {"series": "scale"},
            nodes: {"scale": (kind: "scale", in: {"series": "series"}), "two": (kind: "scale", in: {"series": "more"})})"#,
    );
    let found = mistakes(&project);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found.iter().any(|text| text.starts_with("type-mismatch: input `series` of")), "{found:#?}");
    assert!(found.iter().any(|text| text == "unknown-type: there is no type `Serie`"), "{found:#?}");
}

#[test]
fn a_circle_through_nested_graphs_ends_in_a_mistake() {
    let project = Project::new(
        r#"(
            grimace: 1,
            nodes: {
                "one": (graph: "pass.ron", in: {"series": ["two", "two", "one"]}),
                "two": (graph: "pass.ron", in: {"series": ["one", "one", "two"]}),
                "sum": (kind: "sum", in: {"series": "one"}),
            },
        )"#,
    );
    project
        .write("pass.ron", r#"(grimace: 1, inputs: {"series": "[Series]"}, outputs: {"series": "series"}, nodes: {})"#);
    let found = mistakes(&project);
    assert!(found.iter().any(|text| text.starts_with("cycle: ") && text.contains("in a circle")), "{found:#?}");
}
