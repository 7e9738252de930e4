//! Edits of every sort, each with its true first cause: `plan` names it before the cook, and `why` after it.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use whole_system::Project;

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

const GRAPH: &str = r#"(
    grimace: 1,
    doc: "Takes, calmed twice.",
    params: {
        "sigma": 1.5,
        "takes": "takes/*.csv",
    },
    nodes: {
        // The range of motion.
        "rom":     (kind: "load_curves", with: (path: "rom.csv")),
        "second":  (kind: "load_curves", with: (path: "second.csv")),
        "regions": (kind: "load_regions", with: (path: "regions.json")),
        "takes":   (kind: "load_curves", with: (path: "${takes}")),
        "solve":   (for_each: "takes", graph: "solve.ron", with: (sigma: "${sigma}")),
        "calm":    (kind: "smooth_curves", in: {"curves": "rom"}, with: (filter: gaussian(sigma_frames: 2.0))),
        "after":   (kind: "smooth_curves", in: {"curves": "calm"}),
        "rig":     (kind: "load_rig", with: (path: "head.gltf")),
        "motion":  (kind: "range_of_motion", in: {"rig": "rig", "curves": "solve.curves"}, with: (ignore_unknown: true)),
        "save":    (kind: "save_curves", in: {"curves": "solve.curves"}, with: (path: "out/{take}.csv")),
    },
)
"#;

const SOLVE: &str = r#"(
    grimace: 1,
    params: { "sigma": 1.0 },
    inputs: { "take": "Curves" },
    outputs: { "curves": "calm" },
    nodes: {
        "calm": (kind: "smooth_curves", in: {"curves": "take"}, with: (filter: gaussian(sigma_frames: "${sigma}"))),
    },
)
"#;

fn curves(weight: &str) -> String {
    let frames: Vec<String> = (0..100).map(|frame| format!("{frame},{weight},{}\n", frame % 3)).collect();
    let frames = frames.concat();
    format!("# rate_hz: 60\nframe,jawOpen,mouthSmile_L\n{frames}")
}

fn project() -> Project {
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    project.write("solve.ron", SOLVE);
    for (name, weight) in [("takes/a", "0.1"), ("takes/b", "0.2"), ("rom", "0.3"), ("second", "0.4")] {
        project.write(&format!("{name}.csv"), curves(weight));
    }
    project.write("regions.json", r#"{"jaw": {"markers": ["chin"], "channels": ["jawOpen"]}}"#);
    head(&project, 0.5);
    project
}

/// A head of one triangle with the channel `jawOpen`, whose points lie in a file beside it.
fn head(project: &Project, opened: f32) {
    let triangle = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let moved = [0.0f32, 0.0, 0.0, 0.0, opened, 0.0, 0.0, 0.0, 0.0];
    let bytes: Vec<u8> = triangle.iter().chain(&moved).flat_map(|number| number.to_le_bytes()).collect();
    project.write("head.bin", bytes);
    let gltf = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0, "name": "face" }],
        "meshes": [{
            "primitives": [{ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": 1 }] }],
            "weights": [0.0], "extras": { "targetNames": ["jawOpen"] },
        }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 1, 0] },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 36 },
        ],
        "buffers": [{ "uri": "head.bin", "byteLength": 72 }],
    });
    project.write("head.gltf", gltf.to_string());
}

/// An edit, and what both commands must say of it.
struct Edit<'a> {
    what: &'a str,
    /// Does the edit; what it gives goes to `run` and `plan` as further arguments.
    does: &'a dyn Fn(&Project) -> Vec<&'static str>,
    /// The first cell to cook and its cause; empty where nothing cooks.
    cell: &'a str,
    cause: &'a str,
    /// A cell behind it, whose story must lead to the same cause.
    behind: &'a str,
}

/// Puts `new` in the place of `old`, which must stand in the file.
fn replace(project: &Project, file: &str, old: &str, new: &str) {
    let text = project.read(file);
    assert!(text.contains(old), "{file} does not hold {old}");
    project.write(file, text.replacen(old, new, 1));
}

const NOTHING: &str = "";

