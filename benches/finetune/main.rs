//! Fine-tunes a real take on the whole nonlinear puppet with all channels, tells its time, and writes the puppet, the
//! objective's numbers and the answer for `compare.py`, which solves it with `SciPy`.
//!
//! Files in the folder given as the argument, little-endian 64-bit floats, and `ours.json` with sizes, drivers and times.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot read its files has nothing to say")]

use face_io::{c3d, gltf, marker_csv, no_sibling};
use face_math::clean::{GapOptions, fill_gaps};
use face_math::data::{Attachment, Driver, Rig};
use face_math::rig::{AttachOptions, MarkerRig, SkinJawOptions, attach_markers, skin_jaw};
use face_math::solve::{FinetuneOptions, MatchOptions, finetune, match_markers};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Vectors of all markers that follow the jaw, and of those that follow the skull, of one column of the puppet.
type Split = [Vec<DVec3>; 2];

/// What positions or displacements of vertices mean for the markers.
fn split(rig: &Rig, attachment: &Attachment, vectors: &BTreeMap<u32, Vec3>) -> Split {
    let jaw = &rig.jaw.as_ref().unwrap().weights;
    let mut split = [0, 1].map(|_| vec![DVec3::ZERO; attachment.points.len()]);
    for (marker, point) in attachment.points.iter().enumerate() {
        for (vertex, weight) in point.vertices.iter().zip(point.weights) {
            let Some(vector) = vectors.get(vertex) else { continue };
            let (share, vector) = (f64::from(jaw[*vertex as usize]), f64::from(weight) * vector.as_dvec3());
            split[0][marker] += share * vector;
            split[1][marker] += (1.0 - share) * vector;
        }
    }
    split
}

/// What drives each shape, as the other side reads it.
fn drivers(rig: &Rig) -> Vec<Value> {
    let tents = |channel: u32| {
        rig.shapes.iter().filter_map(move |shape| match shape.driver {
            Driver::InBetween { channel: own, peak } if own == channel => Some(peak),
            _ => None,
        })
    };
    let driver = |driver: &Driver| match driver {
        Driver::Channel(channel) => json!({"product": [channel]}),
        Driver::Combination(channels) => json!({"product": channels}),
        Driver::InBetween { channel, peak } => {
            let below = tents(*channel).filter(|other| other < peak).fold(0.0, f32::max);
            let above = tents(*channel).filter(|other| other > peak).fold(1.0, f32::min);
            json!({"tent": [below, peak, above], "channel": channel})
        }
        Driver::Turn { .. } => panic!("this benchmark's rig has no pose shapes"),
    };
    rig.shapes.iter().map(|shape| driver(&shape.driver)).collect()
}

fn main() {
    let data = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let Some(folder) = std::env::args().skip(1).find(|argument| !argument.starts_with("--")) else { return };
    let folder = PathBuf::from(folder);
    fs::create_dir_all(&folder).unwrap();
    let actor = data.join("actors/ict_actor_a");
    let read = |name: &str| fs::read(actor.join(name)).unwrap();
    let scan = gltf::read(&read("ict_actor_a.glb"), "a", &mut no_sibling).unwrap();
    let neutral = marker_csv::read(&read("neutral_markers.csv"), Some(1.0)).unwrap();
    let rig = skin_jaw(&scan, &SkinJawOptions::default()).unwrap().rig;
    assert!(rig.joints.is_empty(), "the other side knows the jaw alone");
    let attachment = attach_markers(&rig, &neutral, &AttachOptions::default()).unwrap().attachment;
    let puppet = MarkerRig::attached(&rig, &attachment).unwrap();
    let take = c3d::read(&read("takes/day1_161.c3d")).unwrap();
    let take = fill_gaps(&take, Some(&neutral), None, &GapOptions::default()).unwrap().markers;
    // A raw solve from the markers alone: the puppet taken as linear.
    let raw = match_markers(&puppet, &take, MatchOptions::default()).unwrap();
    let options = FinetuneOptions::default();

    let tuned = finetune(&puppet, &raw, &take, &options).unwrap();
    let mut seconds: Vec<f64> = (0..5)
        .map(|_| {
            let start = Instant::now();
            assert_eq!(finetune(&puppet, &raw, &take, &options).unwrap().steps, tuned.steps);
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);

    let write = |name: &str, numbers: &mut dyn Iterator<Item = f64>| {
        fs::write(folder.join(name), numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>()).unwrap();
    };
    let flat = |vectors: &[DVec3]| vectors.iter().flat_map(DVec3::to_array).collect::<Vec<_>>();
    let rest = split(&rig, &attachment, &(0..).zip(rig.neutral.iter().copied()).collect());
    let columns: Vec<Split> = rig
        .shapes
        .iter()
        .map(|shape| {
            let vectors = shape.vertices.iter().copied().zip(shape.deltas.iter().copied()).collect();
            split(&rig, &attachment, &vectors)
        })
        .collect();
    for (place, name) in ["jaw", "skull"].iter().enumerate() {
        write(&format!("rest_{name}.bin"), &mut flat(&rest[place]).into_iter());
        write(&format!("shapes_{name}.bin"), &mut columns.iter().flat_map(|column| flat(&column[place])));
    }
    let jaw = rig.jaw.as_ref().unwrap();
    let share = |point: &face_math::data::SurfacePoint| {
        let corners = point.vertices.iter().zip(point.weights);
        corners.map(|(vertex, weight)| f64::from(weight) * f64::from(jaw.weights[*vertex as usize])).sum::<f64>()
    };
    write("shares.bin", &mut attachment.points.iter().map(share));
    let (mut euler, mut shift) = (vec![DVec3::ZERO; rig.shapes.len()], vec![DVec3::ZERO; rig.shapes.len()]);
    for motion in &jaw.motions {
        euler[motion.shape as usize] += motion.euler_rad.as_dvec3();
        shift[motion.shape as usize] += motion.translation_m.as_dvec3();
    }
    write("euler.bin", &mut flat(&euler).into_iter());
    write("shift.bin", &mut flat(&shift).into_iter());
    let take = take.pick(puppet.names()).unwrap();
    write("take.bin", &mut take.positions().iter().flat_map(|point| point.as_dvec3().to_array()));
    for (name, curves) in [("raw.bin", &raw), ("tuned.bin", &tuned.curves)] {
        let arranged = curves.arrange(&rig.channels, None).unwrap();
        write(name, &mut arranged.values().iter().map(|weight| f64::from(*weight)));
    }
    let posed = puppet.drive(&tuned.curves).unwrap();
    write("posed.bin", &mut posed.positions().iter().flat_map(|point| point.as_dvec3().to_array()));
    let told = json!({
        "threads": rayon::current_num_threads(),
        "frames": take.frames(),
        "markers": attachment.points.len(),
        "channels": rig.channels.len(),
        "drivers": drivers(&rig),
        "pivot_m": jaw.pivot_m.to_array(),
        "noise_m": 1e-3 * options.default_noise_mm,
        "raw_error": options.default_raw_error,
        "seconds": seconds[seconds.len() / 2],
        "least_seconds": seconds[0],
        "steps": tuned.steps,
        "unfinished": tuned.unfinished_frames.len(),
    });
    fs::write(folder.join("ours.json"), serde_json::to_string_pretty(&told).unwrap()).unwrap();
}
