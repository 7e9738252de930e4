//! `grimace nodes`: the kinds of nodes there are, and all that one of them says of itself.

use crate::arguments::Nodes;
use crate::exit::{Exit, Trouble};
use crate::output;
use crate::words::wrapped;
use console::{Term, measure_text_width, style};
use graph_core::document::did_you_mean;
use graph_core::node::{
    ChoiceDescription, KindDescription, Kinds, NoKind, ParameterDescription, PortDescription, describe, first_sentence,
};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Folders of nodes, in the order in which data flows through them.
const FOLDERS: [&str; 10] = ["load", "clean", "rig", "solve", "curate", "fake", "texture", "capture", "strain", "save"];

/// Lists all kinds, or describes one.
pub fn nodes(arguments: &Nodes) -> Result<Exit, Trouble> {
    // Those that a graph in this folder could name.
    let kinds = Kinds::of_graph(Path::new("graph.ron"), &|name| std::env::var(name).ok());
    let wanted = match &arguments.kind {
        None => kinds.all().into_iter().map(|(_, kind)| describe(kind)).collect(),
        Some(name) => vec![describe(kinds.find(name).map_err(|problem| unknown(&kinds, name, problem))?)],
    };
    if arguments.json {
        for description in in_order(wanted) {
            output::print_json(&description)?;
        }
        return Ok(Exit::Fine);
    }
    let width = Term::stdout().size_checked().map(|(_, columns)| usize::from(columns));
    output::print(&match (&arguments.kind, wanted.as_slice()) {
        (Some(_), [one]) => page(one, width.unwrap_or(100).clamp(40, 100)),
        _ => list(&in_order(wanted), width.filter(|_| Term::stdout().is_term())),
    })?;
    Ok(Exit::Fine)
}

fn unknown(kinds: &Kinds, name: &str, problem: Option<NoKind>) -> Trouble {
    if let Some(NoKind { message, help, .. }) = problem {
        return Trouble::command_line(message, help);
    }
    let near = did_you_mean(name, kinds.names());
    let help = near.map_or_else(
        || "`grimace nodes` lists all kinds".to_owned(),
        |near| format!("did you mean `{near}`? `grimace nodes` lists all kinds"),
    );
    Trouble::command_line(format!("there is no node kind `{name}`"), Some(help))
}

/// Kinds by folder in the order of the data's flow, then by name.
fn in_order(mut all: Vec<KindDescription>) -> Vec<KindDescription> {
    let place = |folder: &str| FOLDERS.iter().position(|known| *known == folder).unwrap_or(FOLDERS.len());
    all.sort_by_cached_key(|kind| (place(&kind.folder), kind.folder.clone(), kind.name.clone()));
    all
}

/// One line a kind, under its folder; cut to `width` columns on a terminal.
fn list(all: &[KindDescription], width: Option<usize>) -> String {
    let names = all.iter().map(|kind| kind.name.len()).max().unwrap_or(0);
    let mut out = String::new();
    let mut folder = "";
    for kind in all {
        if kind.folder != folder {
            let gap = if folder.is_empty() { "" } else { "\n" };
            folder = &kind.folder;
            let _ = writeln!(out, "{gap}{}", style(folder).bold());
        }
        let name = format!("{:<names$}", kind.name);
        let line = format!("  {}  {}", style(name).cyan(), first_sentence(&kind.doc));
        let line = width.map_or_else(|| line.clone(), |width| console::truncate_str(&line, width, "…").into_owned());
        let _ = writeln!(out, "{}", line.trim_end());
    }
    out
}

/// Everything about one kind, in lines of at most `width` columns.
fn page(kind: &KindDescription, width: usize) -> String {
    let KindDescription { name, folder, version, time, .. } = kind;
    let mut out = format!("{}  {folder}, version {version}, {time}\n\n", style(name).bold());
    put(&mut out, "  ", &kind.doc, width);
    ports(&mut out, "Inputs", &kind.inputs, width);
    ports(&mut out, "Outputs", &kind.outputs, width);
    if !kind.parameters.is_empty() {
        let _ = writeln!(out, "\n{}", style("Parameters").bold());
        parameters(&mut out, &kind.parameters, "  ", width);
    }
    out
}

/// `text` in lines of at most `width` columns, each after `indent`.
fn put(out: &mut String, indent: &str, text: &str, width: usize) {
    for line in wrapped(text, width.saturating_sub(indent.len()).max(20)) {
        let _ = writeln!(out, "{}", format!("{indent}{line}").trim_end());
    }
}

fn ports(out: &mut String, title: &str, ports: &[PortDescription], width: usize) {
    if ports.is_empty() {
        return;
    }
    let _ = writeln!(out, "\n{}", style(title).bold());
    let shown: BTreeMap<&str, String> = ports.iter().map(|port| (port.name.as_str(), type_of(port))).collect();
    let names = shown.keys().map(|name| measure_text_width(name)).max().unwrap_or(0);
    let types = shown.values().map(|text| measure_text_width(text)).max().unwrap_or(0);
    for port in ports {
        let name = style(format!("{:<names$}", port.name)).cyan();
        let mut lines = wrapped(&port.meaning, width.saturating_sub(names + types + 6).max(20)).into_iter();
        let first = lines.next().unwrap_or_default();
        let _ = writeln!(out, "  {name}  {:<types$}  {first}", type_of(port));
        for line in lines {
            let _ = writeln!(out, "{}{line}", " ".repeat(names + types + 6));
        }
    }
}

/// The type as graphs write it for nested graphs' inputs: `Markers`, `[Markers]`, `Markers?`.
fn type_of(port: &PortDescription) -> String {
    format!("{}{}", port.type_text, if port.optional { "?" } else { "" })
}

fn parameters(out: &mut String, all: &[ParameterDescription], indent: &str, width: usize) {
    let deeper = format!("{indent}    ");
    for parameter in all {
        let head = match (&parameter.default, parameter.required) {
            (_, true) => " (must be given)".to_owned(),
            (Some(default), _) if default.len() <= 60 => format!(" = {default}"),
            _ => String::new(),
        };
        let _ = writeln!(out, "{indent}{}{head}  {}", style(&parameter.name).cyan(), style(&parameter.type_text).dim());
        if !parameter.doc.is_empty() {
            put(out, &deeper, &parameter.doc, width);
        }
        for ChoiceDescription { name, doc, fields } in &parameter.choices {
            let text = if doc.is_empty() { name.clone() } else { format!("{name}: {doc}") };
            put(out, &deeper, &text, width);
            parameters(out, fields, &format!("{deeper}    "), width);
        }
        parameters(out, &parameter.fields, &deeper, width);
    }
}
