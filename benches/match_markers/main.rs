//! Solves Eq. 2 of FDLS for every frame of a real take, tells its CPU time, and writes the problem and the answer for
//! `compare.py`, which solves it with `SciPy` and Clarabel.
//!
//! Files in the folder given as the argument, little-endian 64-bit floats: `basis.bin` (rows × channels), `offsets.bin`
//! (frames × rows), `weights.bin` (frames × channels, as 32-bit floats), and `ours.json` with the sizes and times.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot read its files has nothing to say")]

use face_io::{c3d, gltf, marker_csv, no_sibling};
use face_math::clean::{GapOptions, fill_gaps};
use face_math::rig::{AttachOptions, MarkerRig, SkinJawOptions, attach_markers, skin_jaw};
use face_math::solve::{LinearPuppet, MatchOptions};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// CPU time of this thread in seconds, as Linux counts it; wall time elsewhere.
fn cpu_seconds(start: Instant) -> f64 {
    let counted = fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = counted.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |nanoseconds| nanoseconds * 1e-9)
}

fn main() {
    let data = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let actor = data.join("actors/ict_actor_a");
    let Some(folder) = std::env::args().skip(1).find(|argument| !argument.starts_with("--")) else { return };
    let folder = PathBuf::from(folder);
    fs::create_dir_all(&folder).unwrap();
    let read = |name: &str| fs::read(actor.join(name)).unwrap();
    let scan = gltf::read(&read("ict_actor_a.glb"), "ict_actor_a", &mut no_sibling).unwrap();
    let neutral = marker_csv::read(&read("neutral_markers.csv"), Some(1.0)).unwrap();
    let rig = skin_jaw(&scan, &SkinJawOptions::default()).unwrap().rig;
    let attachment = attach_markers(&rig, &neutral, &AttachOptions::default()).unwrap().attachment;
    let puppet = MarkerRig::attached(&rig, &attachment).unwrap();
    let take = c3d::read(&read("takes/day1_161.c3d")).unwrap();
    let take = fill_gaps(&take, Some(&neutral), None, &GapOptions::default()).unwrap().markers;

    let options = MatchOptions::default();
    let linear = LinearPuppet::new(&puppet, &take, options).unwrap();
    let weights = linear.solve(&take).unwrap();
    // Until a second has passed, so that the clock's steps and the first touch of memory do not count.
    let (wall, mut rounds) = (Instant::now(), 0);
    let before = cpu_seconds(wall);
    while wall.elapsed().as_secs_f64() < 1.0 {
        assert_eq!(linear.solve(&take).unwrap().frames(), take.frames());
        rounds += 1;
    }
    let seconds = (cpu_seconds(wall) - before) / f64::from(rounds);

    let bytes = |numbers: &[f64]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>();
    let offsets: Vec<f64> = (0..take.frames()).flat_map(|frame| linear.offsets(&take, frame)).collect();
    fs::write(folder.join("basis.bin"), bytes(linear.basis())).unwrap();
    fs::write(folder.join("offsets.bin"), bytes(&offsets)).unwrap();
    let values = weights.values().iter().flat_map(|weight| weight.to_le_bytes()).collect::<Vec<_>>();
    fs::write(folder.join("weights.bin"), values).unwrap();
    let (frames, channels) = (take.frames(), weights.channels().len());
    let rows = linear.basis().len() / channels;
    let text = format!(
        "{{\"frames\": {frames}, \"rows\": {rows}, \"channels\": {channels}, \"cpu_seconds\": {seconds}, \"rounds\": {rounds}}}\n"
    );
    fs::write(folder.join("ours.json"), text).unwrap();
}
