//! `grimace plugin list`: which plugins are found where, and which count.

use super::variable;
use crate::arguments::PluginList;
use crate::exit::{Exit, Trouble};
use crate::{graph, output};
use plugin_host::{Found, Lock, Places, sha256};
use serde::Serialize;
use std::fmt::Write;

#[derive(Serialize)]
struct Line {
    id: String,
    version: Option<String>,
    file: String,
    place: &'static str,
    sha256: Option<String>,
    doc: Option<String>,
    /// What is wrong with it, or what counts instead of it.
    note: Option<String>,
}

/// Lists plugins.
pub fn list(arguments: &PluginList) -> Result<Exit, Trouble> {
    let graph = arguments.graph.as_deref().map(graph::file);
    let places = Places::of(graph.as_deref(), &variable);
    let lock_file = graph.as_deref().map(Lock::path);
    let lock = lock_file.as_deref().map(Lock::load).transpose().map_err(Trouble::plugin)?.flatten();
    let mut text = String::new();
    for found in places.find() {
        let line = line(&found, lock.as_ref().zip(lock_file.as_deref()));
        if arguments.json {
            output::print_json(&line)?;
            continue;
        }
        let version = line.version.unwrap_or_else(|| "?".to_owned());
        let digest = line.sha256.map_or(String::new(), |digest| format!("  {}", &digest[..12]));
        let _ = writeln!(text, "{} {version}{digest}  {} ({})", line.id, line.file, line.place);
        for more in [line.doc, line.note].into_iter().flatten() {
            let _ = writeln!(text, "    {more}");
        }
    }
    if text.is_empty() && !arguments.json {
        for (place, folder) in &places.0 {
            let _ = writeln!(text, "no plugins in {} ({})", folder.display(), place.name());
        }
    }
    output::print(&text)?;
    Ok(Exit::Fine)
}

fn line(found: &Found, lock: Option<(&Lock, &std::path::Path)>) -> Line {
    let mut line = Line {
        id: found.id(),
        version: None,
        file: found.file.display().to_string(),
        place: found.place.name(),
        sha256: None,
        doc: None,
        note: found.shadowed_by.as_ref().map(|other| format!("shadowed by {}", other.display())),
    };
    match &found.manifest {
        Err(problem) => line.note = Some(problem.to_string()),
        Ok(manifest) => {
            line.version = Some(manifest.version.clone());
            line.doc.clone_from(&manifest.doc);
            match std::fs::read(found.file.with_file_name(&manifest.file)) {
                Ok(bytes) => {
                    let digest = sha256(&bytes);
                    if let (None, Some((lock, file))) = (&line.note, lock) {
                        let held = lock.check(file, &manifest.id, &manifest.version, &digest);
                        line.note = held.err().map(|problem| problem.to_string());
                    }
                    line.sha256 = Some(digest);
                }
                Err(problem) => line.note = Some(format!("{}: {problem}", manifest.file)),
            }
        }
    }
    line
}
