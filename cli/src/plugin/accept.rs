//! `grimace plugin accept`: pins the plugins that count for a graph by their digests.

use super::variable;
use crate::arguments::PluginAccept;
use crate::exit::{Exit, Trouble};
use crate::{graph, output};
use plugin_host::{Lock, Pin, Places, sha256};
use std::fmt::Write;

/// Writes `plugins.lock`.
pub fn accept(arguments: &PluginAccept) -> Result<Exit, Trouble> {
    let graph = graph::file(&arguments.graph);
    if !graph.is_file() {
        return Err(Trouble::command_line(format!("there is no graph {}", graph.display()), None));
    }
    let path = Lock::path(&graph);
    let before = Lock::load(&path).map_err(Trouble::plugin)?.unwrap_or_default();
    let mut lock = Lock::default();
    let mut said = String::new();
    for found in Places::of(Some(&graph), &variable).find().into_iter().filter(|found| found.shadowed_by.is_none()) {
        let manifest = found.manifest.map_err(Trouble::plugin)?;
        let component = found.file.with_file_name(&manifest.file);
        let bytes = std::fs::read(&component).map_err(|problem| Trouble::File { path: component, problem })?;
        let pin = Pin { version: manifest.version, sha256: sha256(&bytes) };
        let change = match before.plugins.get(&manifest.id) {
            None => "new",
            Some(known) if *known == pin => "as before",
            Some(_) => "changed",
        };
        let _ = writeln!(said, "{} {}  {}  {change}", manifest.id, pin.version, &pin.sha256[..12]);
        lock.plugins.insert(manifest.id, pin);
    }
    lock.save(&path).map_err(Trouble::plugin)?;
    output::print(&format!("{said}{} pins {} plugins\n", path.display(), lock.plugins.len()))?;
    Ok(Exit::Fine)
}
