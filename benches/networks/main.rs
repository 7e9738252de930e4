//! Times the region networks of FDLS on a scanned actor (training with the paper's sizes, and a take from markers to
//! weights), and writes the same networks and motion for `compare.py`, which runs them with `NumPy` and `PyTorch`.
//!
//! Files in the folder given as the argument, little-endian 32-bit floats, and `ours.json` with sizes, times and losses.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot read its files has nothing to say")]

use face_io::{c3d, curves, gltf, marker_csv, no_sibling, regions};
use face_math::clean::{GapOptions, fill_gaps};
use face_math::data::{Curves, Features, Markers, Regions};
use face_math::rig::{AttachOptions, MarkerRig, SkinJawOptions, attach_markers, skin_jaw};
use graph_core::node::{Context, Host, Inputs, Node, NodeError, Outputs, Port, PortValue, SourceFile};
use learn::{Architecture, EpochReport, Matrix, Network, Observer, Samples, Table, Training, train};
use nodes::solve::{GraphFeatures, SolveJaw, SolveRegions, TrainRegions};
use nodes::values::Networks;
use rayon::prelude::*;
use serde_json::{Value as Json, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::Instant;
use wire::{FrameAxis, Value};

/// Frames of the take.
const TAKE: usize = 1830;
/// Frames that the engine hands to a node at once: four blocks.
const CALL: usize = 4 * 32;
/// Epochs of all seven networks.
const EPOCHS: usize = 2;
/// Batches an epoch and epochs of the lower face's steps; the first epoch does not count.
const STEPS: (usize, usize) = (20, 6);
/// Steps from one start on one batch, without dropout, whose losses are compared.
const SAME_STEPS: usize = 20;

const MARKERS: Port<Markers> = Port::new("markers", "");
const NEUTRAL: Port<Markers> = Port::new("neutral", "");
const REGIONS: Port<Regions> = Port::new("regions", "");
const FEATURES: Port<Features> = Port::new("features", "");
const CURVES: Port<Curves> = Port::new("curves", "");
const NETWORKS: Port<Networks> = Port::new("networks", "");
const JAW: Port<Curves> = Port::new("jaw", "");

/// An engine that keeps nothing.
struct Nowhere;

impl Host for Nowhere {
    fn memory_bytes(&self) -> u64 {
        1 << 34
    }

    fn progress(&self, _: f64, _: &[(&str, f64)]) {}

    fn source(&self) -> Result<SourceFile, NodeError> {
        Err(NodeError::failed("there are no files here"))
    }

    fn sibling(&self, _: &str) -> Result<Arc<Vec<u8>>, NodeError> {
        Err(NodeError::failed("there are no files here"))
    }

    fn checkpoint(&self, _: &str) -> Option<Vec<u8>> {
        None
    }

    fn save_checkpoint(&self, _: &str, _: &[u8]) {}
}

fn compute(node: &dyn Node, inputs: &Inputs) -> Outputs {
    node.compute(&Context::new(&Nowhere, &AtomicBool::new(false), ""), inputs).unwrap()
}

fn timed<T>(what: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let out = what();
    (out, start.elapsed().as_secs_f64())
}

fn write(folder: &Path, name: &str, numbers: impl IntoIterator<Item = f32>) {
    let bytes: Vec<u8> = numbers.into_iter().flat_map(f32::to_le_bytes).collect();
    fs::write(folder.join(name), bytes).unwrap();
}

fn write_markers(folder: &Path, name: &str, markers: &Markers) {
    write(folder, name, markers.positions().iter().flat_map(glam::Vec3::to_array));
}

/// The actor's markers: at rest, under the range of motion, and of a take.
struct Subject {
    regions: Regions,
    neutral: Markers,
    motion: Markers,
    curves: Curves,
    take: Markers,
}

impl Subject {
    fn load(data: &Path) -> Self {
        let actor = data.join("actors/ict_actor_a");
        let read = |name: &str| fs::read(actor.join(name)).unwrap();
        let scan = gltf::read(&read("ict_actor_a.glb"), "a", &mut no_sibling).unwrap();
        let rig = skin_jaw(&scan, &SkinJawOptions::default()).unwrap().rig;
        let neutral = marker_csv::read(&read("neutral_markers.csv"), Some(1.0)).unwrap();
        let attachment = attach_markers(&rig, &neutral, &AttachOptions::default()).unwrap().attachment;
        let mut rows = Vec::new();
        for name in ["rom/rom_162.csv", "rom/rom_165.csv"] {
            let table = curves::open(&read(name)).unwrap().into_curves(Some(60.0)).unwrap();
            rows.extend_from_slice(table.arrange(&rig.channels, Some(0.0)).unwrap().values());
        }
        let axis = FrameAxis::new(rows.len() / rig.channels.len(), 60.0);
        let curves = Curves::new(axis, rig.channels.clone(), rows).unwrap();
        let puppet = MarkerRig::attached(&rig, &attachment).unwrap();
        let take = c3d::read(&read("takes/day1_161.c3d")).unwrap();
        let take = fill_gaps(&take, Some(&neutral), None, &GapOptions::default()).unwrap().markers;
        Self {
            regions: regions::read(&fs::read(data.join("actors/regions.json")).unwrap()).unwrap(),
            motion: puppet.drive(&curves).unwrap(),
            // All three hold the same markers in the same order.
            neutral: neutral.pick(puppet.names()).unwrap(),
            take: take.pick(puppet.names()).unwrap().slice(0..TAKE).unwrap().downcast_ref::<Markers>().unwrap().clone(),
            curves,
        }
    }
}

fn main() {
    let data = std::env::var_os("GRIMACE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let Some(folder) = std::env::args().skip(1).find(|argument| !argument.starts_with("--")).map(PathBuf::from) else {
        return;
    };
    fs::create_dir_all(&folder).unwrap();
    let subject = Subject::load(&data);
    let mut told = json!({
        "threads": rayon::current_num_threads(),
        "markers": subject.neutral.names().len(),
        "motion_frames": subject.motion.frames(),
        "take_frames": subject.take.frames(),
        "channels": subject.curves.channels(),
        "epochs": EPOCHS,
        "steps": [STEPS.0, STEPS.1],
    });
    write_markers(&folder, "neutral.bin", &subject.neutral);
    write_markers(&folder, "motion.bin", &subject.motion);
    write_markers(&folder, "take.bin", &subject.take);
    write(&folder, "curves.bin", subject.curves.values().iter().copied());

    let (networks, features) = all_seven(&subject, &mut told);
    write_networks(&folder, &subject, &networks, &mut told);
    lower_face(&folder, &subject, &features, &networks, &mut told);
    let solved = solve(&subject, networks, &mut told);
    write(&folder, "solved.bin", solved);
    fs::write(folder.join("ours.json"), serde_json::to_string_pretty(&told).unwrap()).unwrap();
}

fn features_of(subject: &Subject, markers: &Markers) -> Features {
    let inputs = Inputs::default().with(&MARKERS, markers.clone()).with(&NEUTRAL, subject.neutral.clone());
    let outputs = compute(&GraphFeatures::default(), &inputs.with(&REGIONS, subject.regions.clone()));
    outputs.get(&FEATURES).unwrap().clone()
}

/// Training of all networks with the paper's settings, but few epochs.
fn all_seven(subject: &Subject, told: &mut Json) -> (Networks, Features) {
    let features = features_of(subject, &subject.motion);
    let node: TrainRegions = serde_json::from_value(json!({"epochs": EPOCHS, "unsolved": "zero"})).unwrap();
    let inputs = Inputs::default().with(&FEATURES, features.clone()).with(&CURVES, subject.curves.clone());
    let inputs = inputs.with(&REGIONS, subject.regions.clone());
    let (outputs, seconds) = timed(|| compute(&node, &inputs));
    told["train_seconds"] = json!(seconds);
    (outputs.get(&NETWORKS).unwrap().clone(), features)
}

/// Shapes, standardisation and weights, for the other side to build the same networks.
fn write_networks(folder: &Path, subject: &Subject, networks: &Networks, told: &mut Json) {
    let place = |names: &[String], own: &[String]| -> Vec<usize> {
        own.iter().map(|name| names.iter().position(|other| other == name).unwrap()).collect()
    };
    let mut all = Vec::new();
    let mut numbers = Vec::new();
    for own in &networks.regions {
        let architecture = own.network.architecture();
        numbers.extend(numbers_of(&own.network));
        all.push(json!({
            "region": own.region,
            "markers": place(subject.neutral.names(), &own.markers),
            "sets": own.sets,
            "channels": place(&networks.channels, &own.channels),
            "conditions": place(&networks.channels, &own.conditions),
            "architecture": architecture,
            "parameters": architecture.parameter_count(),
            "losses": own.training.losses,
        }));
    }
    told["jaw"] = json!(networks.jaw);
    told["networks"] = json!(all);
    write(folder, "networks.bin", numbers);
}

/// Means and scales of inputs, conditions and targets, then weights and biases in forward order.
fn numbers_of(network: &Network) -> Vec<f32> {
    let tables = [Table::Inputs, Table::Conditions, Table::Targets].map(|table| network.scaling(table));
    let scalings = tables.into_iter().flat_map(|scaling| scaling.mean.iter().chain(&scaling.scale));
    scalings.chain(network.parameters().iter().flat_map(|parameter| &parameter.values)).copied().collect()
}

/// Notes when each epoch ended, and its loss.
#[derive(Default)]
struct Clock(Mutex<Vec<(Instant, f64)>>);

impl Observer for Clock {
    fn epoch(&self, report: &EpochReport) {
        self.0.lock().unwrap().push((Instant::now(), report.loss));
    }
}

/// Steps of the largest network alone: their time, and their losses from a given start.
fn lower_face(folder: &Path, subject: &Subject, features: &Features, networks: &Networks, told: &mut Json) {
    let own = networks.region("lower-face").unwrap();
    let architecture = own.network.architecture();
    let inputs = features.region("lower-face").unwrap();
    let inputs = Matrix::new(subject.motion.frames(), inputs.width, inputs.values.clone()).unwrap();
    let columns = |names: &[String]| {
        let arranged = subject.curves.arrange(names, None).unwrap();
        Matrix::new(arranged.frames(), names.len(), arranged.values().to_vec()).unwrap()
    };
    let (targets, conditions) = (columns(&own.channels), columns(&own.conditions));
    let run = |architecture: &Architecture, training: &Training, rows: usize| {
        let cut = [&inputs, &conditions, &targets].map(|matrix| matrix.slice_rows(0, rows));
        let samples = Samples { conditions: Some(&cut[1]), ..Samples::new(&cut[0], &cut[2]) };
        let clock = Clock::default();
        let network = train(architecture, training, &samples, &clock).unwrap();
        (network, clock.0.into_inner().unwrap())
    };
    let training = Training { epochs: STEPS.1, ..Training::default() };
    let (_, ends) = run(architecture, &training, 64 * STEPS.0);
    let mut steps: Vec<f64> =
        ends.windows(2).map(|pair| (pair[1].0 - pair[0].0).as_secs_f64() / STEPS.0 as f64).collect();
    steps.sort_by(f64::total_cmp);
    told["step_seconds"] = json!({"least": steps[0], "median": steps[steps.len() / 2]});

    let steady = Architecture { dropout: 0.0, ..architecture.clone() };
    // A step size that changes no bit leaves the first weights.
    let (start, _) = run(&steady, &Training { learning_rate: 1e-30, epochs: 1, ..Training::default() }, 64);
    write(folder, "start.bin", numbers_of(&start));
    let (_, ends) = run(&steady, &Training { epochs: SAME_STEPS, ..Training::default() }, 64);
    told["losses_from_start"] = json!(ends.iter().map(|(_, loss)| *loss).collect::<Vec<_>>());
}

/// The take from markers to weights, four blocks of 32 frames in a call as the engine has it; gives frames × channels.
fn solve(subject: &Subject, networks: Networks, told: &mut Json) -> Vec<f32> {
    let networks: Arc<dyn Value> = Arc::new(networks);
    let rest: Arc<dyn Value> = Arc::new(subject.neutral.clone());
    let regions: Arc<dyn Value> = Arc::new(subject.regions.clone());
    let (jaw, rest_of_face) = (SolveJaw::default(), SolveRegions::default());
    let put = |inputs: &mut Inputs, port: &'static str, value: &Arc<dyn Value>| {
        inputs.set(port, PortValue::One(Arc::clone(value)));
    };
    let pass = || -> Vec<f32> {
        let blocks: Vec<_> = (0..TAKE).step_by(CALL).map(|first| first..(first + CALL).min(TAKE)).collect();
        let done: Vec<Curves> = blocks
            .into_par_iter()
            .map(|block| {
                let mut inputs = Inputs::default();
                put(&mut inputs, MARKERS.name(), &subject.take.slice(block).unwrap());
                put(&mut inputs, NEUTRAL.name(), &rest);
                put(&mut inputs, REGIONS.name(), &regions);
                let features = compute(&GraphFeatures::default(), &inputs).take(FEATURES.name()).unwrap();
                let mut inputs = Inputs::default();
                inputs.set(FEATURES.name(), features);
                put(&mut inputs, NETWORKS.name(), &networks);
                let jaw = compute(&jaw, &inputs).take(JAW.name()).unwrap();
                inputs.set(JAW.name(), jaw);
                compute(&rest_of_face, &inputs).get(&CURVES).unwrap().clone()
            })
            .collect();
        done.iter().flat_map(|curves| curves.values().iter().copied()).collect()
    };
    // The first pass packs the weights.
    let solved = pass();
    let mut passes: Vec<f64> = (0..15).map(|_| timed(pass).1).collect();
    passes.sort_by(f64::total_cmp);
    told["solve_seconds"] = json!({"least": passes[0], "median": passes[passes.len() / 2]});
    let (_, seconds) = timed(|| features_of(subject, &subject.take));
    told["features_seconds_one_thread"] = json!(seconds);
    solved
}
