//! `cargo xtask new-node FOLDER NAME`: a node that compiles and passes its test, to be changed into the one wanted.

use crate::failure::Failure;
use crate::repository::Repository;
use crate::say;

/// The node to start from. It is real code: the whole-system tests compile it and run its test.
const TEMPLATE: &str = include_str!("node_name.rs");

/// Writes `nodes/src/FOLDER/NAME.rs`, and names it in the folder's `mod.rs`.
pub fn run(repository: &Repository, folder: &str, name: &str) -> Result<(), Failure> {
    let refuse = |problem: String| Err(Failure::CommandLine(problem));
    if !is_name(name) {
        return refuse(format!("`{name}` is no name for a node: write a verb and its object, such as smooth_curves"));
    }
    let folders = folders(repository)?;
    if !folders.iter().any(|known| known == folder) {
        let known = folders.join(", ");
        return refuse(format!("there is no folder nodes/src/{folder} with a mod.rs; there are {known}"));
    }
    let file = format!("nodes/src/{folder}/{name}.rs");
    if let Some(taken) = repository.files()?.iter().find(|file| file.ends_with(&format!("/{name}.rs"))) {
        return refuse(format!("{taken} stands there already"));
    }
    let modules = format!("nodes/src/{folder}/mod.rs");
    let listed = with_module(&repository.read(&modules)?, name);
    repository.write(&file, &filled(folder, name))?;
    repository.write(&modules, &listed)?;
    say::line(&format!("{file}: now say what it does; `cargo test -p nodes {name}` runs its test"));
    say::line(&format!("{modules}: names it"));
    Ok(())
}

fn is_name(name: &str) -> bool {
    let words = name.split('_').all(|word| !word.is_empty());
    let letters = name.chars().all(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_');
    words && letters && name.starts_with(|first: char| first.is_ascii_lowercase()) && name.contains('_')
}

/// The folders of nodes; `values` holds types of value.
fn folders(repository: &Repository) -> Result<Vec<String>, Failure> {
    let files = repository.files()?;
    let within = files.iter().filter_map(|file| file.strip_prefix("nodes/src/")?.strip_suffix("/mod.rs"));
    Ok(within.filter(|folder| !folder.contains('/') && *folder != "values").map(str::to_owned).collect())
}

/// `smooth_curves` as the name of a type: `SmoothCurves`.
fn type_name(name: &str) -> String {
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    name.split('_').map(capital).collect()
}

fn filled(folder: &str, name: &str) -> String {
    TEMPLATE
        .replace("NodeName", &type_name(name))
        .replace("node_name", name)
        .replace("Card::new(\"clean\")", &format!("Card::new(\"{folder}\")"))
}

/// The text of a `mod.rs` with a `mod` line and a `pub use` line for `name`, each in the order of the alphabet.
fn with_module(text: &str, name: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    insert(&mut lines, "mod ", format!("mod {name};"));
    insert(&mut lines, "pub use ", format!("pub use {name}::{};", type_name(name)));
    lines.join("\n") + "\n"
}

/// Puts `line` among the lines that begin with `opening`, before the first that comes after it in the alphabet.
fn insert(lines: &mut Vec<String>, opening: &str, line: String) {
    let of_kind: Vec<usize> = (0..lines.len()).filter(|at| lines[*at].starts_with(opening)).collect();
    let later = of_kind.iter().copied().find(|at| lines[*at] > line);
    match (later, of_kind.last()) {
        (Some(at), _) => lines.insert(at, line),
        (None, Some(last)) => lines.insert(last + 1, line),
        (None, None) => lines.extend([String::new(), line]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_a_verb_and_its_object() {
        assert!(is_name("smooth_curves") && is_name("solve_2d_flow"));
        for wrong in ["SmoothCurves", "smooth", "smooth-curves", "_x", "a__b", "2d_flow", "smooth_", ""] {
            assert!(!is_name(wrong), "{wrong}");
        }
        assert_eq!(type_name("smooth_curves"), "SmoothCurves");
    }

    #[test]
    fn modules_are_named_in_order() {
        let before = "//! Nodes.\n\nmod load_curves;\nmod load_rig;\n\npub use load_curves::LoadCurves;\n";
        let after = "//! Nodes.\n\nmod load_curves;\nmod load_markers;\nmod load_rig;\n\n\
            pub use load_curves::LoadCurves;\npub use load_markers::LoadMarkers;\n";
        assert_eq!(with_module(before, "load_markers"), after);
        let empty = with_module("//! Nodes.\n", "load_rig");
        assert_eq!(empty, "//! Nodes.\n\nmod load_rig;\n\npub use load_rig::LoadRig;\n");
    }

    #[test]
    fn nothing_of_the_template_stays_in_a_new_node() {
        let text = filled("solve", "solve_jaw");
        assert!(text.starts_with("//! `solve_jaw`: "));
        assert!(text.contains("pub struct SolveJaw") && text.contains("Card::new(\"solve\")"));
        assert!(!text.contains("NodeName") && !text.contains("node_name"));
    }
}
