//! What plugins cost: crossing into one, a large tensor in and out, the smoothing example beside its own source compiled
//! natively, and loading ten whose code is kept. Each figure is the least of several rounds.

use face_math::data::Curves;
use graph_core::node::{Catalogue, Inputs, PortValue};
use plugin_host::build::component;
use plugin_host::{Manifest, Numbers, Places, Plugin, PluginKinds, Setting, Tensor};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use wire::{FrameAxis, Value};

const ROUNDS: usize = 21;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugins/examples/plugins");
    let limit = load(&examples.join("limit"))?;
    let smoothing = load(&examples.join("smoothing"))?;

    let one = on("curves", curves(1, 1));
    let crossing_s = least(|| limit.crossing_s("limit", &one, 1000).unwrap_or(f64::NAN));
    println!("a call with 1 number in and out, {:.2} us", crossing_s * 1e6);
    let fresh_s = least(|| timed(|| drop(black_box(limit.compute("limit", &[], None, &one)))));
    println!("the same with a fresh store, {:.1} us", fresh_s * 1e6);

    let echo = echo(&examples)?;
    let numbers = vec![1.25_f32; 4 << 20];
    let native_s = least(|| timed(|| drop(black_box(numbers.clone()))));
    let tensor = on("curves", Tensor::new(vec![4 << 20], Numbers::F32(numbers))?);
    let echo_s = least(|| timed(|| drop(black_box(echo.compute("limit", &[], None, &tensor).expect("it echoes")))));
    let (native_ms, echo_ms) = (native_s * 1e3, echo_s * 1e3);
    println!("16 MiB in and out, {echo_ms:.2} ms; a native copy {native_ms:.2} ms; {:.2} times", echo_s / native_s);

    let take = curves(2000, 150);
    let half = 10;
    let native_s = least(|| timed(|| drop(black_box(smoothing::smooth(take.values(), 150, half)))));
    let input = on("curves", take);
    let settings = [("half_window_frames", Setting::Integer(half as i64))];
    let smoothed = || smoothing.compute("savitzky_golay", &settings, None, &input).expect("it smooths");
    let plugin_s = least(|| timed(|| drop(black_box(smoothed()))));
    let (native_ms, plugin_ms) = (native_s * 1e3, plugin_s * 1e3);
    println!("smoothing 2000 x 150, {plugin_ms:.2} ms; natively {native_ms:.2} ms; {:.2} times", plugin_s / native_s);

    let ten = tempfile::tempdir()?;
    let bytes = std::fs::read(examples.join("smoothing/smoothing.wasm"))?;
    for at in 0..10 {
        let folder = ten.path().join(format!("plugin{at}"));
        std::fs::create_dir(&folder)?;
        std::fs::write(folder.join("p.wasm"), &bytes)?;
        let text = format!("(id: \"plugin{at}\", version: \"1\", api: \"0.1\", file: \"p.wasm\")");
        std::fs::write(folder.join("plugin.ron"), text)?;
    }
    let places = Places(vec![(plugin_host::Place::User, ten.path().to_owned())]);
    // Their code is the same, and each is read, checked, loaded and asked for its nodes by itself.
    let start = Instant::now();
    let count = PluginKinds::new(places, None).names().len();
    println!("ten plugins loaded, {:.2} ms ({count} kinds)", start.elapsed().as_secs_f64() * 1e3);
    Ok(())
}

fn load(folder: &Path) -> Result<Plugin, Box<dyn std::error::Error>> {
    let file: PathBuf = folder.join("plugin.ron");
    Ok(Plugin::load(&file, Manifest::load(&file)?)?)
}

/// The plugin `limit` with tensors on its ports, that gives back what it is given.
fn echo(examples: &Path) -> Result<Plugin, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(examples.join("limit/plugin.wat"))?;
    let give = "(local $last i32)
        (i32.store8 (i32.const 900) (i32.const 0))
        (call $pair (i32.const 904) (i32.const 912) (i32.const 1))
        (call $pair (i32.const 912) (i32.const 72) (i32.const 6))
        (call $pair (i32.const 920) (i32.load offset=8 (local.get $inputs)) (i32.const 1))
        (return (i32.const 900))";
    let text = text.replace("\"Curves\"", "\"Tensor\"").replace("(local $last i32)", give);
    let text = text.replace("(i32.store8 (i32.const 540) (i32.const 1))", "(i32.store8 (i32.const 540) (i32.const 0))");
    let manifest = Manifest::load(&examples.join("limit/plugin.ron"))?;
    Ok(Plugin::unkept(Path::new("plugin.ron"), manifest, &component(text.as_bytes())?)?)
}

fn curves(frames: usize, channels: usize) -> Curves {
    let names = (0..channels).map(|at| format!("channel{at}")).collect();
    let values = (0..frames * channels).map(|at| ((at % 97) as f32).sin()).collect();
    Curves::new(FrameAxis::new(frames, 60.0), names, values).expect("the sizes fit")
}

fn on(port: &'static str, value: impl Value) -> Inputs {
    let mut inputs = Inputs::default();
    inputs.set(port, PortValue::One(Arc::new(value)));
    inputs
}

fn timed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn least(mut round: impl FnMut() -> f64) -> f64 {
    (0..ROUNDS).map(|_| round()).fold(f64::INFINITY, f64::min)
}
