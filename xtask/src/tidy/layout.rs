//! Where things stand: nodes in files named after them, graphs in folders with a page.

use super::{File, Findings};
use std::collections::BTreeSet;
use std::path::Path;

/// Looks at the nodes and the graphs.
pub fn check(files: &[File], findings: &mut Findings) {
    let paths: BTreeSet<&str> = files.iter().map(|file| file.path.as_str()).collect();
    for file in files.iter().filter(|file| file.path.starts_with("nodes/src/") && file.is("rs")) {
        let stem = Path::new(&file.path).file_stem().unwrap_or_default().to_string_lossy();
        for tag in tags(file.text.as_deref().unwrap_or_default()) {
            if tag != stem {
                findings.faults.push(format!("{}: the node `{tag}` stands in a file of its own name", file.path));
            }
        }
    }
    let graphs: BTreeSet<&str> = paths.iter().filter_map(|path| graph_folder(path)).collect();
    for graph in graphs {
        for needed in ["graph.ron", "README.md"] {
            let path = format!("graphs/{graph}/{needed}");
            if !paths.contains(path.as_str()) {
                findings.faults.push(format!("{path} is missing: a graph is a graph.ron and a page about it"));
            }
        }
    }
}

/// `fdls` of `graphs/fdls/graph.ron`.
fn graph_folder(path: &str) -> Option<&str> {
    path.strip_prefix("graphs/")?.split_once('/').map(|(folder, _)| folder)
}

/// The tags of the nodes in a source text.
fn tags(text: &str) -> Vec<&str> {
    let lines = text.lines().filter_map(|line| line.trim().strip_prefix("#[typetag::serde(name = \""));
    lines.filter_map(|rest| rest.split('"').next()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, text: &str) -> File {
        File { path: path.to_owned(), text: Some(text.to_owned()), bytes: 0 }
    }

    #[test]
    fn misplaced_nodes_and_graphs_without_pages_are_faults() {
        let node = "//! A node.\n#[typetag::serde(name = \"load_rig\")]\nimpl Node for LoadRig {}\n";
        let mut findings = Findings::default();
        let sound = [
            file("nodes/src/load/load_rig.rs", node),
            file("graphs/a/graph.ron", "()"),
            file("graphs/a/README.md", ""),
        ];
        check(&sound, &mut findings);
        assert_eq!(findings.faults, Vec::<String>::new());
        check(&[file("nodes/src/load/rig.rs", node), file("graphs/b/graph.ron", "()")], &mut findings);
        assert_eq!(findings.faults.len(), 2, "{:?}", findings.faults);
    }
}
