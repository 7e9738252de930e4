//! Plugins that mean harm, or are broken: each ends in an error that names the plugin, and the host lives on.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

use face_math::data::Curves;
use graph_core::node::{Context, Host, Inputs, NodeError, PortValue, SourceFile};
use plugin_host::build::component;
use plugin_host::{Limits, LoadError, Manifest, Plugin, RunError};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use wire::FrameAxis;

/// The honest plugin that the others are made of.
const HONEST: &str = include_str!("../../examples/plugins/limit/plugin.wat");

fn manifest() -> Manifest {
    let text = "(id: \"hostile\", version: \"6.6.6\", api: \"0.1\", file: \"hostile.wasm\")";
    let manifest = Manifest::read(text, Path::new("plugin.ron")).unwrap();
    Manifest { limits: Limits { memory_mb: 64, time_s: 0.3 }, ..manifest }
}

fn load_bytes(bytes: &[u8]) -> Result<Plugin, LoadError> {
    Plugin::unkept(Path::new("plugin.ron"), manifest(), bytes)
}

/// The honest plugin with `code` before its computation, and `functions` beside it.
fn harmed(functions: &str, code: &str) -> String {
    let mark = "(local $least f32) (local $most f32) (local $item i32) (local $at i32) (local $last i32)";
    assert!(HONEST.contains(mark));
    let text = HONEST.replace(mark, &format!("{mark}\n{code}"));
    // Imports stand before everything else.
    text.replace("(memory (export \"memory\") 1)", &format!("{functions}\n(memory (export \"memory\") 1)"))
}

fn load(text: &str) -> Plugin {
    load_bytes(&component(text.as_bytes()).unwrap()).unwrap()
}

fn curves(frames: usize) -> Curves {
    let values = (0..frames * 3).map(|at| at as f32 * 0.01).collect();
    let channels = ["a", "b", "c"].map(str::to_owned).to_vec();
    Curves::new(FrameAxis::new(frames, 60.0), channels, values).unwrap()
}

fn inputs() -> Inputs {
    let mut inputs = Inputs::default();
    inputs.set("curves", PortValue::One(Arc::new(curves(50))));
    inputs
}

fn run(plugin: &Plugin) -> Result<Curves, RunError> {
    let mut outputs = plugin.compute("limit", &[], None, &inputs())?;
    match outputs.take("curves") {
        Some(PortValue::One(value)) => Ok(value.downcast_ref::<Curves>().unwrap().clone()),
        other => panic!("{other:?}"),
    }
}

fn error(text: &str) -> String {
    let told = run(&load(text)).unwrap_err().to_string();
    assert!(told.contains("`hostile`"), "{told}");
    told
}

#[test]
fn the_honest_one_computes() {
    let bounded = run(&load(HONEST)).unwrap();
    assert!(bounded.values().iter().all(|value| (0.0..=1.0).contains(value)));
}

#[test]
fn an_endless_loop_ends_at_its_limit_and_says_where_it_was() {
    let start = Instant::now();
    let told = error(&harmed("", "(loop $round (br $round))"));
    assert!(told.contains("longer than the 0.3 s that `limits.time_s`"), "{told}");
    assert!(told.contains("evaluate"), "{told}");
    assert!(start.elapsed() < Duration::from_secs(5));
}

struct Nobody;

impl Host for Nobody {
    fn memory_bytes(&self) -> u64 {
        1 << 30
    }
    fn progress(&self, _: f64, _: &[(&str, f64)]) {}
    fn source(&self) -> Result<SourceFile, NodeError> {
        Err(NodeError::failed("none"))
    }
    fn sibling(&self, _: &str) -> Result<Arc<Vec<u8>>, NodeError> {
        Err(NodeError::failed("none"))
    }
    fn checkpoint(&self, _: &str) -> Option<Vec<u8>> {
        None
    }
    fn save_checkpoint(&self, _: &str, _: &[u8]) {}
}

#[test]
fn a_cancelled_cook_stops_an_endless_loop_within_200_ms() {
    let text = component(harmed("", "(loop $round (br $round))").as_bytes()).unwrap();
    let limits = Limits { memory_mb: 64, time_s: 60.0 };
    let plugin = Plugin::unkept(Path::new("plugin.ron"), Manifest { limits, ..manifest() }, &text).unwrap();
    let cancelled = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let running = scope.spawn(|| {
            let told = plugin.compute("limit", &[], Some(&Context::new(&Nobody, &cancelled, "")), &inputs());
            (told.map(drop), Instant::now())
        });
        std::thread::sleep(Duration::from_millis(100));
        let asked = Instant::now();
        cancelled.store(true, Ordering::Relaxed);
        let (told, ended) = running.join().unwrap();
        assert_eq!(told, Err(RunError::Cancelled));
        assert!(ended - asked < Duration::from_millis(200), "{:?}", ended - asked);
    });
}

