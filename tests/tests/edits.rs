//! Keys that an artist sets over a solve, through the program: what they change, what that costs, and how they are taken back.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use std::collections::BTreeMap;
use whole_system::{Project, Run, root};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

fn project() -> Project {
    let project = Project::new(PROGRAM);
    project.copy(&root().join("graphs/fdls"), "fdls");
    project
}

fn cook(project: &Project) -> Run {
    let set = [
        "epochs=1",
        "actor.takes=2",
        "actor.frames=96",
        "actor.density=0.5",
        "actor.rom_frames=600",
        "train.train.width=16",
        "train.train.blocks=1",
        "train.mixed_frames=0",
    ];
    let mut arguments = vec!["run", "fdls", "--out", "solved", "--json"];
    arguments.extend(set.iter().flat_map(|set| ["--set", *set]));
    project.run(&arguments)
}

/// The columns of a table of curves, by channel.
fn curves(project: &Project, name: &str) -> BTreeMap<String, Vec<f64>> {
    let text = project.read(&format!("solved/{name}"));
    let mut rows = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let names = rows.next().unwrap();
    for row in rows {
        for (name, cell) in names.iter().zip(row) {
            columns.entry((*name).to_owned()).or_default().push(cell.parse().unwrap());
        }
    }
    columns
}

#[test]
fn a_jaw_key_moves_the_jaw_and_what_follows_it_in_one_take_and_can_be_taken_back() {
    let project = project();
    cook(&project).ended_with(0);
    let solved = [curves(&project, "take_00.csv"), curves(&project, "take_00.raw.csv")];
    let other = project.read("solved/take_01.csv");
    let frames: Vec<i64> = solved[0]["frame"].iter().map(|frame| *frame as i64).collect();
    let (at, frame) = (40, frames[40].to_string());

    let key = ["edit-key", "take_00", "jawOpen", &frame, "0.9", "--edits", "fdls/edits.ron"];
    let told = project.run(&key).ended_with(0);
    assert!(told.stderr.contains("`jawOpen` of take `take_00` is 0.9"), "{}", told.stderr);
    assert!(
        told.stderr.contains(&format!("to go back: grimace edit-key take_00 jawOpen {frame} --remove")),
        "{}",
        told.stderr
    );
    let written = project.read("fdls/edits.ron");
    assert!(written.contains("// What artists set by hand") && written.contains("value: 0.9"), "{written}");

    let run = cook(&project).ended_with(0);
    let cooked: Vec<String> = run.cooked().into_iter().map(|(name, _)| name).collect();
    let alone =
        |name: &str| name == "edits" || name.contains("own_edits@") || name.contains("@take_00") || !name.contains('@');
    assert!(cooked.iter().all(|name| alone(name)), "a key of one take cooks that take alone: {cooked:?}");
    assert!(!cooked.iter().any(|name| name.starts_with("train")), "{cooked:?}");
    assert_eq!(project.read("solved/take_01.csv"), other);
    let edited = [curves(&project, "take_00.csv"), curves(&project, "take_00.raw.csv")];
    assert!((edited[0]["jawOpen"][at] - 0.9).abs() < 1e-6, "{}", edited[0]["jawOpen"][at]);
    let differs =
        |which: usize, channel: &str, at: usize| (edited[which][channel][at] - solved[which][channel][at]).abs() > 1e-6;
    // Networks of the lips see the jaw: with another one, they solve something else.
    let followers: Vec<&String> =
        solved[1].keys().filter(|channel| !channel.starts_with("jaw") && differs(1, channel, at)).collect();
    assert!(followers.iter().any(|channel| channel.starts_with("mouth")), "{followers:?}");
    for far in [0, 80] {
        assert!(solved[0].keys().all(|channel| !differs(0, channel, far)), "frame {far} is far from the key");
    }

    let back = ["edit-key", "take_00", "jawOpen", &frame, "--remove", "--edits", "fdls/edits.ron"];
    project.run(&back).ended_with(0);
    cook(&project).ended_with(0);
    assert_eq!(curves(&project, "take_00.csv"), solved[0]);
}

#[test]
fn keys_that_cannot_be_are_told() {
    let project = project();
    let wrong = |arguments: &[&str], what: &str| {
        let told = project.run(arguments).ended_with(2);
        assert!(told.stderr.contains(what), "{}", told.stderr);
    };
    wrong(&["edit-key", "a", "jawOpen", "3", "--remove"], "edits.ron");
    wrong(&["edit-key", "a", "jawOpen", "3"], "VALUE");
    wrong(&["edit-key", "a", "jawOpen", "3", "nan"], "is no weight");
    project.write("edits.ron", "(takes: {\n    \"a\": (keys: {\"jawOpen\": [(frame: 3)]}),\n})\n");
    wrong(&["edit-key", "a", "jawOpen", "4", "0.5"], "frame 3: a key has either a `value` or an `offset`");
    project.write(
        "edits.ron",
        "// mine\n(takes: {\n    // the first\n    \"a\": (keys: {\"jawOpen\": [(frame: 3, value: 0.25)]}),\n})\n",
    );
    let told = project.run(&["edit-key", "a", "jawOpen", "-2", "-0.5", "--offset", "--curve", "hold"]).ended_with(0);
    assert!(told.stderr.contains("--remove"), "{}", told.stderr);
    let told = project.run(&["edit-key", "a", "jawOpen", "3", "0.5"]).ended_with(0);
    assert!(
        told.stderr.contains("to go back: grimace edit-key a jawOpen 3 0.25 --falloff 8 --curve smooth"),
        "{}",
        told.stderr
    );
    project.run(&["edit-key", "b", "smile", "7", "0.5"]).ended_with(0);
    let text = project.read("edits.ron");
    let keys = "\"a\": (keys: {\"jawOpen\": [(frame: -2, offset: -0.5, curve: hold), (frame: 3, value: 0.5)]}),";
    assert!(text.starts_with("// mine\n") && text.contains("    // the first\n") && text.contains(keys), "{text}");
    assert!(text.contains("\"b\": (keys: {\"smile\": [(frame: 7, value: 0.5)]})"), "{text}");
    wrong(&["edit-key", "a", "jawOpen", "8", "--remove"], "its keys there are at -2, 3");

    // A channel that the curves do not have fails its own take, and says where the key is.
    project.run(&["edit-key", "take_00", "jawOpne", "3", "0.5", "--edits", "fdls/edits.ron"]).ended_with(0);
    let run = cook(&project).ended_with(3);
    let failed = run.events_of("failed");
    assert_eq!(failed.len(), 1, "{failed:?}");
    let told = failed[0]["error"].as_str().unwrap();
    assert!(
        failed[0]["node"].as_str().unwrap().ends_with("@take_00") && told.contains("did you mean `jawOpen`?"),
        "{told}"
    );
}
