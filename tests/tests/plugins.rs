//! Plugins as a user meets them: the examples in one graph, cached and snapshot-tested; a rebuilt one; a pinned one; hostile
//! ones beside honest branches.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use plugin_host::build::{build, component, missing_tools};
use plugin_host::sha256;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use whole_system::{Pane, Project, root};

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../plugins/examples")
}

fn project() -> Project {
    Project::new(env!("CARGO_BIN_EXE_grimace-under-test"))
}

/// The examples' graph with its plugins.
fn with_examples() -> Project {
    let project = project();
    for part in ["graph.ron", "golden"] {
        project.copy(&examples().join(part), part);
    }
    for plugin in ["smoothing", "limit", "envelope", "wrinkles"] {
        for file in ["plugin.ron".to_owned(), format!("{plugin}.wasm")] {
            let relative = format!("plugins/{plugin}/{file}");
            project.copy(&examples().join(&relative), &relative);
        }
    }
    project
}

/// A plugin called `id` made of the text of a module.
fn plant(project: &Project, id: &str, text: &str) {
    let manifest =
        format!("(id: \"{id}\", version: \"1\", api: \"0.1\", file: \"p.wasm\", limits: (memory_mb: 64, time_s: 0.3))");
    project.write(&format!("plugins/{id}/plugin.ron"), manifest);
    project.write(&format!("plugins/{id}/p.wasm"), component(text.as_bytes()).unwrap());
}

fn honest() -> String {
    std::fs::read_to_string(examples().join("plugins/limit/plugin.wat")).unwrap()
}

/// The honest plugin with `code` before its computation.
fn harmed(code: &str) -> String {
    let mark = "(local $last i32)";
    honest().replace(mark, &format!("{mark}\n{code}"))
}

#[test]
fn the_examples_cook_are_kept_and_hold_their_snapshot() {
    let project = with_examples();
    project.run(&["snapshot", "check", "graph.ron"]).ended_with(0);
    let again = project.run(&["run", "graph.ron", "--json"]).ended_with(0);
    assert_eq!((again.summary("cooked"), again.summary("failed")), (0, 0));
    let rest = project.run(&["run", "graph.ron", "--json"]).ended_with(0);
    assert_eq!(rest.summary("cooked"), 0);
}

#[test]
fn an_edited_frame_cooks_its_blocks_alone_through_plugins_that_work_per_frame() {
    let project = project();
    plant(&project, "limit", &honest());
    let csv = |edited: bool| {
        let row = |t: usize| format!("{t},{}\n", if edited && t == 70 { 0.9 } else { 0.25 + (t % 10) as f64 * 0.01 });
        format!("# rate_hz: 60\nframe,jawOpen\n{}", (0..200).map(row).collect::<String>())
    };
    project.write("take.csv", csv(false));
    project.write(
        "graph.ron",
        "(grimace: 1, nodes: {\
           \"raw\": (kind: \"load_curves\", with: (path: \"take.csv\")),\
           \"kept\": (kind: \"limit/limit\", in: {\"curves\": \"raw\"}, with: (most: 0.5)),\
           \"out\": (kind: \"save_curves\", in: {\"curves\": \"kept\"}, with: (path: \"out.csv\"))})",
    );
    project.run(&["run", "graph.ron", "--json"]).ended_with(0);
    project.write("take.csv", csv(true));
    let edited = project.run(&["run", "graph.ron", "--json"]).ended_with(0);
    assert!(edited.cooked().contains(&("kept".to_owned(), 1)), "{:?}", edited.cooked());
    assert!(project.read("out.csv").contains("\n70,0.5\n"));
}

#[test]
fn a_rebuilt_plugin_cooks_its_nodes_alone_and_why_says_so() {
    let project = with_examples();
    project.run(&["run", "graph.ron", "--json"]).ended_with(0);
    // The same computation in other bytes: its own nodes are cooked, and what they give is as before.
    let other = honest().replace("No value is above.", "Nothing is above it.");
    project.write("plugins/limit/limit.wasm", component(other.as_bytes()).unwrap());
    let rebuilt = project.run(&["run", "graph.ron", "--json"]).ended_with(0);
    let names: Vec<String> = rebuilt.cooked().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["bounded"]);
    let why = project.run(&["why", "graph.ron", "bounded"]).ended_with(0);
    assert!(why.stdout.contains("its plugin code changed from limit 1.0.0"), "{}", why.stdout);
}

#[test]
fn a_pinned_plugin_that_changed_is_an_error_until_it_is_accepted() {
    let project = with_examples();
    project.run(&["plugin", "accept", "graph.ron"]).ended_with(0);
    project.run(&["check", "graph.ron"]).ended_with(0);
    let other = honest().replace("No value is above.", "Nothing is above it.");
    let bytes = component(other.as_bytes()).unwrap();
    project.write("plugins/limit/limit.wasm", &bytes);
    let refused = project.run(&["check", "graph.ron"]).ended_with(1);
    assert!(refused.stderr.contains("plugin `limit` is not the one that"), "{}", refused.stderr);
    assert!(refused.stderr.contains(&sha256(&bytes)[..12]) && refused.stderr.contains("grimace plugin accept"));
    project.run(&["plugin", "accept", "graph.ron"]).ended_with(0);
    project.run(&["check", "graph.ron"]).ended_with(0);
}

