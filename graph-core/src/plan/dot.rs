//! A plan as a Graphviz drawing.

use super::Plan;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The plan in the DOT language: one box a node, nested graphs as clusters, repeated nodes drawn double.
pub fn dot(plan: &Plan) -> String {
    let mut out =
        String::from("digraph grimace {\n  rankdir=LR;\n  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n");
    let mut clusters: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (index, node) in plan.nodes.iter().enumerate() {
        let folder = node.path.rsplit_once('/').map_or("", |(folder, _)| folder);
        clusters.entry(folder).or_default().push(index);
    }
    for (folder, members) in clusters {
        let indent = if folder.is_empty() {
            "  "
        } else {
            let _ =
                writeln!(out, "  subgraph {} {{\n    label={};", quoted(&format!("cluster_{folder}")), quoted(folder));
            "    "
        };
        for index in members {
            let node = &plan.nodes[index];
            let name = node.path.rsplit('/').next().unwrap_or(&node.path);
            let twice = if node.scope.is_empty() { "" } else { ", peripheries=2" };
            let label = quoted(&format!("{name}\n{}", node.kind));
            let _ = writeln!(out, "{indent}n{index} [label={label}{twice}];");
        }
        if !folder.is_empty() {
            out.push_str("  }\n");
        }
    }
    for (index, node) in plan.nodes.iter().enumerate() {
        for input in &node.inputs {
            for source in &input.sources {
                let label = quoted(input.port.name);
                let _ = writeln!(out, "  n{} -> n{index} [label={label}, fontsize=9];", source.node);
            }
        }
    }
    out.push_str("}\n");
    out
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}
