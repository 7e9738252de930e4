//! Runs the compiler of a plugin's language, makes a component of what it gives, and writes that beside the manifest.

use super::{BuildError, component};
use crate::digests::sha256;
use crate::manifest::{FILE, Manifest};
use graph_core::document::edit::save;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A plugin that was built.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Built {
    /// The component.
    pub file: PathBuf,
    /// Its size in bytes.
    pub bytes: usize,
    /// Its SHA-256.
    pub sha256: String,
}

/// Where cargo looks for flags of the Rust compiler.
const FLAGS: &str = "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS";
/// Flags of the Rust compiler, unless the environment has some: vectors of 128 bits are everywhere.
const RUST_FLAGS: &str = "-Ctarget-feature=+simd128";

/// Builds the plugin in `folder` into `to`, or beside its manifest.
///
/// # Errors
/// Where a tool is not there or fails, or what it gives is no plugin.
pub fn build(folder: &Path, to: Option<&Path>) -> Result<Built, BuildError> {
    let manifest = Manifest::load(&folder.join(FILE))?;
    let scratch = tempfile::tempdir().map_err(|problem| failed(folder, &problem))?;
    let core = match manifest.build.as_deref() {
        Some("rust") => rust(folder)?,
        Some("c") => c(folder, scratch.path())?,
        Some("zig") => zig(folder, scratch.path())?,
        Some("assemblyscript") => assemblyscript(folder, scratch.path())?,
        Some("wat") => only(folder, "wat")?,
        other => {
            let found = other.map_or_else(|| "not given".to_owned(), |text| format!("{text:?}"));
            return Err(BuildError::Language { file: folder.join(FILE), found });
        }
    };
    let bytes = component(&std::fs::read(&core).map_err(|problem| failed(&core, &problem))?)?;
    let file = to.map_or_else(|| folder.join(&manifest.file), Path::to_owned);
    // A watching engine reads it at any moment, so it is put in place whole.
    save(&file, &bytes).map_err(|problem| failed(&file, &problem))?;
    Ok(Built { bytes: bytes.len(), sha256: sha256(&bytes), file })
}

/// What this machine lacks to build plugins in `language`; `None` where nothing.
pub fn missing_tools(language: &str) -> Option<String> {
    match language {
        "rust" => {
            let cargo =
                Command::new(rustc()).args(["--print", "target-libdir", "--target", "wasm32-unknown-unknown"]).output();
            let libraries = cargo.ok().map(|output| PathBuf::from(String::from_utf8_lossy(&output.stdout).trim()));
            let there = libraries.is_some_and(|folder| folder.is_dir())
                || std::env::var_os("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS").is_some();
            (!there).then(|| "the Rust target wasm32-unknown-unknown".to_owned())
        }
        "c" => clang().err().map(|()| "clang".to_owned()),
        "zig" => tool("GRIMACE_ZIG", &["zig"]).err().map(|()| "zig".to_owned()),
        "assemblyscript" => tool("GRIMACE_ASC", &["asc"]).err().map(|()| "asc".to_owned()),
        _ => None,
    }
}

fn failed(file: &Path, problem: &std::io::Error) -> BuildError {
    BuildError::File { file: file.to_owned(), problem: problem.to_string() }
}

/// The tool that the variable names, or the first of `names` that runs.
fn tool(variable: &str, names: &[&str]) -> Result<OsString, ()> {
    if let Some(set) = std::env::var_os(variable).filter(|set| !set.is_empty()) {
        return Ok(set);
    }
    let runs =
        |name: &&&str| Command::new(name).arg(if **name == "zig" { "version" } else { "--version" }).output().is_ok();
    names.iter().find(runs).map(OsString::from).ok_or(())
}

fn rustc() -> OsString {
    std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())
}

fn clang() -> Result<OsString, ()> {
    tool(
        "GRIMACE_CLANG",
        &["clang", "clang-23", "clang-22", "clang-21", "clang-20", "clang-19", "clang-18", "clang-17", "clang-16"],
    )
}

/// What the tool wrote, where it failed.
fn run(command: &mut Command) -> Result<Vec<u8>, BuildError> {
    let shown = || format!("{command:?}").replace('"', "");
    let text = shown();
    let output = command
        .output()
        .map_err(|problem| BuildError::Failed { command: text.clone(), output: problem.to_string() })?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    let said = [output.stderr, output.stdout].concat();
    Err(BuildError::Failed { command: text, output: String::from_utf8_lossy(&said).into_owned() })
}

fn rust(folder: &Path) -> Result<PathBuf, BuildError> {
    if let Some(tool) = missing_tools("rust") {
        return Err(BuildError::Tool {
            language: "Rust",
            tool,
            cure: "`rustup target add wasm32-unknown-unknown` brings it",
        });
    }
    let cargo = || {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.current_dir(folder);
        cargo
    };
    let flags = if ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", FLAGS].iter().all(|name| std::env::var_os(name).is_none()) {
        let metadata =
            run(cargo().args(["metadata", "--format-version=1", "--filter-platform", "wasm32-unknown-unknown"]))?;
        Some([vec![RUST_FLAGS.to_owned()], without_paths(&metadata)].concat().join("\x1f"))
    } else {
        None
    };
    let mut cargo = cargo();
    cargo.args([
        "build",
        "--release",
        "--target",
        "wasm32-unknown-unknown",
        "--message-format=json-render-diagnostics",
    ]);
    if let Some(flags) = flags {
        cargo.env("CARGO_ENCODED_RUSTFLAGS", flags);
    }
    let messages = run(&mut cargo)?;
    let text = String::from_utf8_lossy(&messages);
    let files = text.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let files = files.flat_map(|message| message["filenames"].as_array().cloned().unwrap_or_default());
    let mut module = files
        .filter_map(|file| file.as_str().map(PathBuf::from))
        .filter(|file| file.extension().is_some_and(|ending| ending == "wasm"));
    module.next_back().ok_or_else(|| BuildError::Component {
        problem: "cargo gave no .wasm file: its Cargo.toml needs crate-type = [\"cdylib\"]".to_owned(),
    })
}

