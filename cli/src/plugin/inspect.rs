//! `grimace plugin inspect`: what a plugin is, without a graph.

use crate::arguments::PluginInspect;
use crate::exit::{Exit, Trouble};
use crate::output;
use plugin_host::{NodeSchema, Plugin, PortSchema, Setting, TimeUse};
use serde_json::{Value, json};
use std::fmt::Write;

/// Says what a plugin is.
pub fn inspect(arguments: &PluginInspect) -> Result<Exit, Trouble> {
    let plugin = super::load(&arguments.folder)?;
    if arguments.json {
        output::print_json(&as_json(&plugin))?;
        return Ok(Exit::Fine);
    }
    let (manifest, facts) = (&plugin.manifest, &plugin.facts);
    let mut text = format!("{} {}  {}\n", manifest.id, manifest.version, manifest.doc.as_deref().unwrap_or_default());
    let imports = if facts.imports.is_empty() { "nothing".to_owned() } else { facts.imports.join(", ") };
    let _ = writeln!(text, "  component  {}, {} bytes", manifest.file, facts.bytes);
    let _ = writeln!(text, "  SHA-256    {}", facts.sha256);
    let _ = writeln!(text, "  interface  {}", facts.interface);
    let _ = writeln!(text, "  imports    {imports}");
    let _ = writeln!(text, "  limits     {} MiB, {} s", manifest.limits.memory_mb, manifest.limits.time_s);
    let _ = writeln!(text, "  licence    {}", manifest.licence.as_deref().unwrap_or("none is given"));
    for node in &plugin.nodes {
        page(&mut text, &manifest.id, node);
    }
    output::print(&text)?;
    Ok(Exit::Fine)
}

fn page(text: &mut String, id: &str, node: &NodeSchema) {
    let _ = writeln!(text, "\n{id}/{}  version {}, {}\n  {}", node.name, node.version, time(&node.time), node.doc);
    for (what, ports) in [("takes", &node.inputs), ("gives", &node.outputs)] {
        for port in ports {
            let _ = writeln!(text, "  {what} {}: {}  {}", port.name, type_text(port), port.doc);
        }
    }
    for parameter in &node.parameters {
        let range = match (parameter.least, parameter.most) {
            (None, None) => String::new(),
            (least, most) => {
                let bound = |bound: Option<f64>| bound.map_or_else(|| "…".to_owned(), |bound| bound.to_string());
                format!(", {} to {}", bound(least), bound(most))
            }
        };
        let choices: Vec<&str> = parameter.choices.iter().map(|(name, _)| name.as_str()).collect();
        let choices = if choices.is_empty() { String::new() } else { format!(", one of {}", choices.join(", ")) };
        let _ =
            writeln!(text, "  {} = {}{range}{choices}  {}", parameter.name, shown(&parameter.default), parameter.doc);
    }
}

fn shown(setting: &Setting) -> String {
    serde_json::to_string(setting).unwrap_or_default()
}

fn type_text(port: &PortSchema) -> String {
    let name = if port.many { format!("[{}]", port.type_name) } else { port.type_name.clone() };
    if port.optional { format!("{name}?") } else { name }
}

fn time(time: &TimeUse) -> String {
    match time {
        TimeUse::Whole => "whole".to_owned(),
        TimeUse::PerFrame(halo) => format!("per frame with {halo} on either side"),
        TimeUse::PerFrameBy(name) => format!("per frame with `{name}` on either side"),
    }
}

fn as_json(plugin: &Plugin) -> Value {
    let (manifest, facts) = (&plugin.manifest, &plugin.facts);
    let port =
        |port: &PortSchema| json!({ "name": port.name, "type": type_text(port), "doc": port.doc, "still": port.still });
    let node = |node: &NodeSchema| {
        let parameters = node.parameters.iter().map(|parameter| {
            json!({
                "name": parameter.name, "doc": parameter.doc, "default": parameter.default,
                "least": parameter.least, "most": parameter.most,
                "choices": parameter.choices.iter().map(|(name, _)| name).collect::<Vec<_>>(),
            })
        });
        json!({
            "name": format!("{}/{}", manifest.id, node.name), "doc": node.doc, "version": node.version, "time": time(&node.time),
            "inputs": node.inputs.iter().map(port).collect::<Vec<_>>(),
            "outputs": node.outputs.iter().map(port).collect::<Vec<_>>(),
            "parameters": parameters.collect::<Vec<_>>(),
        })
    };
    json!({
        "manifest": manifest, "bytes": facts.bytes, "sha256": facts.sha256, "digest": facts.digest.hex(),
        "interface": facts.interface, "imports": facts.imports, "nodes": plugin.nodes.iter().map(node).collect::<Vec<_>>(),
    })
}
