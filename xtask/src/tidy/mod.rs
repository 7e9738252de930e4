//! `cargo xtask tidy`: the repository's own rules, which no compiler holds.

mod layout;
mod pages;
mod texts;

use crate::failure::Failure;
use crate::repository::Repository;
use crate::say;

/// What was found: faults, and things to think about.
#[derive(Debug, Default)]
struct Findings {
    faults: Vec<String>,
    warnings: Vec<String>,
}

/// A file of the repository.
struct File {
    /// Its path from the root.
    path: String,
    /// Its text; `None` where it is no text.
    text: Option<String>,
    bytes: u64,
}

impl File {
    fn is(&self, extension: &str) -> bool {
        std::path::Path::new(&self.path).extension().is_some_and(|own| own == extension)
    }
}

/// Looks at every file. Warnings are printed; faults fail.
pub fn run(repository: &Repository) -> Result<(), Failure> {
    let files = repository.files()?.into_iter().map(|path| read(repository, path)).collect::<Result<Vec<_>, _>>()?;
    let mut findings = Findings::default();
    texts::check(&files, &mut findings);
    pages::check(repository, &files, &mut findings);
    layout::check(&files, &mut findings);
    for warning in &findings.warnings {
        say::line(&format!("note: {warning}"));
    }
    if findings.faults.is_empty() {
        say::line(&format!("{} files are tidy", files.len()));
        return Ok(());
    }
    findings.faults.push(format!("tidy: {} faults", findings.faults.len()));
    Err(Failure::Findings(findings.faults))
}

fn read(repository: &Repository, path: String) -> Result<File, Failure> {
    let place = repository.path(&path);
    let bytes = std::fs::read(&place).map_err(|problem| Failure::File { path: place, problem })?;
    Ok(File { path, bytes: bytes.len() as u64, text: String::from_utf8(bytes).ok() })
}
