//! Paths that pages name: what a link points to, or what looks like a path of this repository, exists.

use super::{File, Findings};
use crate::repository::Repository;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// Looks at every Markdown page.
pub fn check(repository: &Repository, files: &[File], findings: &mut Findings) {
    let tops: BTreeSet<&str> = files.iter().filter_map(|file| file.path.split_once('/')).map(|(top, _)| top).collect();
    let exists = |path: &Path| normal(path).is_some_and(|path| repository.path(path).exists());
    for page in files.iter().filter(|file| file.is("md")) {
        let folder = Path::new(&page.path).parent().unwrap_or(Path::new(""));
        for (line, target) in links(page.text.as_deref().unwrap_or_default()) {
            if !exists(&folder.join(target)) {
                findings.faults.push(format!("{}:{line}: the link to `{target}` leads nowhere", page.path));
            }
        }
        for (line, path) in quoted(page.text.as_deref().unwrap_or_default()) {
            let top = path.split('/').next().unwrap_or_default();
            let is_ours = tops.contains(top) && path.contains('/') && path.chars().all(is_plain);
            if is_ours && !exists(Path::new(path)) && !exists(&folder.join(path)) {
                findings.faults.push(format!("{}:{line}: there is no `{path}`", page.path));
            }
        }
    }
}

/// Paths with wild cards or gaps to fill in are examples.
fn is_plain(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || "/._-".contains(letter)
}

/// The path without `.` and `..`; `None` where it leads out of the repository.
fn normal(path: &Path) -> Option<PathBuf> {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => normal.push(name),
            Component::CurDir => {}
            Component::ParentDir => {
                if !normal.pop() {
                    return None;
                }
            }
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(normal)
}

/// Lines of prose with their numbers: those of fenced blocks are left out.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
            return None;
        }
        (!fenced).then_some((index + 1, line))
    })
}

/// Targets of links within the repository, without anchors, with their lines.
fn links(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for (number, line) in prose(text) {
        for (at, _) in line.match_indices("](") {
            let rest = &line[at + 2..];
            let target = rest.split([')', ' ', '#']).next().unwrap_or_default();
            if !target.is_empty() && !target.contains(':') {
                found.push((number, target));
            }
        }
    }
    found
}

/// What stands in backticks, with its line.
fn quoted(text: &str) -> Vec<(usize, &str)> {
    prose(text).flat_map(|(number, line)| line.split('`').skip(1).step_by(2).map(move |part| (number, part))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_and_quoted_paths_are_found_outside_of_fenced_blocks() {
        let text = "See [a](docs/a.md#top), [b](https://b.c/d) and [c](#c).\n```\n[x](y) `z/w`\n```\nIn `docs/a.md`.\n";
        assert_eq!(links(text), [(1, "docs/a.md")]);
        assert_eq!(quoted(text), [(5, "docs/a.md")]);
    }

    #[test]
    fn paths_are_walked() {
        assert_eq!(normal(Path::new("docs/decisions/../manual.md")), Some(PathBuf::from("docs/manual.md")));
        assert_eq!(normal(Path::new("docs/../../x")), None);
    }

    #[test]
    fn dead_paths_are_faults() {
        let folder = tempfile::tempdir().unwrap();
        let repository = Repository::at(folder.path());
        std::fs::create_dir(folder.path().join("docs")).unwrap();
        std::fs::write(folder.path().join("docs/a.md"), "").unwrap();
        let text = "[a](a.md) [no](b.md) `docs/a.md` `docs/c.md` `docs/*.md` `elsewhere/x`\n";
        let page = File { path: "docs/page.md".into(), text: Some(text.into()), bytes: 0 };
        let mut findings = Findings::default();
        check(&repository, &[page], &mut findings);
        let expected = ["docs/page.md:1: the link to `b.md` leads nowhere", "docs/page.md:1: there is no `docs/c.md`"];
        assert_eq!(findings.faults, expected);
    }
}
