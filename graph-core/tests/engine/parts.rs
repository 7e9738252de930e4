//! An edited frame in an engine that stays: no more frames are computed than see it.

use crate::random::Resident;
use crate::world::{COUNTED, Project};
use std::sync::atomic::Ordering;

#[test]
fn an_edited_frame_costs_the_frames_that_see_it() {
    let project = Project::new(
        r#"(
            grimace: 1,
            nodes: {
                "take":   (kind: "read", with: (path: "take.txt")),
                "before": (kind: "count", in: {"series": "take"}),
                "blur":   (kind: "blur", in: {"series": "before"}, with: (halo: 3)),
                "after":  (kind: "count", in: {"series": "blur"}),
                "save":   (kind: "write", in: {"series": "after"}, with: (path: "out/take.txt")),
            },
        )"#,
    );
    let value = |edited: &[usize], t: usize| if edited.contains(&t) { 500.0 + t as f64 } else { t as f64 };
    let save = |edited: &[usize]| project.series("take.txt", 320, |t| value(edited, t));
    save(&[]);
    let mut engine = Resident::open(&project, &project.options);
    let mut cost = |edited: &[usize]| {
        save(edited);
        engine.engine.rescan();
        COUNTED.store(0, Ordering::Relaxed);
        assert_eq!(engine.cook().summary.failed, 0);
        let expected = |t: usize| {
            let near: Vec<f64> = (t.saturating_sub(3)..=(t + 3).min(319)).map(|t| value(edited, t)).collect();
            near.iter().sum::<f64>() / near.len() as f64
        };
        let saved: Vec<f64> = project.read("out/take.txt").lines().map(|line| line.parse().unwrap()).collect();
        assert_eq!(saved, (0..320).map(expected).collect::<Vec<_>>());
        COUNTED.load(Ordering::Relaxed)
    };
    assert_eq!(cost(&[]), 640);
    assert_eq!(cost(&[100]), 1 + 7, "within a block");
    assert_eq!(cost(&[100, 128]), 1 + 7, "across two blocks, and beside an older edit");
    assert_eq!(cost(&[128]), 1 + 7, "taken back");
    assert_eq!(cost(&[128, 319]), 1 + 4, "at the end of the take");
    assert_eq!(cost(&[319]), 1 + 7);
    let all: Vec<usize> = (0..320).collect();
    assert_eq!(cost(&all), 640, "a new take");
}
