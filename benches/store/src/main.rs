//! The store beside the file system: 1 GiB of curves and meshes written and read back, each verified, against the same bytes
//! hashed with BLAKE3, written as plain files, read back and hashed again. Both sides sync what they write.
//!
//!     cargo run --release --manifest-path benches/Cargo.toml -p store-bench [ROUNDS] [FOLDER]

use cpu_time::ProcessTime;
use face_math::data::{Curves, Meshes};
use glam::Vec3;
use graph_core::store::{PackWriter, Store, ValueRecord};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use wire::{Digest, FrameAxis, Value};

/// Frames in a block, as the engine cuts values.
const BLOCK_FRAMES: usize = 32;
const MIB: usize = 1 << 20;

/// Takes of curves (53 channels) and of meshes (16,000 vertices), half of `bytes` each.
fn values(bytes: usize) -> Vec<Arc<dyn Value>> {
    let channels: Vec<String> = (0..53).map(|channel| format!("channel_{channel}")).collect();
    let mut seed = 1_u32;
    let mut noise = move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from_bits(0x3f80_0000 | seed >> 9) - 1.0
    };
    let mut made: Vec<Arc<dyn Value>> = Vec::new();
    let take_bytes = 8 * MIB;
    for _ in 0..bytes / 2 / take_bytes {
        let frames = take_bytes / (channels.len() * 4);
        let weights = (0..frames * channels.len()).map(|_| noise()).collect();
        let curves = Curves::new(FrameAxis::new(frames, 60.0), channels.clone(), weights).expect("sizes fit");
        made.push(Arc::new(curves));
    }
    let (vertices, take_bytes) = (16_000, 64 * MIB);
    for _ in 0..bytes / 2 / take_bytes {
        let frames = take_bytes / (vertices * 12);
        let positions = (0..frames * vertices).map(|_| Vec3::new(noise(), noise(), noise())).collect();
        made.push(Arc::new(
            Meshes::new(FrameAxis::new(frames, 60.0), Vec::new(), vertices, positions).expect("sizes fit"),
        ));
    }
    made
}

/// Seconds of wall time and of CPU time.
fn timed(work: impl FnOnce()) -> (f64, f64) {
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    work();
    (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64())
}

/// Writes all values, and gives their roots.
fn write_store(store: &Store, values: &[Arc<dyn Value>]) -> Vec<Digest> {
    let write = |value: &Arc<dyn Value>| {
        let (kind, axis) = (value.kind(), value.axis().expect("all of them have frames"));
        let mut pack = PackWriter::default();
        let mut digests = Vec::new();
        for start in (0..axis.count).step_by(BLOCK_FRAMES) {
            let block = value.slice(start..(start + BLOCK_FRAMES).min(axis.count)).expect("they can be sliced");
            let encoding = block.encoded();
            digests.push(kind.digest(&encoding));
            pack.push(digests[digests.len() - 1], Arc::new(encoding));
        }
        let root = ValueRecord::root(&kind, &digests);
        store.put_pack(&root, &pack.finish(&kind)).expect("the store takes it");
        root
    };
    values.iter().map(write).collect()
}

/// Reads all values back, verified and decoded.
fn read_store(store: &Store, values: &[Arc<dyn Value>], roots: &[Digest]) {
    for (value, root) in values.iter().zip(roots) {
        let kind = value.kind();
        let pack = store.pack(&kind, root).expect("it is sound").expect("it is there");
        let blocks: Vec<Arc<dyn Value>> = (0..pack.digests().len())
            .map(|block| (kind.decode)(pack.block(&kind, block).expect("it is sound")).expect("it decodes"))
            .collect();
        assert_eq!((kind.join)(&blocks).expect("blocks join").size(), value.size());
    }
}

fn write_plain(folder: &Path, bytes: &[Vec<u8>]) -> Vec<blake3::Hash> {
    let write = |(index, bytes): (usize, &Vec<u8>)| {
        let hash = blake3::hash(bytes);
        let temporary = folder.join(format!("{index}.part"));
        let mut file = fs::File::create(&temporary).expect("the file can be made");
        file.write_all(bytes).and_then(|()| file.sync_data()).expect("it can be written");
        fs::rename(&temporary, folder.join(index.to_string())).expect("it can be renamed");
        hash
    };
    bytes.iter().enumerate().map(write).collect()
}

fn read_plain(folder: &Path, hashes: &[blake3::Hash]) {
    for (index, hash) in hashes.iter().enumerate() {
        let bytes = fs::read(folder.join(index.to_string())).expect("it can be read");
        assert_eq!(blake3::hash(&bytes), *hash);
    }
}

fn main() {
    let rounds: usize = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(3);
    let parent = std::env::args().nth(2).unwrap_or_else(|| ".".to_owned());
    let values = values(1 << 30);
    let plain: Vec<Vec<u8>> = values.iter().map(|value| value.encoded()).collect();
    let mebibytes = plain.iter().map(Vec::len).sum::<usize>() as f64 / MIB as f64;
    let mut least = [(f64::INFINITY, f64::INFINITY); 4];
    for _ in 0..rounds {
        let folder = tempfile::tempdir_in(&parent).expect("a temporary folder can be made");
        let (ours, theirs) = (folder.path().join("store"), folder.path().join("plain"));
        fs::create_dir(&theirs).expect("the folder can be made");
        let store = Store::at(&ours);
        let (mut roots, mut hashes) = (Vec::new(), Vec::new());
        let times = [
            timed(|| roots = write_store(&store, &values)),
            timed(|| hashes = write_plain(&theirs, &plain)),
            timed(|| read_store(&store, &values, &roots)),
            timed(|| read_plain(&theirs, &hashes)),
        ];
        for (least, (wall, cpu)) in least.iter_mut().zip(times) {
            *least = (least.0.min(wall), least.1.min(cpu));
        }
    }
    println!("{} values, {mebibytes:.0} MiB; the least of {rounds} rounds, MiB a second\n", values.len());
    println!("{:<18} {:>10} {:>10}", "", "wall", "CPU");
    for (name, (wall, cpu)) in ["store, write", "plain, write", "store, read", "plain, read"].iter().zip(least) {
        println!("{name:<18} {:>10.0} {:>10.0}", mebibytes / wall, mebibytes / cpu);
    }
    let whole = |side: usize| (least[side].0 + least[side + 2].0, least[side].1 + least[side + 2].1);
    let (ours, theirs) = (whole(0), whole(1));
    println!("{:<18} {:>9.0}% {:>9.0}%", "store beside plain", 100.0 * theirs.0 / ours.0, 100.0 * theirs.1 / ours.1);
}