#[test]
fn memory_beyond_the_limit_is_refused_with_both_sizes() {
    let told = error(&harmed("", "(drop (memory.grow (i32.const 65000)))"));
    assert!(told.contains("asked for 4063 MiB of memory (it had 1)"), "{told}");
    assert!(told.contains("`limits.memory_mb` of its plugin.ron allows 64"), "{told}");
}

#[test]
fn a_table_beyond_the_limit_is_refused() {
    let told = error(&harmed("(table $t 1 funcref)", "(drop (table.grow $t (ref.null func) (i32.const 200000)))"));
    assert!(told.contains("a table of 200001 entries"), "{told}");
}

#[test]
fn a_stack_that_overflows_is_told_with_its_functions() {
    let deep = "(func $deep (result i32) (i32.add (call $deep) (i32.const 1)))";
    let text = HONEST.replace("(memory (export", &format!("{deep}\n(memory (export"));
    let mark = "(local $last i32)";
    let told = error(&text.replace(mark, &format!("{mark}\n(drop (call $deep))")));
    assert!(told.contains("overflowed its stack") && told.contains("deep"), "{told}");
}

#[test]
fn a_trap_and_a_panic_are_told_with_their_words() {
    let told = error(&harmed("", "unreachable"));
    assert!(told.contains("trapped: wasm trap: wasm `unreachable`") && told.contains("evaluate"), "{told}");
    let log = "(import \"grimace:node/host@0.1.0\" \"log\" (func $log (param i32 i32 i32)))";
    let told = error(&harmed(log, "(call $log (i32.const 3) (i32.const 16) (i32.const 5)) unreachable"));
    assert!(told.contains("panicked: limit"), "{told}");
}

#[test]
fn every_nan_that_comes_out_is_the_quiet_one() {
    let storm = "(local.set $at (i32.load offset=48 (i32.load offset=8 (local.get $inputs))))
        (local.set $last (i32.add (local.get $at) (i32.const 600)))
        (loop $next
          (i32.store (local.get $at) (i32.or (i32.const 0x7f800001) (i32.mul (local.get $at) (i32.const 2))))
          (local.set $at (i32.add (local.get $at) (i32.const 4)))
          (br_if $next (i32.lt_u (local.get $at) (local.get $last))))";
    let stormy = run(&load(&harmed("", storm))).unwrap();
    assert!(stormy.values().iter().all(|value| !value.is_nan() || value.to_bits() == f32::NAN.to_bits()));
    assert!(stormy.values().iter().filter(|value| value.is_nan()).count() > 100);
}

#[test]
fn wrong_shapes_types_and_places_are_told() {
    let item = "(local.set $item (i32.load offset=8 (local.get $inputs)))";
    let with = |code: &str| error(&harmed("", &format!("{item} {code}")));
    let told = with("(i32.store offset=52 (local.get $item) (i32.const 149))");
    assert!(told.contains("149 numbers where 150 are needed"), "{told}");
    let told = with("(i32.store8 offset=8 (local.get $item) (i32.const 3))");
    assert!(told.contains("Markers, where Curves belongs"), "{told}");
    let told = with("(i32.store8 offset=8 (local.get $item) (i32.const 99))");
    assert!(told.contains("what cannot be read"), "{told}");
    let told = with("(f64.store offset=24 (local.get $item) (f64.const nan))");
    assert!(told.contains("a rate of NaN Hz"), "{told}");
    let told = with("(i32.store offset=48 (local.get $item) (i32.const 0x7ffffff0))");
    assert!(told.contains("out of bounds memory access"), "{told}");
    let told = with("(i32.store offset=32 (local.get $item) (i32.const -1))");
    assert!(told.contains("150 numbers where 12884901885 are needed"), "{told}");
    let told = error(&HONEST.replace(
        "(call $pair (i32.const 912) (i32.const 72) (i32.const 6))",
        "(call $pair (i32.const 912) (i32.const 16) (i32.const 5))",
    ));
    assert!(told.contains("something on the output \"limit\""), "{told}");
}

