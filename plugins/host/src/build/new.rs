//! New plugins: a folder with a source that works, and its manifest.

use super::BuildError;
use crate::manifest::FILE;
use std::path::Path;

/// A language to begin in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// Rust with the SDK.
    Rust,
    /// C with the generated header.
    C,
    /// Zig.
    Zig,
    /// `AssemblyScript`.
    AssemblyScript,
    /// WebAssembly text.
    Wat,
}

type Template = (&'static str, &'static str);

const RUST: [Template; 2] = [
    ("Cargo.toml", include_str!("templates/rust/Cargo.toml.in")),
    ("src/lib.rs", include_str!("templates/rust/lib.rs.in")),
];
/// The SDK that Rust plugins stand on, so that a plugin's folder is all that its author needs.
const SDK: [Template; 7] = [
    ("sdk/Cargo.toml", include_str!("../../../sdk/Cargo.toml")),
    ("sdk/src/lib.rs", include_str!("../../../sdk/src/lib.rs")),
    ("sdk/src/bindings.rs", include_str!("../../../sdk/src/bindings.rs")),
    ("sdk/src/call.rs", include_str!("../../../sdk/src/call.rs")),
    ("sdk/src/outputs.rs", include_str!("../../../sdk/src/outputs.rs")),
    ("sdk/src/runtime.rs", include_str!("../../../sdk/src/runtime.rs")),
    ("sdk/src/schema.rs", include_str!("../../../sdk/src/schema.rs")),
];
/// How the SDK's manifest begins, which is within the plugin's workspace then.
const OWN_WORKSPACE: &str = "# A workspace of its own: plugins depend on it from outside, and build for another machine than the engine.\n[workspace]\n\n";
const WAT: [Template; 1] = [("plugin.wat", include_str!("../../../examples/plugins/limit/plugin.wat"))];
const AS: [Template; 2] = [
    ("plugin.ts", include_str!("../../../examples/plugins/envelope/plugin.ts")),
    ("component.ts", include_str!("../../../examples/plugins/envelope/component.ts")),
];
const C: [Template; 2] = [
    ("plugin.c", include_str!("../../../examples/plugins/wrinkles/plugin.c")),
    ("component.h", include_str!("../../../examples/plugins/wrinkles/component.h")),
];
const ZIG: [Template; 1] = [("plugin.zig", include_str!("templates/zig/plugin.zig.in"))];

impl Language {
    /// What `build` of a manifest calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rust => "rust",
            Self::C => "c",
            Self::Zig => "zig",
            Self::AssemblyScript => "assemblyscript",
            Self::Wat => "wat",
        }
    }

    fn files(self) -> &'static [Template] {
        match self {
            Self::Rust => &RUST,
            Self::C => &C,
            Self::Zig => &ZIG,
            Self::AssemblyScript => &AS,
            Self::Wat => &WAT,
        }
    }
}

/// Begins the plugin `name` in the folder `folder`, written in `language`. `sdk` is where the Rust SDK lies; without it, a copy
/// comes along.
///
/// # Errors
/// Where the name cannot be, or the folder is there already or cannot be written.
pub fn new(folder: &Path, name: &str, language: Language, sdk: Option<&Path>) -> Result<(), BuildError> {
    let plain = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || "-_".contains(letter);
    if !(name.starts_with(|letter: char| letter.is_ascii_lowercase()) && name.len() <= 64 && name.chars().all(plain)) {
        return Err(BuildError::Name { name: name.to_owned() });
    }
    if folder.exists() {
        return Err(BuildError::There { folder: folder.to_owned() });
    }
    let manifest = format!(
        "(\n    id: \"{name}\",\n    version: \"0.1.0\",\n    api: \"0.1\",\n    file: \"{name}.wasm\",\n    limits: (memory_mb: 512, time_s: 60),\n    build: \"{}\",\n)\n",
        language.name()
    );
    let write = |file: &str, text: &str| {
        let path = folder.join(file);
        let parent = path.parent().unwrap_or(folder);
        let written = std::fs::create_dir_all(parent).and_then(|()| std::fs::write(&path, text));
        written.map_err(|problem| BuildError::File { file: path.clone(), problem: problem.to_string() })
    };
    let place = sdk.map_or_else(|| "sdk".to_owned(), |sdk| sdk.display().to_string());
    for (file, text) in language.files() {
        write(file, &text.replace("@NAME@", name).replace("@SDK@", &place))?;
    }
    if language == Language::Rust && sdk.is_none() {
        for (file, text) in SDK {
            write(file, text.strip_prefix(OWN_WORKSPACE).unwrap_or(text))?;
        }
    }
    write(FILE, &manifest)
}
