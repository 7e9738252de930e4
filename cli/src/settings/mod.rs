//! Settings: what is set once for a user, a show or a machine instead of on every command line. `names` lists them, `layers`
//! reads where they are set, `explain` tells. None of them changes a result, and none enters a key.

mod explain;
mod layers;
mod names;

pub use explain::explain;

use crate::arguments::Cli;
use crate::colours::When;
use crate::exit::Trouble;
use crate::graph;
use crate::logs::Level;
use clap::ValueEnum;
use layers::Layers;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Where a setting was set; what comes later counts more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    /// Nowhere.
    Default,
    /// The user's own file.
    User,
    /// A file above the graph.
    Project,
    /// A variable of the environment.
    Environment,
    /// The command line.
    CommandLine,
}

/// A value that was found for a setting.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Found {
    /// The value, as text.
    pub value: String,
    /// Where it was set.
    pub layer: Layer,
    /// `file:line:column`, the variable, or the option.
    pub place: String,
}

/// All settings, each with every layer that sets it.
#[derive(Debug, Default)]
pub struct Settings(Layers);

impl Settings {
    /// Gathers what files, the environment and the command line set for the graph that the command is about, and fills in
    /// what the command line leaves open.
    ///
    /// # Errors
    /// Where a file, a variable or a name in them is wrong.
    pub fn gather(cli: &mut Cli) -> Result<Self, Trouble> {
        let graph = cli.command.graph().map(|graph| graph::file(graph));
        let folder = graph.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let mut layers = Layers::new();
        for (layer, file) in layers::files(folder, |name| std::env::var_os(name)) {
            layers::read_file(layer, &file, &mut layers).map_err(|mistakes| {
                crate::mistakes::tell(mistakes);
                Trouble::Settings(file.clone())
            })?;
        }
        layers::read_environment(std::env::vars_os(), &mut layers)?;
        let mut settings = Self(layers);
        settings.take_in(cli);
        Ok(settings)
    }

    /// Takes what the command line sets, and gives it the rest.
    fn take_in(&mut self, cli: &mut Cli) {
        let (store, cook) = cli.command.settable();
        if let Some(store) = store {
            let given = store.store.as_ref().filter(|path| !path.as_os_str().is_empty());
            self.put("store", given.map(|path| path.display().to_string()));
            if given.is_none() {
                store.store = self.value("store").map(PathBuf::from);
            }
        }
        if let Some(cook) = cook {
            self.put("jobs", cook.jobs.map(|jobs| jobs.to_string()));
            cook.jobs = cook.jobs.or_else(|| self.value("jobs")?.parse().ok());
            self.put("memory", cook.memory.map(|memory| memory.to_string()));
            cook.memory = cook.memory.or_else(|| self.value("memory")?.parse().ok());
        }
        let global = &mut cli.global;
        self.put("color", name_of(global.color));
        global.color = global.color.or_else(|| When::from_str(self.value("color")?, false).ok());
        self.put("log", name_of(global.log));
        global.log = global.log.or_else(|| Level::from_str(self.value("log")?, false).ok());
        self.put("log_file", global.log_file.as_ref().map(|path| path.display().to_string()));
        global.log_file = global.log_file.take().or_else(|| self.value("log_file").map(PathBuf::from));
    }

    /// Notes what the command line sets.
    fn put(&mut self, name: &'static str, value: Option<String>) {
        if let Some(value) = value {
            let place = format!("--{}", name.replace('_', "-"));
            self.0.entry(name).or_default().push(Found { value, layer: Layer::CommandLine, place });
        }
    }

    /// The value that counts.
    fn value(&self, name: &str) -> Option<&str> {
        self.0.get(name)?.last().map(|found| found.value.as_str())
    }
}

/// The name of a choice, as it is written on the command line.
fn name_of<T: ValueEnum>(choice: Option<T>) -> Option<String> {
    choice?.to_possible_value().map(|value| value.get_name().to_owned())
}