#[test]
fn a_plugin_that_shadows_another_is_reported() {
    let project = with_examples();
    let elsewhere = project.path("elsewhere");
    project.copy(&project.path("plugins/limit"), "elsewhere/limit");
    let listed =
        project.command().env("GRIMACE_PLUGINS", &elsewhere).args(["plugin", "list", "graph.ron"]).output().unwrap();
    let text = String::from_utf8(listed.stdout).unwrap();
    assert!(
        text.contains("shadowed by plugins/limit/plugin.ron")
            || text.contains("shadowed by ./plugins/limit/plugin.ron"),
        "{text}"
    );
}

#[cfg(unix)]
#[test]
fn a_rebuilt_plugin_cooks_its_own_nodes_and_a_broken_one_waits_to_be_mended() {
    let project = project();
    project.write(
        "graph.ron",
        r#"(grimace: 1, nodes: {
            "takes": (kind: "load_curves", with: (path: "takes/*.csv")),
            "calm": (kind: "smooth_curves", in: {"curves": "takes"}, with: (filter: gaussian(sigma_frames: 1.5))),
            "kept": (kind: "limit/limit", in: {"curves": "calm"}, with: (most: 0.5)),
            "save": (kind: "save_curves", in: {"curves": "kept"}, with: (path: "out/{take}.csv"))})"#,
    );
    let take = |frames: usize| {
        let rows = (0..frames).map(|frame| format!("{frame},0.{:03}\n", (frame * 37 + frames) % 1000));
        format!("# rate_hz: 60\nframe,jawOpen\n{}", rows.collect::<String>())
    };
    let other = honest().replace("No value is above.", "Nothing is above it.");
    let built = |source: &str| component(source.as_bytes()).unwrap();
    project.copy(&examples().join("plugins/limit/plugin.ron"), "plugins/limit/plugin.ron");
    project.write("plugins/limit/limit.wasm", built(&honest()));
    project.write("takes/a.csv", take(40));
    let mut watch = whole_system::Watch::start(&project, &[]);
    watch.until_waiting_for(1);
    let before = watch.events.len();
    project.write("plugins/limit/limit.wasm", built(&other));
    watch.until("rebuilt node", |event| event["event"] == "cooked" && event["node"] == "kept@a");
    watch.until_waiting_for(1);
    let cooked: Vec<_> = watch.events[before..].iter().filter(|event| event["event"] == "cooked").collect();
    assert!(cooked.iter().all(|event| event["node"] == "kept@a"), "{cooked:?}");
    project.write("plugins/limit/limit.wasm", "no component");
    watch.until("diagnostic", |event| event["event"] == "diagnostic" && event["code"] == "broken-plugin");
    project.write("takes/b.csv", take(41));
    watch.until("take by the last good one", |event| event["event"] == "wrote" && event["node"] == "save@b");
    project.write("plugins/limit/limit.wasm", built(&honest()));
    watch.until_waiting_for(2);
    watch.stop(0);
    assert!(project.path("out/a.csv").is_file() && project.path("out/b.csv").is_file());
}

#[test]
fn the_editor_offers_plugins_and_takes_a_rebuilt_one_in() {
    let project = project();
    let take = |frame: usize| format!("{frame},0.{}\n", 2 + frame % 7);
    project.write("take.csv", format!("# rate_hz: 60\nframe,jawOpen\n{}", (0..40).map(take).collect::<String>()));
    project.write(
        "graph.ron",
        "(grimace: 1, nodes: {\n\
           \"raw\": (kind: \"load_curves\", with: (path: \"take.csv\")),\n\
           \"kept\": (kind: \"limit/limit\", in: {\"curves\": \"raw\"}, with: (most: 0.5)),\n})",
    );
    plant(&project, "limit", &honest());
    let program = env!("CARGO_BIN_EXE_grimace-under-test");
    let Some(pane) = Pane::open(program, "plugins", &project.path("graph.ron"), &[], (110, 32)) else { return };
    pane.wait_for("plugins: 1 kind");
    pane.press(&["r"]);
    pane.wait_for("2 cooked");
    // Its parameters stand in the form as those of any other node.
    pane.press(&["/", "k", "e", "p", "Enter", "e"]);
    pane.wait_for("most");
    pane.press(&["Escape"]);
    // Another build of it: its node is stale, and is cooked anew by the new code.
    plant(&project, "limit", &harmed("unreachable"));
    pane.wait_for("stale");
    pane.press(&["r"]);
    pane.wait_for("1 failed");
    // A broken one ends neither the editor nor what else is in the graph.
    project.write("plugins/limit/p.wasm", "no component");
    pane.wait_for("plugins: 0 kinds");
    plant(&project, "limit", &honest());
    pane.wait_for("plugins: 1 kind");
    pane.press(&["r"]);
    pane.wait_for("2 up to date");
    pane.press(&["q"]);
}

