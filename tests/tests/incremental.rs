//! What a change costs, on a real actor: nothing changed, one more take, one marker moved in one frame.
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use face_math::data::Markers;
use std::fs;
use whole_system::{Project, Run, root, test_data};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

struct Actor {
    project: Project,
}

impl Actor {
    /// The real actor's graph in a folder of its own, with its first take.
    fn new() -> Option<Self> {
        let data = test_data()?.join("actors");
        let project = Project::new(PROGRAM);
        project.copy(&root().join("graphs/fdls"), "graphs/fdls");
        project.copy(&root().join("graphs/fdls_ict"), "graphs/fdls_ict");
        project.copy(&data.join("ict_actor_a/ict_actor_a.glb"), "actor.glb");
        project.copy(&data.join("ict_actor_a/neutral_markers.csv"), "neutral.csv");
        project.copy(&data.join("regions.json"), "regions.json");
        project.copy(&data.join("ict_actor_a/rom"), "rom");
        project.copy(&data.join("ict_actor_a/takes/day1_161.c3d"), "takes/day1_161.c3d");
        Some(Self { project })
    }

    fn cook(&self) -> Run {
        let set = [
            "actor=actor.glb",
            "neutral_markers=neutral.csv",
            "regions=regions.json",
            "rom=rom/*.csv",
            "takes=takes/*.c3d",
            "epochs=1",
            "train.train.width=24",
            "train.train.blocks=1",
            "train.mixed_frames=0",
        ];
        let mut arguments = vec!["run", "graphs/fdls_ict", "--out", "solved", "--json"];
        arguments.extend(set.iter().flat_map(|set| ["--set", *set]));
        self.project.run(&arguments).ended_with(0)
    }
}

#[test]
fn a_change_costs_what_it_touches() {
    let Some(actor) = Actor::new() else { return };
    let first = actor.cook();
    assert_eq!((first.summary("failed"), first.summary("written")), (0, 3));
    let again = actor.cook();
    assert_eq!((again.summary("cooked"), again.summary("written")), (0, 0), "nothing changed, so nothing cooks");

    let data = test_data().unwrap().join("actors/ict_actor_a/takes");
    actor.project.copy(&data.join("day1_164.c3d"), "takes/day1_164.c3d");
    let more = actor.cook();
    let names: Vec<String> = more.cooked().into_iter().map(|(name, _)| name).collect();
    assert!(names.iter().all(|name| name.ends_with("@day1_164")), "one more take cooks its own nodes: {names:?}");
    assert_eq!(more.summary("written"), 3);
    // Some are quicker to have again than to keep; nothing that takes long is computed again.
    let cheap = ["edits", "takes", "solve/filled", "solve/steady", "solve/aligned", "solve/calm"];
    let remade = more.events_of("remade");
    let node = |event: &serde_json::Value| event["node"].as_str().unwrap().replace("@day1_164", "");
    assert!(remade.iter().all(|event| cheap.contains(&node(event).as_str())), "{remade:?}");

    // One marker moved by a millimetre in frame 1,000 of the first take.
    let path = actor.project.path("takes/day1_161.c3d");
    let take = face_io::c3d::read(&fs::read(&path).unwrap()).unwrap();
    fs::write(&path, moved(&take, "lip_outer_03", 1000)).unwrap();
    let edited = actor.cook();
    let cooked = edited.cooked();
    assert!(cooked.iter().all(|(name, _)| name.ends_with("@day1_161")), "{cooked:?}");
    for node in ["aligned", "solve/features", "solve/jaw", "solve/raw", "solve/fine", "raw_error", "error"] {
        let name = format!("solve/{node}@day1_161");
        let blocks = cooked.iter().find(|(cell, _)| *cell == name).map(|(_, blocks)| *blocks);
        assert!(matches!(blocks, Some(1)), "{name} cooked {blocks:?} blocks of 58: {cooked:?}");
    }
}

/// The take as a C3D file, one of its markers moved in one frame.
fn moved(take: &Markers, marker: &str, frame: usize) -> Vec<u8> {
    let mut positions = take.positions().to_vec();
    positions[frame * take.names().len() + take.index(marker).unwrap()].x += 0.001;
    face_io::c3d::write(
        &take.with_positions(positions).unwrap(),
        face_io::LengthUnit::Millimetre,
        face_io::c3d::Flavour::PLAIN,
    )
    .unwrap()
}
