//! `grimace plugin build` and `grimace new plugin`.

use crate::arguments::{Language, NewPlugin, PluginFolder};
use crate::exit::{Exit, Trouble};
use crate::output;
use plugin_host::build;
use std::path::{Path, PathBuf};

/// Compiles a plugin.
pub fn build(arguments: &PluginFolder) -> Result<Exit, Trouble> {
    let folder = if arguments.folder.is_file() {
        arguments.folder.parent().unwrap_or(Path::new("."))
    } else {
        &arguments.folder
    };
    let built = build::build(folder, None).map_err(Trouble::plugin)?;
    output::print(&format!("{}  {} bytes  SHA-256 {}\n", built.file.display(), built.bytes, built.sha256))?;
    // Whether it can be used, its author wants to know at once.
    super::load(folder).map(|_| Exit::Fine)
}

/// Begins a plugin.
pub fn new(arguments: &NewPlugin) -> Result<Exit, Trouble> {
    let folder = &arguments.name;
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let language = match arguments.lang {
        Language::Rust => build::Language::Rust,
        Language::C => build::Language::C,
        Language::Zig => build::Language::Zig,
        Language::AssemblyScript => build::Language::AssemblyScript,
        Language::Wat => build::Language::Wat,
    };
    let found = |sdk: &PathBuf| {
        sdk.canonicalize().map_err(|problem| {
            let help = "name the folder plugins/sdk of grimace's sources, or leave --sdk out for a copy";
            Trouble::command_line(
                format!("there is no Rust SDK at {}: {problem}", sdk.display()),
                Some(help.to_owned()),
            )
        })
    };
    let sdk = arguments.sdk.as_ref().map(found).transpose()?;
    build::new(folder, &name, language, sdk.as_deref()).map_err(Trouble::plugin)?;
    let shown = folder.display();
    output::print(&format!(
        "{shown} is begun: `grimace plugin build {shown}` compiles it, `grimace plugin test {shown}` tries it\n"
    ))?;
    Ok(Exit::Fine)
}