/// Flags by which the compiler names the sources of each package of cargo's metadata by the package alone. The places of
/// panics would otherwise tell where they stood on this machine, and another machine would build other bytes.
fn without_paths(metadata: &[u8]) -> Vec<String> {
    let metadata: serde_json::Value = serde_json::from_slice(metadata).unwrap_or_default();
    let flag = |package: &serde_json::Value| {
        let folder = Path::new(package["manifest_path"].as_str()?).parent()?.to_str()?;
        let (name, version) = (package["name"].as_str()?, package["version"].as_str()?);
        Some(format!("--remap-path-prefix={folder}={name}-{version}"))
    };
    metadata["packages"].as_array().into_iter().flatten().filter_map(flag).collect()
}

fn c(folder: &Path, scratch: &Path) -> Result<PathBuf, BuildError> {
    let cure = "install clang and lld of LLVM 16 or later, or name it in GRIMACE_CLANG";
    let clang = clang().map_err(|()| BuildError::Tool { language: "C", tool: "clang".to_owned(), cure })?;
    let core = scratch.join("core.wasm");
    let mut command = Command::new(clang);
    command.args([
        "--target=wasm32-unknown-unknown",
        "-O2",
        "-msimd128",
        "-mbulk-memory",
        "-ffreestanding",
        "-nostdlib",
        "-std=c17",
        "-Wall",
        "-fno-builtin",
    ]);
    command.args(["-Wl,--no-entry", "-Wl,--gc-sections", "-Wl,--strip-debug", "-o"]).arg(&core);
    command.args(files(folder, "c")?);
    run(&mut command)?;
    Ok(core)
}

fn zig(folder: &Path, scratch: &Path) -> Result<PathBuf, BuildError> {
    let cure = "install Zig 0.14 or later, or name it in GRIMACE_ZIG";
    let zig = tool("GRIMACE_ZIG", &["zig"]).map_err(|()| BuildError::Tool {
        language: "Zig",
        tool: "zig".to_owned(),
        cure,
    })?;
    let core = scratch.join("core.wasm");
    let mut emit = OsString::from("-femit-bin=");
    emit.push(&core);
    let mut command = Command::new(zig);
    command.args([
        "build-exe",
        "-target",
        "wasm32-freestanding",
        "-O",
        "ReleaseFast",
        "-mcpu=generic+simd128+bulk_memory",
        "-fno-entry",
        "-rdynamic",
        "-fstrip",
    ]);
    command.arg("--cache-dir").arg(scratch.join("zig")).arg(emit).arg(only(folder, "zig")?);
    run(&mut command)?;
    Ok(core)
}

fn assemblyscript(folder: &Path, scratch: &Path) -> Result<PathBuf, BuildError> {
    let cure = "`npm install assemblyscript` brings it; name it in GRIMACE_ASC where it is not on the PATH";
    let local = folder.join("node_modules/.bin/asc");
    let asc = if local.is_file() { Ok(local.into()) } else { tool("GRIMACE_ASC", &["asc"]) };
    let asc = asc.map_err(|()| BuildError::Tool { language: "AssemblyScript", tool: "asc".to_owned(), cure })?;
    let core = scratch.join("core.wat");
    let mut command = Command::new(asc);
    command
        .arg(only(folder, "ts")?)
        .args([
            "--runtime",
            "stub",
            "--optimizeLevel",
            "3",
            "--noAssert",
            "--use",
            "abort=",
            "--enable",
            "simd",
            "--textFile",
        ])
        .arg(&core);
    run(&mut command)?;
    // The language has no way to export under names with such letters.
    let mut text = std::fs::read_to_string(&core).map_err(|problem| failed(&core, &problem))?;
    for name in ["describe", "evaluate"] {
        text = text.replace(&format!("(export \"{name}\""), &format!("(export \"grimace:node/nodes@0.1.0#{name}\""));
    }
    std::fs::write(&core, text).map_err(|problem| failed(&core, &problem))?;
    Ok(core)
}

/// The sources with this ending in `folder` or its `src`, in their order.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, BuildError> {
    let mut found = Vec::new();
    for folder in [folder.join("src"), folder.to_owned()] {
        let entries = std::fs::read_dir(&folder).into_iter().flatten().filter_map(Result::ok);
        found
            .extend(entries.map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|own| own == ending)));
    }
    found.sort();
    if found.is_empty() {
        let problem = format!("there is no source file with the ending .{ending} in it or in its `src`");
        return Err(BuildError::File { file: folder.to_owned(), problem });
    }
    Ok(found)
}

/// The one source to begin with: `plugin` where there are several.
fn only(folder: &Path, ending: &str) -> Result<PathBuf, BuildError> {
    let mut all = files(folder, ending)?;
    let at = all.iter().position(|file| file.file_stem().is_some_and(|stem| stem == "plugin")).unwrap_or(0);
    Ok(all.swap_remove(at))
}
