//! Animated heads as USD, played by Pixar's own `UsdSkel`: all points must be where the rig itself poses them.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use face_io::{curves, gltf, no_sibling};
use face_math::data::{Curves, Rig};
use face_math::rig::{Puppet, SkinJawOptions, skin_jaw};
use glam::Vec3;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::Command;
use whole_system::{Project, Run, root, skipped, test_data};

const PROGRAM: &str = env!("CARGO_BIN_EXE_grimace-under-test");

const GRAPH: &str = r#"(
    grimace: 1,
    nodes: {
        "rig":    (kind: "load_rig", with: (path: "head.glb")),
        "curves": (kind: "load_curves", with: (path: "take.csv", rate_hz: 60)),
        "jaw":    (kind: "skin_jaw", in: {"rig": "rig"}),
        "save":   (kind: "save_animation", in: {"rig": "jaw", "curves": "curves"}, with: (path: "take.usda")),
        "plain":  (kind: "save_animation", in: {"rig": "rig", "curves": "curves"}, with: (path: "plain.usda")),
    },
)"#;

/// A Python that has USD: `GRIMACE_PYTHON`, the one of `tests/usd/venv`, or the system's.
fn python() -> Option<PathBuf> {
    let named = std::env::var_os("GRIMACE_PYTHON").map(PathBuf::from);
    let own = root().join("tests/usd/venv/bin/python");
    let candidates = named.into_iter().chain([own, PathBuf::from("python3")]);
    let has_usd = |python: &PathBuf| {
        let imported = Command::new(python).args(["-c", "from pxr import UsdSkel"]).output();
        imported.is_ok_and(|output| output.status.success())
    };
    let found = candidates.into_iter().find(has_usd);
    if found.is_none() {
        skipped(
            "there is no Python with USD; `python3 -m venv tests/usd/venv && tests/usd/venv/bin/pip install -r \
             tests/usd/requirements.txt` brings it",
        );
    }
    found
}

/// Writes the head with the curves as USD, and plays it.
fn played(python: &PathBuf, head: &[u8], take: &Curves, frames: &[i64]) -> [(Rig, Value); 2] {
    let project = Project::new(PROGRAM);
    project.write("graph.ron", GRAPH);
    project.write("head.glb", head);
    project.write("take.csv", curves::write(take, true).unwrap());
    project.run(&["run", "."]).ended_with(0);
    let rig = gltf::read(head, "head", &mut no_sibling).unwrap();
    let jawed = skin_jaw(&rig, &SkinJawOptions::default()).unwrap().rig;
    [("take.usda", jawed), ("plain.usda", rig)].map(|(file, rig)| {
        let mut command = Command::new(python);
        command.arg(root().join("tests/usd/check.py")).arg(project.path(file));
        command.args(frames.iter().map(ToString::to_string));
        let said = Run::of(&mut command).ended_with(0).stdout;
        (rig, serde_json::from_str(&said).unwrap())
    })
}

/// How far any point of a played file is from where the rig poses it, in metres.
fn farthest_m(rig: &Rig, take: &Curves, said: &Value, frame: i64) -> f32 {
    let take = take.arrange(&rig.channels, None).unwrap();
    let position = usize::try_from(frame - take.frame_axis().first).unwrap();
    let expected = Puppet::new(rig).unwrap().vertices(take.frame(position)).unwrap();
    let meshes: Vec<Vec<Vec3>> = serde_json::from_value(said["frames"][frame.to_string()].clone()).unwrap();
    let points: Vec<Vec3> = meshes.into_iter().flatten().collect();
    assert_eq!(points.len(), expected.len());
    points.iter().zip(&expected).map(|(point, expected)| point.distance(*expected)).fold(0.0, f32::max)
}

fn check(head: &[u8], take: &Curves, frames: &[i64]) {
    let Some(python) = python() else { return };
    for (rig, said) in played(&python, head, take, frames) {
        let axis = take.frame_axis();
        assert_eq!(said["faults"], json!([]));
        assert_eq!((&said["metersPerUnit"], &said["upAxis"]), (&json!(1.0), &json!("Y")));
        assert_eq!(said["timeCodesPerSecond"], json!(axis.rate_hz));
        let last = axis.first + axis.count as i64 - 1;
        let range = [axis.first, last].map(|frame| json!(frame as f64));
        assert_eq!([said["startTimeCode"].clone(), said["endTimeCode"].clone()], range);
        assert_eq!(said["provenance"]["grimace"]["frames"], json!(axis.count));
        assert_eq!(said["joints"], json!(["skull", "skull/jaw"]));
        assert_eq!(
            (said["blendShapes"].as_array().unwrap().len(), &said["keys"]),
            (rig.shapes.len(), &json!(axis.count))
        );
        for frame in frames {
            let far = farthest_m(&rig, take, &said, *frame);
            assert!(far < 1e-5, "{far} m in frame {frame}");
        }
        let moved = farthest_m(
            &rig,
            take,
            &json!({"frames": {frames[0].to_string(): said["frames"][frames[1].to_string()]}}),
            frames[0],
        );
        assert!(moved > 1e-3, "the head does not move: {moved} m");
    }
}

#[test]
fn a_procedural_head_plays_as_it_poses() {
    let options = sample_head::Options { density: 0.5, motion_frames: 600, ..Default::default() };
    let head = sample_head::build(&options).unwrap();
    let motion = &head.range_of_motion;
    let axis = wire::FrameAxis { first: 1001, ..motion.frame_axis() };
    let take = Curves::new(axis, motion.channels().to_vec(), motion.values().to_vec()).unwrap();
    check(&gltf::write(&head.rig, &Value::Null).unwrap(), &take, &[1001, 1300, 1301, 1450, 1600]);
}

#[test]
fn a_scanned_head_plays_as_it_poses() {
    let Some(data) = test_data() else { return };
    let read = |path: &str| std::fs::read(data.join("actors/ict_actor_a").join(path)).unwrap();
    let take = curves::read(&read("truth/day1_161.csv"), Some(60.0)).unwrap();
    check(&read("ict_actor_a.glb"), &take, &[0, 333, 900]);
}
