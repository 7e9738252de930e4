//! The manual of nodes as Markdown.

use serde::Deserialize;
use std::fmt::Write;

/// What a kind of node says of itself, as `grimace nodes --json` prints it.
#[derive(Debug, Deserialize)]
pub struct Kind {
    name: String,
    folder: String,
    version: u32,
    doc: String,
    time: String,
    inputs: Vec<Port>,
    outputs: Vec<Port>,
    parameters: Vec<Parameter>,
}

#[derive(Debug, Deserialize)]
struct Port {
    name: String,
    #[serde(rename = "type")]
    type_text: String,
    meaning: String,
    optional: bool,
}

#[derive(Debug, Deserialize)]
struct Parameter {
    name: String,
    doc: String,
    #[serde(rename = "type")]
    type_text: String,
    required: bool,
    default: Option<String>,
    #[serde(default)]
    choices: Vec<Choice>,
    #[serde(default)]
    fields: Vec<Parameter>,
}

#[derive(Debug, Deserialize)]
struct Choice {
    name: String,
    doc: String,
    #[serde(default)]
    fields: Vec<Parameter>,
}

const HEAD: &str = "\
<!-- Written by `cargo xtask docs` from the comments in nodes/src. Change those, then run it again. -->

# Nodes

Every kind of node that comes with grimace, in the order in which data flows. `grimace nodes` lists them on a terminal,
and `grimace nodes KIND` shows one of them. How a graph names kinds, connects ports and gives parameters stands in
[the manual](manual.md).

A type in brackets, such as `[Markers]`, is a list of named items. A node whose input is not a list is cooked once an
item of whatever list it is connected to. Defaults are written as a graph would write them.
";

impl Kind {
    /// Whether a plugin brought it.
    pub fn is_plugin(&self) -> bool {
        self.folder.starts_with("plugins/")
    }
}

/// The whole manual.
pub fn render(kinds: &[Kind]) -> String {
    let mut out = HEAD.to_owned();
    let mut folder = "";
    for kind in kinds {
        if kind.folder != folder {
            folder = &kind.folder;
            let _ = writeln!(out, "\n[{folder}](#{folder})");
        }
        let _ = writeln!(out, "- [`{0}`](#{0}): {1}", kind.name, first_sentence(&kind.doc));
    }
    folder = "";
    for kind in kinds {
        if kind.folder != folder {
            folder = &kind.folder;
            let _ = writeln!(out, "\n## {folder}");
        }
        one(&mut out, kind);
    }
    out
}

fn one(out: &mut String, kind: &Kind) {
    let _ = writeln!(out, "\n### {}\n\n{}", kind.name, kind.doc.trim());
    let scope = if kind.inputs.is_empty() { String::new() } else { scope(&kind.time) };
    let _ = writeln!(out, "\nVersion {}.{scope}", kind.version);
    ports(out, "Input", &kind.inputs);
    ports(out, "Output", &kind.outputs);
    if !kind.parameters.is_empty() {
        let _ = writeln!(out, "\nParameters:\n");
        parameters(out, &kind.parameters, "");
    }
}

fn scope(time: &str) -> String {
    match time.strip_prefix("per frame") {
        Some(rest) => format!(" Works on each frame by itself{rest}."),
        None => " Works on the whole of its inputs.".to_owned(),
    }
}

fn ports(out: &mut String, title: &str, ports: &[Port]) {
    if ports.is_empty() {
        return;
    }
    let _ = writeln!(out, "\n| {title} | Type | Meaning |\n|---|---|---|");
    for Port { name, type_text, meaning, optional } in ports {
        let open = if *optional { ", may be left open" } else { "" };
        let _ = writeln!(out, "| `{name}` | `{type_text}`{open} | {} |", meaning.replace('|', "\\|"));
    }
}

fn parameters(out: &mut String, all: &[Parameter], indent: &str) {
    let deeper = format!("{indent}  ");
    for parameter in all {
        let Parameter { name, type_text, default, required, .. } = parameter;
        let _ = match (default, required) {
            (_, true) => write!(out, "{indent}- `{name}` ({type_text}; must be given)."),
            (Some(default), false) => write!(out, "{indent}- `{name}` = `{default}` ({type_text})."),
            (None, false) => write!(out, "{indent}- `{name}` ({type_text})."),
        };
        text(out, &parameter.doc, &deeper, " ");
        for choice in &parameter.choices {
            let _ = write!(out, "{deeper}- `{}`", choice.name);
            text(out, &choice.doc, &format!("{deeper}  "), ": ");
            parameters(out, &choice.fields, &format!("{deeper}  "));
        }
        parameters(out, &parameter.fields, &deeper);
    }
}

/// Goes on with `doc` after `before`; further paragraphs stand at `indent`.
fn text(out: &mut String, doc: &str, indent: &str, before: &str) {
    let mut paragraphs = doc.split("\n\n").map(str::trim).filter(|paragraph| !paragraph.is_empty());
    if let Some(first) = paragraphs.next() {
        let _ = write!(out, "{before}{}", joined(first));
    }
    out.push('\n');
    for paragraph in paragraphs {
        let _ = writeln!(out, "\n{indent}{}", joined(paragraph));
    }
}

fn joined(paragraph: &str) -> String {
    paragraph.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The first sentence of a description, in one line. A full stop before a small letter ends none.
fn first_sentence(doc: &str) -> String {
    let line = joined(doc.split("\n\n").next().unwrap_or_default());
    let mut ends = line.match_indices(". ").map(|(at, _)| at);
    let end = ends.find(|at| line[at + 2..].starts_with(char::is_uppercase));
    end.map_or(line.clone(), |at| line[..=at].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CALM: &str = r#"{"name": "calm", "folder": "clean", "version": 2, "doc": "Calms curves. Lags\nnothing.",
        "time": "per frame, with 2 frames on either side",
        "inputs": [{"name": "curves", "type": "Curves", "meaning": "0|1", "optional": true}], "outputs": [],
        "parameters": [{"name": "style", "doc": "How.\n\nOr how not.", "type": "`a` or `b`", "required": false,
            "default": "a", "choices": [{"name": "a", "doc": "Softly."}, {"name": "b(…)", "doc": "",
            "fields": [{"name": "n", "doc": "Times.", "type": "a number", "required": true, "default": null}]}]}]}"#;

    #[test]
    fn a_kind_becomes_a_section() {
        let kind: Kind = serde_json::from_str(CALM).unwrap();
        let page = render(&[kind]);
        let section = &page[page.find("## clean").unwrap()..];
        let expected = "## clean\n\n### calm\n\nCalms curves. Lags\nnothing.\n\n\
            Version 2. Works on each frame by itself, with 2 frames on either side.\n\n\
            | Input | Type | Meaning |\n|---|---|---|\n| `curves` | `Curves`, may be left open | 0\\|1 |\n\n\
            Parameters:\n\n- `style` = `a` (`a` or `b`). How.\n\n  Or how not.\n  - `a`: Softly.\n  \
            - `b(…)`\n    - `n` (a number; must be given). Times.\n";
        assert_eq!(section, expected);
        assert!(page.contains("- [`calm`](#calm): Calms curves.\n"));
    }
}
