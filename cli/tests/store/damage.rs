//! Bytes that changed on the disk are noticed, named, and made again.

use crate::common::Project;
use crate::{files, stored, written};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// The notices of a run that name a file.
fn notices(events: &[Value], file: &Path) -> Vec<String> {
    let notices = events.iter().filter(|event| event["event"] == "notice");
    let ours = notices.filter(|event| Path::new(event["about"].as_str().unwrap()).ends_with(file));
    ours.map(|event| event["message"].as_str().unwrap().to_owned()).collect()
}

/// What may happen to the bytes of a file: cut short, or one byte changed, at places from its beginning to its end.
fn damages(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let last = bytes.len() - 1;
    let mut all = Vec::new();
    for at in [0, 9, 17, 33, last / 2, last] {
        let at = at.min(last);
        let mut flipped = bytes.to_vec();
        flipped[at] ^= 0x41;
        all.push((format!("flipped at {at}"), flipped));
    }
    for length in [0, last / 2, last] {
        all.push((format!("cut to {length}"), bytes[..length].to_vec()));
    }
    all
}

#[test]
fn damage_anywhere_is_noticed_named_and_mended() {
    let project = crate::project();
    project.run(&["run", "graph.ron"]).expect(0);
    let sound = written(&project);
    let pristine: Vec<(PathBuf, Vec<u8>)> =
        stored(&project).into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect();
    // Two takes, a still one, and two files to write: an action and a pack each.
    assert_eq!(pristine.len(), 5 + 5 + 1, "{:?}", stored(&project));
    let restore = |project: &Project| {
        for part in ["actions", "packs", "sessions"] {
            fs::remove_dir_all(project.path(".grimace").join(part)).unwrap();
        }
        for (path, bytes) in &pristine {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
    };
    for (path, bytes) in &pristine {
        let within = path.strip_prefix(project.path(".grimace")).unwrap();
        for (what, damaged) in damages(bytes) {
            restore(&project);
            fs::write(path, &damaged).unwrap();
            let what = format!("{}: {what}", within.display());
            // Sessions know what actions say; and values are read where something needs them.
            let session = within.starts_with("sessions");
            let mut told = Vec::new();
            for arguments in [
                &["run", "graph.ron", "--json"][..],
                &["run", "graph.ron", "--json", "--set", "save.state_rate=false", "--set", "rate=30"],
            ] {
                if !session {
                    let _ = fs::remove_dir_all(project.path(".grimace/sessions"));
                }
                let _ = fs::remove_dir_all(project.path("out"));
                let ran = project.run(arguments).expect(0);
                told.extend(notices(&ran.json(), within));
                if !arguments.contains(&"--set") {
                    assert_eq!(written(&project), sound, "{what}");
                }
            }
            // A still take that nothing uses is never read.
            let read =
                !within.starts_with("packs") || !told.is_empty() || fs::read(path).is_ok_and(|now| now == damaged);
            assert!(read, "{what}: not noticed, and gone");
            if told.is_empty() {
                assert!(within.starts_with("packs"), "{what}: not noticed");
                let verified = project.run(&["cache", "verify", "--json"]).expect(1);
                let found: Vec<Value> = verified.json();
                assert!(Path::new(found[0]["file"].as_str().unwrap()).ends_with(within), "{what}: {found:?}");
            } else {
                assert!(
                    told.iter().all(|message| message.starts_with("was damaged; it was dropped, and ")),
                    "{told:?}"
                );
            }
            project.run(&["cache", "verify"]).expect(0);
        }
    }
}

#[test]
fn verify_names_and_drops_what_is_damaged() {
    let project = crate::project();
    project.run(&["run", "graph.ron"]).expect(0);
    let ran = project.run(&["cache", "verify", "graph.ron"]).expect(0);
    assert!(ran.out.contains("11 files of ") && ran.out.ends_with("read, all sound\n"), "{}", ran.out);
    let pack = files(&project.path(".grimace/packs")).remove(0);
    let mut bytes = fs::read(&pack).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&pack, bytes).unwrap();
    fs::write(project.path(".grimace/packs/notes.txt"), "ours").unwrap();
    let dry = project.run(&["cache", "verify", "--dry-run"]).expect(1);
    assert!(dry.err.contains(&format!("{}: its content", pack.file_name().unwrap().display())), "{}", dry.err);
    assert!(
        dry.err.contains("notes.txt is not of the store's making") && dry.out.contains("1 damaged\n"),
        "{}",
        dry.out
    );
    assert!(pack.is_file());
    let ran = project.run(&["cache", "verify", "--json"]).expect(1).json();
    assert_eq!(
        (&ran[0]["event"], &ran[0]["part"], &ran[0]["dropped"]),
        (&"damaged".into(), &"pack".into(), &true.into())
    );
    assert_eq!((&ran[1]["files"], &ran[1]["damaged"], &ran[1]["strangers"]), (&11.into(), &1.into(), &1.into()));
    assert!(!pack.exists() && project.path(".grimace/packs/notes.txt").is_file());
    project.run(&["cache", "verify"]).expect(0);
    let nowhere = project.run(&["cache", "verify", "--store", "nowhere"]).expect(2);
    assert!(nowhere.err.contains("there is no store at nowhere"), "{}", nowhere.err);
}

#[test]
fn eight_processes_at_once_write_the_same_bits_into_a_sound_store() {
    let project = crate::project();
    for take in 0..24 {
        project.long_take(&format!("takes/take_{take:02}.csv"), f64::from(take) / 24.0);
    }
    project.run(&["run", "graph.ron", "--store", "alone"]).expect(0);
    let alone = written(&project);
    fs::remove_dir_all(project.path("out")).unwrap();
    let started: Vec<_> =
        (0..8).map(|_| project.command(&["run", "graph.ron", "--json", "--jobs", "2"]).spawn().unwrap()).collect();
    for child in started {
        let ran = crate::common::Ran::of(child.wait_with_output().unwrap()).expect(0);
        assert_eq!(ran.summary()["failed"], 0);
        assert!(ran.json().iter().all(|event| event["event"] != "notice"), "{}", ran.out);
    }
    assert_eq!(written(&project), alone);
    project.run(&["cache", "verify"]).expect(0);
    let again = project.run(&["run", "graph.ron", "--json"]).expect(0).summary();
    assert_eq!((&again["cooked"], &again["written"]), (&0.into(), &0.into()));
    let of = |store: &str, part: &str| -> Vec<(PathBuf, Vec<u8>)> {
        let root = project.path(store);
        let files = files(&root.join(part)).into_iter();
        files.map(|path| (path.strip_prefix(&root).unwrap().into(), fs::read(&path).unwrap())).collect()
    };
    assert_eq!(of(".grimace", "packs"), of("alone", "packs"));
    assert_eq!(files(&project.path(".grimace/temporary")).len() + files(&project.path(".grimace/leases")).len(), 0);
}
