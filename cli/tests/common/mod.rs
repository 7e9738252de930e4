//! A project in a folder of its own, and the program run in it.

#![allow(dead_code, reason = "each test file uses a part")]
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on fails")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Two takes of curves, gathered by nobody, and a head.
pub const GRAPH: &str = r#"(
    grimace: 1,
    params: { "takes": "takes/*.csv" },
    nodes: {
        "takes": (kind: "load_curves", with: (path: "${takes}")),
        "still": (kind: "load_curves", with: (path: "rom.csv", rate_hz: 24.0)),
    },
)
"#;

/// A graph with one mistake in each node.
pub const WRONG: &str = r#"(
    grimace: 1,
    nodes: {
        "a": (kind: "load_curvs"),
        "b": (kind: "load_curves", with: (pth: "rom.csv")),
    },
)
"#;

pub struct Project {
    folder: tempfile::TempDir,
}

/// What a run of the program gave.
pub struct Ran {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Project {
    /// A project whose graph has the text `graph`, with two takes and a range of motion.
    pub fn new(graph: &str) -> Self {
        let project = Self { folder: tempfile::tempdir().unwrap() };
        project.write("graph.ron", graph);
        project.take("a", 0.5);
        project.take("b", 0.25);
        project.write("rom.csv", "frame,jawOpen\n1,0\n2,1\n3,0\n");
        project
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    pub fn take(&self, name: &str, weight: f64) {
        let text = format!("# rate_hz: 60\nframe,jawOpen,mouthSmile_L\n1,0,0\n2,{weight},1\n");
        self.write(&format!("takes/{name}.csv"), &text);
    }

    /// Makes the takes so long that reading them takes longer than a look into the store: what is cheaper is not kept there.
    pub fn long_takes(&self) {
        self.long_take("takes/a.csv", 0.5);
        self.long_take("takes/b.csv", 0.25);
        self.long_take("rom.csv", 1.0);
    }

    /// A take of a thousand frames.
    pub fn long_take(&self, name: &str, weight: f64) {
        let rate = if name.starts_with("takes/") { "# rate_hz: 60\n" } else { "" };
        let frames = (0..1000).map(|frame| format!("{frame},{},{}\n", weight * f64::from(frame) / 1000.0, frame % 2));
        self.write(name, &format!("{rate}frame,jawOpen,mouthSmile_L\n{}", frames.collect::<String>()));
    }

    /// The program, to be run in the project's folder as from a shell without settings.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_grimace"));
        command.args(arguments).current_dir(self.folder.path());
        let ours =
            std::env::vars_os().map(|(name, _)| name).filter(|name| name.to_string_lossy().starts_with("GRIMACE_"));
        let colours = ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "FORCE_COLOR"];
        for name in ours.chain(colours.map(Into::into)) {
            command.env_remove(name);
        }
        command.env("XDG_CONFIG_HOME", self.path("config"));
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        Ran::of(self.command(arguments).output().unwrap())
    }
}

impl Ran {
    pub fn of(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// Fails with all that was written where the code is another one.
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "stdout:\n{}\nstderr:\n{}", self.out, self.err);
        self
    }

    /// Standard output as JSON, one object a line.
    pub fn json(&self) -> Vec<Value> {
        self.out.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("no JSON: {line}"))).collect()
    }

    /// The last event, which must be the summary.
    pub fn summary(&self) -> Value {
        let last = self.json().pop().expect("no event");
        assert_eq!(last["event"], "summary", "{last}");
        last
    }
}

/// The path of a file as the program prints it.
pub fn shown(path: &Path) -> String {
    path.display().to_string()
}
