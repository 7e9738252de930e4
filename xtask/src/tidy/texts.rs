//! Rules of single files: how they open, how long they may be, what must not stand in them.

use super::{File, Findings};

/// A source file of more lines than this is two thoughts.
const LONGEST_LINES: usize = 450;
/// A source file of more lines than this should be looked at.
const LONG_LINES: usize = 400;
/// A larger file does not belong into the repository.
const LARGEST_BYTES: u64 = 1_000_000;

/// Marks of unfinished work, put together here so that this file does not hold them.
const UNFINISHED: [&str; 6] = [
    concat!("TO", "DO"),
    concat!("FIX", "ME"),
    concat!("XX", "X"),
    concat!("todo", "!("),
    concat!("unimpl", "emented!("),
    concat!("#[ign", "ore"),
];

/// How paths begin that exist on one machine only.
const OF_ONE_MACHINE: [&str; 3] = [concat!("/wo", "rk/"), concat!("/ro", "ot/"), concat!("C:", "\\Users")];

/// Holds every file against the rules.
pub fn check(files: &[File], findings: &mut Findings) {
    for file in files {
        if file.bytes > LARGEST_BYTES {
            findings.faults.push(format!("{}: {} bytes; keep large files elsewhere", file.path, file.bytes));
        }
        let Some(text) = &file.text else { continue };
        if file.is("rs") {
            source(&file.path, text, findings);
        }
        for (number, line) in text.lines().enumerate() {
            for mark in UNFINISHED.iter().filter(|mark| has_mark(line, mark)) {
                findings.faults.push(format!("{}:{}: `{mark}` marks unfinished work", file.path, number + 1));
            }
            for path in OF_ONE_MACHINE.iter().filter(|path| has_path(line, path)) {
                let fault = format!("{}:{}: `{path}` is a path of one machine", file.path, number + 1);
                findings.faults.push(fault);
            }
        }
    }
}

fn source(path: &str, text: &str, findings: &mut Findings) {
    let opening = text.lines().next().unwrap_or_default();
    if !opening.starts_with("//! ") {
        let fault = format!("{path}:1: a source file opens with `//!`: what it is, and where it stands in the flow");
        findings.faults.push(fault);
    }
    // What a program wrote is as long as it needs to be.
    let generated = opening.starts_with("//! Generated ");
    match text.lines().count() {
        _ if generated => {}
        lines if lines > LONGEST_LINES => {
            findings.faults.push(format!("{path}: {lines} lines are two thoughts; split it"));
        }
        lines if lines > LONG_LINES => findings.warnings.push(format!("{path}: {lines} lines; is it two thoughts?")),
        _ => {}
    }
}

/// Whether `mark` stands in `line` as a word of its own.
fn has_mark(line: &str, mark: &str) -> bool {
    let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
    line.match_indices(mark).any(|(at, _)| {
        let after = line[at + mark.len()..].chars().next();
        let is_open = !mark.ends_with(is_word);
        !line[..at].ends_with(is_word) && (is_open || !after.is_some_and(is_word))
    })
}

/// Whether the absolute path `path` stands in `line`, and not as the end of a longer one.
fn has_path(line: &str, path: &str) -> bool {
    line.match_indices(path).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        !before.is_some_and(|letter| letter.is_alphanumeric() || "_.-}*".contains(letter))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(path: &str, text: &str) -> Vec<String> {
        let file = File { path: path.to_owned(), text: Some(text.to_owned()), bytes: text.len() as u64 };
        let mut findings = Findings::default();
        check(&[file], &mut findings);
        findings.faults
    }

    #[test]
    fn sound_files_have_no_faults() {
        assert_eq!(faults("a.rs", "//! Calms curves.\n\nfn autodoc() {}\n"), Vec::<String>::new());
        assert_eq!(faults("a.md", "Files lie under `root/` or ../work/x.\n"), Vec::<String>::new());
    }

    #[test]
    fn every_rule_finds_its_fault() {
        assert!(faults("a.rs", "fn a() {}\n")[0].starts_with("a.rs:1: "));
        for mark in UNFINISHED {
            assert_eq!(faults("a.md", &format!("x\n{mark} x\n")).len(), 1, "{mark}");
        }
        for path in OF_ONE_MACHINE {
            assert_eq!(faults("a.md", &format!("see {path}me/x\n")).len(), 1, "{path}");
        }
        let long = "//! Long.\n".repeat(LONGEST_LINES + 1);
        assert!(faults("a.rs", &long)[0].contains("two thoughts"));
        let large = File { path: "a.bin".into(), text: None, bytes: LARGEST_BYTES + 1 };
        let mut findings = Findings::default();
        check(&[large], &mut findings);
        assert_eq!(findings.faults.len(), 1);
    }
}
