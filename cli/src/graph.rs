//! From what the command line says of a graph to its file, its overrides, its plan and its store.

use crate::arguments::{GraphArguments, StoreArguments};
use crate::exit::Trouble;
use crate::mistakes;
use graph_core::document::{Diagnostics, Literal, Override};
use graph_core::plan::{self, Plan};
use graph_core::store::Store;
use std::path::{Path, PathBuf};

/// The graph file that `named` means: itself, or the `graph.ron` in it.
pub fn file(named: &Path) -> PathBuf {
    let within = named.join("graph.ron");
    if named.is_dir() && within.is_file() { within } else { named.to_owned() }
}

/// A graph that was asked for, with everything set on the command line.
#[derive(Debug)]
pub struct Asked {
    /// The graph file.
    pub path: PathBuf,
    /// What `--set` and `--out` say.
    pub overrides: Vec<Override>,
    /// The folder that `--out` names.
    out: Option<String>,
}

impl Asked {
    /// Reads the arguments.
    ///
    /// # Errors
    /// Where a `--set` cannot be read.
    pub fn read(arguments: &GraphArguments) -> Result<Self, Trouble> {
        let mut overrides = Vec::with_capacity(arguments.set.len() + 1);
        for text in &arguments.set {
            let parsed = Override::parse(text);
            overrides.push(parsed.map_err(|mistake| Trouble::command_line(mistake.message, mistake.help))?);
        }
        let out = match &arguments.out {
            None => None,
            Some(folder) => {
                let folder = folder.to_str().ok_or_else(|| {
                    Trouble::command_line(format!("--out {} is not UTF-8 text", folder.display()), None)
                })?;
                overrides.push(Override {
                    path: Vec::new(),
                    name: "out".to_owned(),
                    value: Literal::Text(folder.to_owned()),
                    raw: folder.to_owned(),
                    text: format!("out={folder}"),
                });
                Some(folder.to_owned())
            }
        };
        Ok(Self { path: file(&arguments.graph), overrides, out })
    }

    /// The plan of the graph.
    ///
    /// # Errors
    /// Every mistake in it.
    pub fn load(&self) -> Result<Plan, Diagnostics> {
        plan::load(&self.path, &self.overrides).map_err(|mut mistakes| {
            self.name_out(&mut mistakes);
            mistakes
        })
    }

    /// The plan of the graph; mistakes are shown to people.
    ///
    /// # Errors
    /// Where the graph, or what was set, is wrong.
    pub fn load_or_tell(&self) -> Result<Plan, Trouble> {
        self.load().map_err(mistakes::tell)
    }

    /// Lets mistakes in `out` name `--out`, where that is what was written.
    fn name_out(&self, mistakes: &mut Diagnostics) {
        let Some(out) = &self.out else { return };
        let set = format!("`--set out={out}`");
        for mistake in &mut mistakes.0 {
            if mistake.message.contains(&set) {
                mistake.message = mistake.message.replace(&set, &format!("`--out {out}`"));
                if mistake.code == "unknown-parameter" {
                    let cure =
                        "give it one: params: { \"out\": \"out\" }, and begin the paths that it writes with ${out}/";
                    mistake.help = Some(cure.to_owned());
                }
            }
        }
    }
}

/// Where the store is: as the command line or the environment says, or beside the graph.
pub fn store_place(arguments: &StoreArguments, graph: &Path) -> PathBuf {
    let beside = || graph.parent().unwrap_or(Path::new("")).join(".grimace");
    arguments.store.clone().filter(|place| !place.as_os_str().is_empty()).unwrap_or_else(beside)
}

/// The store that the command line asks for.
pub fn store(arguments: &StoreArguments, graph: &Path) -> Store {
    Store::at(&store_place(arguments, graph))
}
