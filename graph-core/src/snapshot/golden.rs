//! Snapshots as files: in a folder `golden` beside the graph, one file an output, one for how the graph was cooked, and one for
//! what each cell was made of. Read with serde; written so that people can read and compare them.

use super::reduce::Reduced;
use super::taken::Taken;
use super::trace::Trace;
use super::written;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file of how the graph was cooked.
const SETTINGS: &str = "snapshot.ron";
/// The file of what each cell was made of.
const TRACE: &str = "trace.ron";
/// The folder of outputs.
const OUTPUTS: &str = "outputs";

/// A snapshot as files hold it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Golden {
    /// What was set when it was taken, as `--set` takes it.
    pub set: Vec<String>,
    /// What a second cook did.
    pub second_cook: Hits,
    /// The outputs, by name.
    pub outputs: BTreeMap<String, HeldOutput>,
    /// What the cells before them were made of and gave.
    pub trace: Trace,
}

/// What a second cook did, right after the first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hits {
    /// Cells computed.
    pub cooked: usize,
    /// Cells that were up to date.
    pub cached: usize,
}

/// An output as files hold it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldOutput {
    /// Its name.
    pub output: String,
    /// Type of its values.
    pub kind: String,
    /// Version of their encoding.
    pub version: u32,
    /// Tolerances set by hand, by table; others are those of the type.
    #[serde(default)]
    pub tolerances: BTreeMap<String, HeldTolerance>,
    /// The values, by item.
    pub items: BTreeMap<String, Reduced>,
}

/// A tolerance that was set by hand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HeldTolerance {
    /// In the unit of the numbers.
    pub absolute: f64,
    /// As a share of the expected number.
    pub relative: f64,
}

/// Why a snapshot cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    /// There is none.
    #[error("there is no snapshot in {}; `grimace snapshot accept GRAPH` takes one", .0.display())]
    None(PathBuf),
    /// A file cannot be read or written.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        problem: io::Error,
    },
    /// A file is not what a snapshot is.
    #[error("{}:{problem}; mend it, or take the snapshot anew with `grimace snapshot accept GRAPH`", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Where, and what is wrong.
        problem: ron::error::SpannedError,
    },
}

/// What the file of settings says.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    #[serde(default)]
    set: Vec<String>,
    second_cook: Hits,
}

impl Golden {
    /// The folder of the snapshot of the graph at `graph`.
    pub fn folder(graph: &Path) -> PathBuf {
        graph.parent().unwrap_or(Path::new("")).join("golden")
    }

    /// Reads the snapshot in `folder`.
    ///
    /// # Errors
    /// Where there is none, or a file of it is not what it should be.
    pub fn read(folder: &Path) -> Result<Self, GoldenError> {
        if !folder.join(SETTINGS).is_file() {
            return Err(GoldenError::None(folder.to_owned()));
        }
        let settings: Settings = parsed(&folder.join(SETTINGS))?;
        let trace = parsed(&folder.join(TRACE))?;
        let mut outputs = BTreeMap::new();
        for path in files(&folder.join(OUTPUTS))? {
            let output: HeldOutput = parsed(&path)?;
            outputs.insert(output.output.clone(), output);
        }
        Ok(Self { set: settings.set, second_cook: settings.second_cook, outputs, trace })
    }

    /// A snapshot of what was taken, with the tolerances that `before` holds.
    pub fn new(taken: &Taken, set: Vec<String>, second_cook: Hits, before: Option<&Self>) -> Self {
        let held = |(name, output): (&String, &super::TakenOutput)| {
            let tolerances = before.and_then(|before| before.outputs.get(name)).map(|held| held.tolerances.clone());
            let items = output.items.iter().map(|(item, (_, reduced))| (item.clone(), reduced.clone())).collect();
            let output = HeldOutput {
                output: name.clone(),
                kind: output.kind.to_owned(),
                version: output.version,
                tolerances: tolerances.unwrap_or_default(),
                items,
            };
            (name.clone(), output)
        };
        Self { set, second_cook, outputs: taken.outputs.iter().map(held).collect(), trace: taken.trace.clone() }
    }

    /// Writes the snapshot into `folder`; files of outputs that it does not hold are removed. Gives the files whose text changed.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path, taken: &Taken) -> Result<Vec<PathBuf>, GoldenError> {
        let outputs = folder.join(OUTPUTS);
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |problem| GoldenError::File { path, problem }
        };
        fs::create_dir_all(&outputs).map_err(failed(&outputs))?;
        let mut texts = BTreeMap::from([
            (folder.join(SETTINGS), written::settings(&self.set, &self.second_cook)),
            (folder.join(TRACE), written::trace(&self.trace)),
        ]);
        for (name, output) in &self.outputs {
            let own = taken.outputs.get(name).map(|taken| &taken.tolerances);
            texts.insert(outputs.join(file_name(name)), written::output(output, own));
        }
        for gone in files(&outputs)?.into_iter().filter(|path| !texts.contains_key(path)) {
            fs::remove_file(&gone).map_err(failed(&gone))?;
        }
        let mut changed = Vec::new();
        for (path, text) in texts {
            if fs::read_to_string(&path).is_ok_and(|standing| standing == text) {
                continue;
            }
            fs::write(&path, text).map_err(failed(&path))?;
            changed.push(path);
        }
        Ok(changed)
    }
}

/// The file of the output `name`.
fn file_name(name: &str) -> String {
    format!("{}.ron", name.replace('/', "."))
}

/// The RON files of a folder, in the order of their names; none where there is no folder.
fn files(folder: &Path) -> Result<Vec<PathBuf>, GoldenError> {
    let failed = |problem| GoldenError::File { path: folder.to_owned(), problem };
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(problem) if problem.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(problem) => return Err(failed(problem)),
    };
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>().map_err(failed)?;
    let mut paths: Vec<_> =
        paths.into_iter().filter(|path| path.extension().is_some_and(|ending| ending == "ron")).collect();
    paths.sort();
    Ok(paths)
}

fn parsed<T: DeserializeOwned>(path: &Path) -> Result<T, GoldenError> {
    let text = fs::read_to_string(path).map_err(|problem| GoldenError::File { path: path.to_owned(), problem })?;
    ron::from_str(&text).map_err(|problem| GoldenError::Text { path: path.to_owned(), problem })
}
