//! Tells the crate which version of wasmtime it is built with: results depend on it, so keys hold it.
#![allow(clippy::print_stdout, reason = "this is how a build script speaks")]

fn main() {
    let lock = std::path::Path::new("../../Cargo.lock");
    println!("cargo::rerun-if-changed={}", lock.display());
    let text = std::fs::read_to_string(lock).unwrap_or_default();
    let mut lines = text.lines().skip_while(|line| *line != "name = \"wasmtime\"");
    let version =
        lines.nth(1).and_then(|line| line.strip_prefix("version = \"")).and_then(|rest| rest.strip_suffix('"'));
    println!("cargo::rustc-env=WASMTIME_VERSION={}", version.unwrap_or("of no known version"));
}