fn edits() -> Vec<Edit<'static>> {
    let edit = |what, does: &'static dyn Fn(&Project) -> Vec<&'static str>, cell, cause, behind| Edit {
        what,
        does,
        cell,
        cause,
        behind,
    };
    macro_rules! does {
        (|$project:ident| $body:expr) => {
            &|$project: &Project| {
                $body;
                Vec::new()
            }
        };
    }
    vec![
        edit(
            "a parameter",
            does!(|p| replace(p, "graph.ron", "sigma_frames: 2.0", "sigma_frames: 2.5")),
            "calm",
            r#"parameter `filter` changed from {"gaussian":{"sigma_frames":2.0}} to {"gaussian":{"sigma_frames":2.5}} (graph.ron:15:82)"#,
            "after",
        ),
        edit(
            "a node's parameter from the command line",
            &|_| vec!["--set", "after.channels=[\"jawOpen\"]"],
            "after",
            r#"parameter `channels` changed from [] to ["jawOpen"] (--set after.channels=["jawOpen"])"#,
            NOTHING,
        ),
        edit(
            "a parameter of the graph from the command line, which reaches a nested one",
            &|_| vec!["--set", "sigma=3.0"],
            "solve/calm@a",
            r#"parameter `filter` changed from {"gaussian":{"sigma_frames":1.5}} to {"gaussian":{"sigma_frames":3.0}} (--set sigma=3.0)"#,
            "save@a",
        ),
        edit(
            "a parameter of the graph",
            does!(|p| replace(p, "graph.ron", "\"sigma\": 1.5", "\"sigma\": 1.25")),
            "solve/calm@b",
            "(graph.ron:5:18)",
            "save@b",
        ),
        edit(
            "the default of a nested graph's parameter",
            does!(|p| {
                replace(p, "graph.ron", ", with: (sigma: \"${sigma}\")", "");
                replace(p, "solve.ron", "\"sigma\": 1.0", "\"sigma\": 2.0");
            }),
            "solve/calm@a",
            r#"from {"gaussian":{"sigma_frames":1.5}} to {"gaussian":{"sigma_frames":2.0}} (solve.ron:3:24)"#,
            "motion",
        ),
        edit(
            "a new take",
            does!(|p| p.write("takes/c.csv", curves("0.7"))),
            "takes@c",
            "its file is new (takes/c.csv)",
            "motion",
        ),
        edit(
            "a take that is gone",
            does!(|p| std::fs::remove_file(p.path("takes/b.csv")).unwrap()),
            "motion",
            "its input `curves` no longer has `b` (graph.ron:18:75)",
            NOTHING,
        ),
        edit(
            "other takes that fit the pattern",
            does!(|p| {
                p.write("other/x.csv", curves("0.9"));
                replace(p, "graph.ron", "takes/*.csv", "{takes,other}/*.csv");
            }),
            "takes@x",
            "its file is new (other/x.csv)",
            "save@x",
        ),
        edit(
            "a source file",
            does!(|p| p.write("rom.csv", curves("0.35"))),
            "rom",
            "its file changed (rom.csv)",
            "after",
        ),
        edit(
            "one frame of a take",
            does!(|p| replace(p, "takes/a.csv", "\n40,0.1,", "\n40,0.15,")),
            "takes@a",
            "its file changed (takes/a.csv)",
            "save@a",
        ),
        edit(
            "a file of regions",
            does!(|p| replace(p, "regions.json", "chin", "lip")),
            "regions",
            "its file changed (regions.json)",
            NOTHING,
        ),
        edit(
            "a file beside the source file",
            does!(|p| head(p, 0.75)),
            "rig",
            "a file that it reads beside its own changed (head.bin)",
            "motion",
        ),
        edit(
            "a connection",
            does!(|p| replace(p, "graph.ron", "{\"curves\": \"rom\"}", "{\"curves\": \"second\"}")),
            "calm",
            "its input `curves` is connected to `second.curves`, and was to `rom.curves` (graph.ron:15:59)",
            "after",
        ),
        edit(
            "one more connection",
            does!(|p| replace(
                p,
                "graph.ron",
                "\"curves\": \"solve.curves\"}, with: (ignore",
                "\"curves\": [\"solve.curves\", \"second\"]}, with: (ignore"
            )),
            "motion",
            "its input `curves` is connected to `solve.curves`, `second.curves`, and was to `solve.curves` (graph.ron:18:76)",
            NOTHING,
        ),
        edit(
            "another kind",
            does!(|p| {
                let sweep = "\"motion\":  (kind: \"facs_sweep\", in: {\"rig\": \"rig\"}),\n        \"save\": ";
                let text = p.read("graph.ron");
                let without: Vec<&str> = text.lines().filter(|line| !line.contains("\"motion\"")).collect();
                p.write("graph.ron", without.join("\n"));
                replace(p, "graph.ron", "\"save\": ", sweep);
            }),
            "motion",
            "its kind is now `facs_sweep`, and was `range_of_motion` (graph.ron:18:27)",
            NOTHING,
        ),
        edit(
            "a new node",
            does!(|p| replace(
                p,
                "graph.ron",
                "\"save\": ",
                "\"third\": (kind: \"smooth_curves\", in: {\"curves\": \"second\"}),\n\"save\": "
            )),
            "third",
            "it is new (graph.ron:19:9)",
            NOTHING,
        ),
        edit(
            "a node that nothing needs is gone",
            does!(|p| replace(
                p,
                "graph.ron",
                "\"after\":   (kind: \"smooth_curves\", in: {\"curves\": \"calm\"}),",
                ""
            )),
            NOTHING,
            NOTHING,
            NOTHING,
        ),
        edit(
            "a file written otherwise, with the same content",
            does!(|p| p.write("rom.csv", curves("0.30"))),
            "rom",
            "its file changed (rom.csv)",
            NOTHING,
        ),
        edit(
            "words and comments",
            does!(|p| {
                replace(p, "graph.ron", "calmed twice", "calmed, and calmed again");
                replace(p, "graph.ron", "// The range of motion.", "// What the actor did first.\n\n");
            }),
            NOTHING,
            NOTHING,
            NOTHING,
        ),
        edit(
            "the order of nodes",
            does!(|p| {
                let line = "        \"rom\":     (kind: \"load_curves\", with: (path: \"rom.csv\")),\n";
                replace(p, "graph.ron", line, "");
                replace(p, "graph.ron", "        \"save\": ", &format!("{line}        \"save\": "));
            }),
            NOTHING,
            NOTHING,
            NOTHING,
        ),
        edit(
            "the same value, written out though it is the default",
            does!(|p| replace(
                p,
                "graph.ron",
                "{\"curves\": \"calm\"})",
                "{\"curves\": \"calm\"}, with: (channels: []))"
            )),
            NOTHING,
            NOTHING,
            NOTHING,
        ),
        edit("a touched file", does!(|p| p.write("second.csv", curves("0.4"))), NOTHING, NOTHING, NOTHING),
    ]
}

