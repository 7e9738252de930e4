//! The graph files of a random model.

use crate::model::{Group, Model, Work};
use std::collections::BTreeMap;
use std::fmt::Write;

impl Model {
    pub fn graphs(&self) -> BTreeMap<String, String> {
        let mut all = BTreeMap::new();
        let mut lines = Vec::new();
        for (id, node) in self.nodes.iter().filter(|(_, node)| node.group.is_none()) {
            let sources: Vec<String> = node.inputs.iter().map(|id| format!("\"{}\"", self.reference(*id))).collect();
            let inputs = match node.work {
                Work::Read(_) | Work::ReadAll => String::new(),
                Work::Add => format!("\"series\": {}, \"number\": {}", sources[0], sources[1]),
                _ => format!("\"series\": [{}]", sources.join(", ")),
            };
            let with = match &node.work {
                Work::Read(path) => format!("path: \"{path}\""),
                Work::ReadAll => "path: \"takes/*.txt\"".to_owned(),
                Work::Write if self.scope(*id).is_empty() => format!("path: \"out/{}.txt\"", node.name),
                Work::Write => format!("path: \"out/{}_{{take}}.txt\"", node.name),
                work => parameters(work),
            };
            lines.push(format!(
                "\"{}\": (kind: \"{}\", in: {{{inputs}}}, with: ({with})),",
                node.name,
                node.work.kind()
            ));
        }
        for (group, Group { members, deeper }) in &self.groups {
            let from = self.nodes[&members[0]].inputs[0];
            let source = self.reference(from);
            let taken = if self.reach(from).is_empty() {
                format!("in: {{\"series\": \"{source}\"}}")
            } else {
                format!("for_each: \"{source}\"")
            };
            lines.push(format!("\"g{group}\": ({taken}, graph: \"g{group}.ron\"),"));
            let (outer, inner) = members.split_at(*deeper);
            let mut text = self.chain(outer);
            if !inner.is_empty() {
                let last = &self.nodes[&outer[outer.len() - 1]].name;
                let _ = write!(text, "\"in\": (graph: \"g{group}_in.ron\", in: {{\"series\": \"{last}\"}}),");
                all.insert(
                    format!("g{group}_in.ron"),
                    nested(&self.chain(inner), &self.nodes[&inner[inner.len() - 1]].name),
                );
            }
            let out = if inner.is_empty() { self.nodes[&outer[outer.len() - 1]].name.as_str() } else { "in" };
            all.insert(format!("g{group}.ron"), nested(&text, out));
        }
        if self.reversed {
            lines.reverse();
        }
        all.insert("graph.ron".to_owned(), format!("(grimace: 1, nodes: {{\n{}\n}})", lines.join("\n")));
        all
    }

    fn chain(&self, members: &[usize]) -> String {
        let mut text = String::new();
        for (position, id) in members.iter().enumerate() {
            let node = &self.nodes[id];
            let from = position.checked_sub(1).map_or("series", |before| self.nodes[&members[before]].name.as_str());
            let (name, kind, with) = (&node.name, node.work.kind(), parameters(&node.work));
            let _ = writeln!(text, "\"{name}\": (kind: \"{kind}\", in: {{\"series\": \"{from}\"}}, with: ({with})),");
        }
        text
    }
}

fn nested(nodes: &str, output: &str) -> String {
    format!(
        "(grimace: 1, inputs: {{\"series\": \"Series\"}}, outputs: {{\"series\": \"{output}\"}}, nodes: {{\n{nodes}}})"
    )
}

fn parameters(work: &Work) -> String {
    match work {
        Work::Scale(by) => format!("by: {by:?}"),
        Work::Blur(halo) => format!("halo: {halo}"),
        Work::Versioned(slot) => format!("slot: {slot}"),
        Work::Sum(offset) => format!("offset: {offset:?}"),
        _ => String::new(),
    }
}

impl Work {
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Read(_) | Self::ReadAll => "read",
            Self::Scale(_) => "scale",
            Self::Blur(_) => "blur",
            Self::Round => "round",
            Self::Versioned(_) => "versioned",
            Self::Sum(_) => "sum",
            Self::Mean => "mean",
            Self::Split => "split",
            Self::Add => "add",
            Self::Write => "write",
        }
    }

    /// The parameters as they stand in JSON, to make the node in memory.
    pub fn json(&self) -> serde_json::Value {
        match self {
            Self::Scale(by) => serde_json::json!({ "by": by }),
            Self::Sum(offset) => serde_json::json!({ "offset": offset }),
            _ => serde_json::json!({}),
        }
    }
}
