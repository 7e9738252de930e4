//! One edited frame beside a whole take: `graphs/fdls_ict` in an engine that stays, on a take of which first every marker of
//! every frame is moved a little, and then one marker of one frame. Needs the test data (`../shared/data`, or
//! `GRIMACE_TEST_DATA`) and trains the networks where STORE does not hold them.
//!
//!     cargo run --release --manifest-path benches/Cargo.toml -p edit-frame-bench [STORE] [ROUNDS]

// Names the crate, so that its kinds are in the program.
use nodes as _;

use cpu_time::ProcessTime;
use graph_core::cook::{Engine, Options};
use graph_core::document::Override;
use graph_core::plan::load;
use graph_core::store::Store;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// A C3D file of 32-bit floats: bytes before the first frame, and markers a frame.
struct Take {
    bytes: Vec<u8>,
    start: usize,
    markers: usize,
}

impl Take {
    fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).expect("the take can be read");
        let word = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
        let (markers, start) = (word(2), (word(16) - 1) * 512);
        assert!(bytes[15] & 0x80 != 0, "its scale is negative, so its points are floats");
        Self { bytes, start, markers }
    }

    fn frames(&self) -> usize {
        (self.bytes.len() - self.start) / (self.markers * 16)
    }

    /// Moves a marker along x by `by`, in the file's own unit.
    fn nudge(&mut self, frame: usize, marker: usize, by: f32) {
        let at = self.start + (frame * self.markers + marker) * 16;
        let place: &mut [u8; 4] = (&mut self.bytes[at..at + 4]).try_into().expect("four bytes");
        *place = (f32::from_le_bytes(*place) + by).to_le_bytes();
    }
}

/// Milliseconds of wall and CPU time until everything is up to date, and the blocks cooked.
fn cook(engine: &mut Engine) -> (f64, f64, usize) {
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    engine.rescan();
    let summary = engine.cook().expect("the cook goes through");
    assert_eq!(summary.failed, 0);
    (wall.elapsed().as_secs_f64() * 1e3, cpu.elapsed().as_secs_f64() * 1e3, summary.blocks_cooked)
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let store = arguments.next().map_or_else(|| folder.path().join("store"), PathBuf::from);
    let rounds = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(7);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let data = std::env::var_os("GRIMACE_TEST_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let mut take = Take::read(&data.join("actors/ict_actor_a/takes/day1_161.c3d"));
    let place = folder.path().join("day1_161.c3d");
    let write = |take: &Take| std::fs::write(&place, &take.bytes).expect("the take can be written");
    write(&take);

    let out = folder.path().join("out");
    let set = [format!("takes={}", place.display()), format!("out={}", out.display())];
    let overrides: Vec<Override> = set.iter().map(|text| Override::parse(text).expect("it can be set")).collect();
    let plan = load(&root.join("graphs/fdls_ict/graph.ron"), &overrides).expect("the graph is right");
    let options = Options { resident: true, only: vec!["solve".to_owned()], ..Options::default() };
    let mut engine = Engine::new(plan, &overrides, Arc::new(Store::at(&store)), options, Arc::default(), None)
        .expect("the engine can be made");
    cook(&mut engine);
    engine.remember().expect("the store can be written");

    let (frames, markers) = (take.frames(), take.markers);
    // Edits that no earlier run has made, so that the store holds none of their results.
    let seed = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.subsec_micros()) as f32 * 1e-9;
    let (mut whole, mut one) = ((f64::INFINITY, f64::INFINITY), Vec::new());
    for round in 0..rounds {
        for frame in 0..frames {
            for marker in 0..markers {
                take.nudge(frame, marker, ((frame * 7 + marker * 13 + round * 5) % 11) as f32 * 0.002 - 0.01 + seed);
            }
        }
        write(&take);
        let (wall, cpu, _) = cook(&mut engine);
        whole = (whole.0.min(wall), whole.1.min(cpu));
        take.nudge((round * 263 + 300) % frames, 50, 1.0);
        write(&take);
        one.push(cook(&mut engine));
    }
    println!(
        "{frames} frames, {markers} markers; {rounds} rounds; milliseconds from the written file to fine-tuned curves\n"
    );
    println!("{:<34} {:>9} {:>9} {:>8}", "", "wall", "CPU", "blocks");
    println!("{:<34} {:>9.1} {:>9.1}", "every frame edited, the least", whole.0, whole.1);
    one.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (name, (wall, cpu, blocks)) in [("least", one[0]), ("median", one[rounds / 2]), ("most", one[rounds - 1])] {
        let share = 100.0 * wall / whole.0;
        println!("{:<34} {wall:>9.1} {cpu:>9.1} {blocks:>8}   {share:.1}%", format!("one frame edited, the {name}"));
    }
}
