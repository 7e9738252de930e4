//! Disks that are full, and disks that may only be read. They take a superuser to make; elsewhere these tests say that they
//! were skipped.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stderr, reason = "a test that is skipped says so loudly")]

use crate::{files, written};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Something mounted at a folder, for as long as this value lives.
struct Mounted(PathBuf);

impl Mounted {
    /// Mounts with the arguments given before the folder; `None` where this process may not.
    fn at(folder: &Path, arguments: &[&str]) -> Option<Self> {
        Self::mount(folder, arguments)?;
        Some(Self(folder.to_owned()))
    }

    fn mount(folder: &Path, arguments: &[&str]) -> Option<()> {
        let output = Command::new("mount").args(arguments).arg(folder).output().ok()?;
        if output.status.success() {
            return Some(());
        }
        eprintln!("SKIPPED: this process may not mount: {}", String::from_utf8_lossy(&output.stderr).trim());
        None
    }
}

impl Drop for Mounted {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_is_told_and_the_store_stays_sound() {
    let project = crate::project();
    let store = project.path("small");
    std::fs::create_dir(&store).unwrap();
    let Some(_disk) = Mounted::at(&store, &["-t", "tmpfs", "-o", "size=2m", "none"]) else { return };
    project.run(&["run", "graph.ron", "--store", "small"]).expect(0);
    let before = files(&store);
    let mut text = "frame,jawOpen,mouthSmile_L,browDown_L,cheekPuff_L,cheekPuff_R,browInnerUp_L\n".to_owned();
    for frame in 0..120_000 {
        writeln!(text, "{frame},0.1,0.2,0.3,0.4,0.5,0.{frame}").unwrap();
    }
    project.write("rom.csv", &text);
    let ran = project.run(&["run", "graph.ron", "--store", "small"]);
    assert!(matches!(ran.code, Some(2 | 3)), "{:?}: {}", ran.code, ran.err);
    for part in
        ["the store at small cannot be written", "No space left on device", "grimace cache gc --keep", "--store small"]
    {
        assert!(ran.err.contains(part), "{part}: {}", ran.err);
    }
    let json = project.run(&["run", "graph.ron", "--store", "small", "--json"]);
    assert_eq!(json.json().iter().rev().nth(1).unwrap()["event"], "diagnostic");
    assert_eq!((json.code, &json.summary()["cooked"]), (ran.code, &0.into()));
    assert!(before.iter().all(|file| file.is_file()), "nothing that stood there was lost");
    assert_eq!(files(&store.join("temporary")), Vec::<PathBuf>::new(), "no half file is left");
    project.run(&["cache", "verify", "--store", "small"]).expect(0);
    project.long_take("rom.csv", 1.0);
    let again = project.run(&["run", "graph.ron", "--store", "small", "--json"]).expect(0).summary();
    assert_eq!(again["failed"], 0);
}

#[test]
fn a_disk_that_may_only_be_read_is_told_and_stays_as_it_is() {
    let project = crate::project();
    project.run(&["run", "graph.ron", "--store", "kept"]).expect(0);
    let sound = written(&project);
    let store = project.path("kept");
    let kept = store.to_str().unwrap();
    let Some(_bound) = Mounted::at(&store, &["--bind", kept]) else { return };
    let Some(()) = Mounted::mount(&store, &["-o", "remount,ro,bind"]) else { return };
    let content =
        |_: &str| files(&store).into_iter().map(|file| (std::fs::read(&file).unwrap(), file)).collect::<Vec<_>>();
    let before = content("before");
    project.long_take("takes/c.csv", 0.75);
    let ran = project.run(&["run", "graph.ron", "--store", "kept"]).expect(2);
    for part in ["the store at kept cannot be written", "Read-only file system", "--store"] {
        assert!(ran.err.contains(part), "{part}: {}", ran.err);
    }
    assert_eq!(content("after"), before);
    assert_eq!(written(&project), sound, "nothing was cooked");
    project.run(&["cache", "verify", "--store", "kept"]).expect(0);
    let gc = project.run(&["cache", "gc", "--store", "kept", "--keep", "0"]).expect(1);
    assert!(gc.err.contains("cannot be removed"), "{}", gc.err);
    assert_eq!(content("after gc"), before);
    project.run(&["plan", "graph.ron", "--store", "kept"]).expect(0);
}