#[test]
fn ten_million_outputs_are_not_taken_in() {
    let many = "(drop (memory.grow (i32.const 900)))
        (call $pair (i32.const 904) (i32.const 65536) (i32.const 10000000))
        (i32.store8 (i32.const 900) (i32.const 0))
        (return (i32.const 900))";
    let start = Instant::now();
    error(&harmed("", many));
    let fits = many.replace("10000000", "3000000");
    error(&harmed("", &fits));
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}

#[test]
fn schemas_that_lie_are_refused_when_they_are_loaded() {
    let load = |text: &str| load_bytes(&component(text.as_bytes()).unwrap()).unwrap_err().to_string();
    let told = load(&HONEST.replace("\"Curves\"", "\"Curvse\""));
    assert!(told.contains("`hostile`") && told.contains("did you mean `Curves`?"), "{told}");
    let told = load(&HONEST.replace("(f64.const 1e6)", "(f64.const -2e6)"));
    assert!(told.contains("a range from -1000000 to -2000000"), "{told}");
    let told = load(
        &HONEST.replace("(i32.store (i32.const 544) (i32.const 0))", "(i32.store (i32.const 544) (i32.const -1))"),
    );
    assert!(told.contains("work whole"), "{told}");
    let endless = HONEST.replace(
        "(result i32)\n    (call $pair (i32.const 512)",
        "(result i32) (loop $r (br $r))\n    (call $pair (i32.const 512)",
    );
    assert_ne!(endless, HONEST);
    assert!(load(&endless).contains("ran longer"));
}

#[test]
fn what_plugins_are_not_given_is_refused_by_name() {
    let wasi = "(component (import \"wasi:filesystem/preopens@0.2.0\" (instance)) (import \"wasi:clocks/wall-clock@0.2.0\" (instance)))";
    let told = load_bytes(&component(wasi.as_bytes()).unwrap()).unwrap_err().to_string();
    assert!(
        told.contains("plugin `hostile` imports `wasi:filesystem/preopens@0.2.0`, `wasi:clocks/wall-clock@0.2.0`"),
        "{told}"
    );
    let told = load_bytes(b"\0asm\x01\0\0\0").unwrap_err().to_string();
    assert!(told.contains("`hostile`"), "{told}");
}

#[test]
fn an_interface_that_is_not_spoken_is_told_with_those_that_are() {
    let later = "(component (instance $nodes) (export \"grimace:node/nodes@0.7.0\" (instance $nodes)))";
    let told = load_bytes(&component(later.as_bytes()).unwrap()).unwrap_err().to_string();
    assert!(told.contains("speaks the interface 0.7.0; this program speaks 0.1"), "{told}");
    let none = "(component)";
    let told = load_bytes(&component(none.as_bytes()).unwrap()).unwrap_err().to_string();
    assert!(told.contains("no `grimace:node/nodes`"), "{told}");
}

#[test]
fn truncated_and_mutated_components_end_in_errors_by_the_thousand() {
    let whole = component(HONEST.as_bytes()).unwrap();
    let mut dice = 0x9e37_79b9_7f4a_7c15_u64;
    let mut roll = move |below: usize| {
        dice ^= dice << 13;
        dice ^= dice >> 7;
        dice ^= dice << 17;
        (dice % below as u64) as usize
    };
    let (mut refused, mut ran, mut failed) = (0, 0, 0);
    for round in 0..2000 {
        let mut bytes = whole.clone();
        match round % 4 {
            0 => bytes.truncate(roll(whole.len())),
            1 => {
                let at = roll(bytes.len());
                bytes[at] ^= 1 << roll(8);
            }
            2 => {
                for _ in 0..5 {
                    let at = roll(bytes.len());
                    bytes[at] = roll(256) as u8;
                }
            }
            _ => {
                let (from, length) = (roll(whole.len()), roll(64));
                let piece = whole[from..(from + length).min(whole.len())].to_vec();
                let at = roll(bytes.len());
                drop(bytes.splice(at..at, piece));
            }
        }
        match load_bytes(&bytes) {
            Err(told) => {
                assert!(told.to_string().contains("`hostile`"), "{told}");
                refused += 1;
            }
            Ok(plugin) => {
                let node = plugin.nodes[0].name.clone();
                match plugin.compute(&node, &[], None, &inputs()) {
                    Ok(_) => ran += 1,
                    Err(told) => {
                        assert!(told.to_string().contains("hostile"), "{told}");
                        failed += 1;
                    }
                }
            }
        }
    }
    assert!(refused > 1000 && refused + ran + failed == 2000, "{refused} refused, {ran} ran, {failed} failed");
}