#[test]
fn plan_and_why_name_the_first_cause_of_every_edit() {
    let mut wrong = Vec::new();
    for edit in edits() {
        let project = project();
        project.run(&["run", "graph.ron"]).ended_with(0);
        let arguments = (edit.does)(&project);
        let with = |command: &str| {
            let all: Vec<&str> = [command, "graph.ron"].into_iter().chain(arguments.iter().copied()).collect();
            project.run(&all).ended_with(0)
        };
        let planned = with("plan").stdout;
        let mut tell = |said: &str, text: &str| {
            wrong.push(format!("{}: {said} must say\n  {} {}\nand says\n{text}", edit.what, edit.cell, edit.cause));
        };
        if edit.cell.is_empty() {
            if !planned.lines().last().unwrap().starts_with("0 to cook, ") {
                tell("plan", &planned);
            }
        } else {
            let line = planned.lines().find(|line| line.split_whitespace().nth(1) == Some(edit.cell));
            if !line.is_some_and(|line| line.starts_with("cook ") && line.contains(edit.cause)) {
                tell("plan", &planned);
            }
        }
        let cooked = with("run").stderr;
        if edit.cell.is_empty() {
            if !cooked.lines().last().unwrap().starts_with("0 cooked, ") {
                tell("run", &cooked);
            }
            continue;
        }
        let told = project.run(&["why", "graph.ron", edit.cell]).ended_with(0).stdout;
        if !told.starts_with(&format!("{} was cooked in the last run: ", edit.cell)) || !told.contains(edit.cause) {
            tell("why", &told);
        }
        if !edit.behind.is_empty() {
            let told = project.run(&["why", "graph.ron", edit.behind]).ended_with(0).stdout;
            if !told.lines().last().unwrap().contains(edit.cause) || !told.contains(&format!("← {} ", edit.cell)) {
                tell("why of what is behind", &told);
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
