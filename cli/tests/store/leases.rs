//! Leases of cooks that run, were killed, or ran elsewhere.
#![cfg(unix)]

use crate::common::Project;
use crate::{age, files, stored};
use std::process::Child;
use std::time::{Duration, Instant};

/// A graph that cooks for minutes.
const LONG: &str = r#"(
    grimace: 1,
    nodes: { "actor": (kind: "sample_actor", with: (takes: 1000, frames: 100000)) },
)"#;

/// Starts a cook that takes long, and waits until its lease is there.
fn cooking(project: &Project) -> Child {
    project.write("long.ron", LONG);
    let child = project.command(&["run", "long.ron", "--jobs", "1"]).spawn().unwrap();
    let since = Instant::now();
    while files(&project.path(".grimace/leases")).is_empty() {
        assert!(since.elapsed() < Duration::from_mins(1), "no lease was taken");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

#[test]
fn a_running_cook_keeps_what_it_may_need_and_a_killed_one_keeps_nothing() {
    let project = crate::project();
    project.run(&["run", "graph.ron"]).expect(0);
    let all = stored(&project);
    let old: Vec<_> = files(&project.path(".grimace/packs")).into_iter().take(2).collect();
    for path in &old {
        age(path, 3);
    }
    let mut child = cooking(&project);
    let stat = project.run(&["cache", "stat"]).expect(0);
    assert!(stat.out.contains(&format!("a cook runs: process {} on ", child.id())), "{}", stat.out);
    let ran = project.run(&["cache", "gc", "--keep", "0"]).expect(0);
    assert!(ran.out.contains("removed 2 values") && ran.out.contains("that running cooks may need"), "{}", ran.out);
    assert!(all.iter().all(|path| path.exists() != old.contains(path)), "only what is older than the cook went");

    // Files in the making, of this process and of the one that is killed.
    let lease = files(&project.path(".grimace/leases")).remove(0);
    let name = lease.file_name().unwrap().to_str().unwrap();
    project.write(&format!(".grimace/temporary/{name}9"), "half a value");
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(lease.is_file(), "a killed process cleans nothing up");
    let stat = project.run(&["cache", "stat", "--json"]).expect(0).json().remove(0);
    assert_eq!(stat["cooks"], 0);
    if cfg!(target_os = "linux") {
        assert_eq!(stat["leftovers"], 2, "{stat}");
    }
    let ran = project.run(&["cache", "gc", "--keep", "0"]).expect(0);
    assert!(ran.out.contains("leftovers of dead processes"), "{}", ran.out);
    assert_eq!(stored(&project).len(), 0);
    assert_eq!(files(&project.path(".grimace/leases")).len() + files(&project.path(".grimace/temporary")).len(), 0);
}

#[test]
fn leases_of_other_hosts_count_until_they_expire() {
    let project = crate::project();
    project.run(&["run", "graph.ron"]).expect(0);
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_millis() as u64;
    let session = files(&project.path(".grimace/sessions")).remove(0);
    let name = session.iter().rev().take(2).map(|part| part.to_str().unwrap()).collect::<Vec<_>>();
    let lease = |until_ms: u64| {
        let session = format!("{}{}", name[1], name[0]);
        let record = serde_json::json!({
            "host": "farm-07", "pid": 41, "since_ms": now - 86_400_000, "until_ms": until_ms, "session": session,
        });
        project.write(".grimace/leases/farm-07~abc~41~7~0", &record.to_string());
    };
    // A day older than anything in the store, but its session names all of it.
    for path in &stored(&project) {
        age(path, 3);
    }
    lease(now + 600_000);
    let all = stored(&project);
    let ran = project.run(&["cache", "gc", "--keep", "0"]).expect(0);
    assert!(ran.out.contains("that running cooks may need"), "{}", ran.out);
    assert_eq!(stored(&project), all);
    lease(now - 1000);
    project.run(&["cache", "gc", "--keep", "0"]).expect(0);
    assert_eq!(stored(&project).len(), 0);
    assert_eq!(files(&project.path(".grimace/leases")).len(), 0);
}
