//! The repository on disk: its root, its tracked files, its packages, and programs run in it.

use crate::failure::Failure;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The repository that this program was built from.
#[derive(Debug, Clone)]
pub struct Repository {
    root: PathBuf,
}

impl Repository {
    /// The repository that this program was built from.
    pub fn here() -> Self {
        let own = Path::new(env!("CARGO_MANIFEST_DIR"));
        Self { root: own.parent().unwrap_or(own).to_owned() }
    }

    /// The repository at `root`, for tests.
    #[cfg(test)]
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    /// Where the path `relative` to the root lies.
    pub fn path(&self, relative: impl AsRef<Path>) -> PathBuf {
        self.root.join(relative)
    }

    /// The program `name`, to be run at the root. What cargo told this program of itself is kept from it, since tools
    /// such as cargo-machete would take it for theirs.
    pub fn program(&self, name: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(name);
        command.current_dir(&self.root);
        for (name, _) in std::env::vars_os() {
            let text = name.to_string_lossy();
            if text.starts_with("CARGO_PKG_") || text.starts_with("CARGO_MANIFEST_") {
                command.env_remove(&name);
            }
        }
        command
    }

    /// The cargo that runs this, with `arguments`.
    pub fn cargo<'a>(&self, arguments: impl IntoIterator<Item = &'a str>) -> Command {
        let mut command = self.program(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.args(arguments);
        command
    }

    /// The files that git tracks, or would if they were added, by their paths from the root, in their order. In a copy
    /// without git, all files that are not built.
    pub fn files(&self) -> Result<Vec<String>, Failure> {
        let mut git = self.program("git");
        git.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]).stderr(Stdio::null());
        let listed = git.output().ok().filter(|output| output.status.success());
        let mut files: Vec<String> = match listed {
            Some(output) => String::from_utf8_lossy(&output.stdout).split_terminator('\0').map(str::to_owned).collect(),
            None => self.walk()?,
        };
        files.retain(|file| self.path(file).is_file());
        files.sort_unstable();
        files.dedup();
        Ok(files)
    }

    fn walk(&self) -> Result<Vec<String>, Failure> {
        let (mut files, mut open) = (Vec::new(), vec![PathBuf::new()]);
        while let Some(folder) = open.pop() {
            let place = self.path(&folder);
            let entries = std::fs::read_dir(&place).map_err(|problem| Failure::File { path: place, problem })?;
            for entry in entries.flatten() {
                let name = entry.file_name().to_string_lossy().into_owned();
                let path = folder.join(&name);
                let built = name == "target" || name == "out" || name == ".git" || name == ".grimace";
                match entry.file_type() {
                    Ok(kind) if kind.is_dir() && !built => open.push(path),
                    Ok(kind) if kind.is_file() => files.push(path.to_string_lossy().into_owned()),
                    _ => {}
                }
            }
        }
        Ok(files)
    }

    /// The text of the file at `relative`.
    pub fn read(&self, relative: &str) -> Result<String, Failure> {
        let path = self.path(relative);
        std::fs::read_to_string(&path).map_err(|problem| Failure::File { path, problem })
    }

    /// Writes the file at `relative`.
    pub fn write(&self, relative: &str, text: &str) -> Result<(), Failure> {
        let path = self.path(relative);
        std::fs::write(&path, text).map_err(|problem| Failure::File { path, problem })
    }
}

/// The command as one would type it.
pub fn shown(command: &Command) -> String {
    let name = Path::new(command.get_program()).file_name().unwrap_or_default();
    let words = std::iter::once(name).chain(command.get_args());
    words.map(OsStr::to_string_lossy).collect::<Vec<_>>().join(" ")
}

fn failed(command: &Command, problem: String) -> Failure {
    Failure::Command { command: shown(command), problem }
}

/// Runs a command whose words go straight to the terminal.
pub fn run(command: &mut Command) -> Result<(), Failure> {
    let status = command.status().map_err(|problem| failed(command, format!("cannot be started: {problem}")))?;
    if status.success() { Ok(()) } else { Err(failed(command, format!("failed ({status})"))) }
}

/// Runs a command and gives what it wrote to standard output; its troubles go straight to the terminal.
pub fn output_of(command: &mut Command) -> Result<String, Failure> {
    let output = command.stderr(Stdio::inherit()).output();
    let output = output.map_err(|problem| failed(command, format!("cannot be started: {problem}")))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(failed(command, format!("failed ({})", output.status)))
    }
}