#[test]
fn hostile_plugins_fail_alone_and_nothing_of_them_is_kept() {
    let project = project();
    plant(&project, "limit", &honest());
    let hostile = [
        ("endless", "(loop $round (br $round))", "longer than the 0.3 s"),
        ("hungry", "(drop (memory.grow (i32.const 65000)))", "asked for 4063 MiB"),
        ("trapped", "unreachable", "trapped"),
        ("short", "(i32.store offset=52 (i32.load offset=8 (local.get $inputs)) (i32.const 1))", "1 numbers where"),
    ];
    let mut nodes = String::from(
        "\"actor\": (kind: \"sample_actor\"), \"fine\": (kind: \"limit/limit\", in: {\"curves\": \"actor.rom\"}),",
    );
    for (id, code, _) in hostile {
        plant(&project, id, &harmed(code));
        write!(nodes, "\"{id}\": (kind: \"{id}/limit\", in: {{\"curves\": \"actor.rom\"}}),").unwrap();
        write!(nodes, "\"after_{id}\": (kind: \"limit/limit\", in: {{\"curves\": \"{id}\"}}),").unwrap();
    }
    project.write("graph.ron", format!("(grimace: 1, nodes: {{{nodes}}})"));
    for _ in 0..2 {
        // The second cook finds none of the failures in the store, and tries again.
        let run = project.run(&["run", "graph.ron", "--json"]).ended_with(3);
        assert_eq!(run.summary("failed"), 4);
        for (id, _, told) in hostile {
            let failed = run.events_of("failed").into_iter().find(|event| event["node"] == id).unwrap().to_string();
            assert!(failed.contains(told) && failed.contains(&format!("`{id}`")), "{failed}");
        }
        assert!(run.stdout.contains("\"fine\""));
    }
}

/// Whether a component says nothing of where it was built: paths of a machine would also make other bytes on another.
fn assert_tells_no_place(component: &Path) {
    let bytes = std::fs::read(component).unwrap();
    let bytes = String::from_utf8_lossy(&bytes);
    for place in ["/.cargo/", root().to_str().unwrap()] {
        assert!(!bytes.contains(place), "{} tells of {place}", component.display());
    }
}

#[test]
fn the_examples_tell_of_no_machine() {
    for plugin in ["limit", "smoothing", "wrinkles", "envelope"] {
        assert_tells_no_place(&examples().join(format!("plugins/{plugin}/{plugin}.wasm")));
    }
}

#[test]
fn what_is_built_from_the_sources_computes_what_the_components_beside_them_do() {
    for (plugin, language) in
        [("limit", "wat"), ("smoothing", "rust"), ("wrinkles", "c"), ("envelope", "assemblyscript")]
    {
        if let Some(tool) = missing_tools(language) {
            #[allow(clippy::print_stderr, reason = "what was not tested is told loudly")]
            {
                eprintln!("SKIPPED: {plugin} is not rebuilt: this machine has not {tool}");
            }
            continue;
        }
        let project = with_examples();
        let built = build(&examples().join("plugins").join(plugin), Some(&project.path("built.wasm")));
        built.unwrap_or_else(|problem| panic!("{plugin}: {problem}"));
        assert_tells_no_place(&project.path("built.wasm"));
        let component = format!("plugins/{plugin}/{plugin}.wasm");
        std::fs::rename(project.path("built.wasm"), project.path(&component)).unwrap();
        project.run(&["snapshot", "check", "graph.ron"]).ended_with(0);
    }
}

#[test]
fn new_plugins_build_and_pass_their_trial() {
    let project = project();
    project.run(&["new", "plugin", "calm", "--lang", "wat"]).ended_with(0);
    project.run(&["plugin", "build", "calm"]).ended_with(0);
    let tried = project.run(&["plugin", "test", "calm"]).ended_with(0);
    assert!(tried.stdout.contains("blocks and whole") && tried.stdout.contains("all is well"), "{}", tried.stdout);
    let inspected = project.run(&["plugin", "inspect", "calm", "--json"]).ended_with(0);
    assert!(inspected.stdout.contains("\"calm/limit\""), "{}", inspected.stdout);
    project.run(&["new", "plugin", "calm"]).ended_with(1);
    project.run(&["new", "plugin", "Calm!"]).ended_with(1);
}

#[test]
fn a_new_rust_plugin_brings_the_sdk_and_its_node_runs_natively_in_its_own_tests() {
    let project = project();
    project.run(&["new", "plugin", "calm", "--lang", "rust"]).ended_with(0);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut tests = std::process::Command::new(cargo);
    tests.current_dir(project.path("calm")).args(["test", "--offline"]).env_remove("CARGO_TARGET_DIR");
    let output = tests.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("values_are_multiplied ... ok"), "{output:?}");
}
