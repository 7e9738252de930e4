//! Where plugins are: beside the graph, where `GRIMACE_PLUGINS` says, and in the user's data folder. The first place that has
//! a plugin of an id counts; the same id in a later one is shadowed.

use crate::manifest::{self, Manifest, ManifestError};
use std::path::{Path, PathBuf};

/// A place in which plugins are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// `plugins/` beside the graph.
    Graph,
    /// A folder of `GRIMACE_PLUGINS`.
    Variable,
    /// The user's data folder.
    User,
}

impl Place {
    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Graph => "beside the graph",
            Self::Variable => "GRIMACE_PLUGINS",
            Self::User => "the user's folder",
        }
    }
}

/// A plugin that was found, usable or not.
#[derive(Debug, Clone)]
pub struct Found {
    /// Its `plugin.ron`.
    pub file: PathBuf,
    /// In which place.
    pub place: Place,
    /// What it says, or what is wrong with it.
    pub manifest: Result<Manifest, ManifestError>,
    /// The `plugin.ron` with the same id that counts instead.
    pub shadowed_by: Option<PathBuf>,
}

impl Found {
    /// Its id; where its manifest is wrong, that of its folder.
    pub fn id(&self) -> String {
        match &self.manifest {
            Ok(manifest) => manifest.id.clone(),
            Err(ManifestError::File { .. } | ManifestError::Text { .. } | ManifestError::Field { .. }) => {
                let folder = self.file.parent().and_then(Path::file_name);
                folder.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
            }
        }
    }
}

/// The places for one graph, in the order in which they count.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Places(pub Vec<(Place, PathBuf)>);

impl Places {
    /// The places for the graph at `graph` with these variables of the environment; those of the user alone without a graph.
    pub fn of(graph: Option<&Path>, variable: &dyn Fn(&str) -> Option<String>) -> Self {
        let set = |name: &str| variable(name).filter(|value| !value.is_empty());
        let mut places = Vec::new();
        if let Some(graph) = graph {
            let folder = graph.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            places.push((Place::Graph, folder.join("plugins")));
        }
        let listed = set("GRIMACE_PLUGINS").unwrap_or_default();
        let folders = std::env::split_paths(&listed).filter(|folder| !folder.as_os_str().is_empty());
        places.extend(folders.map(|folder| (Place::Variable, folder)));
        let data = set("XDG_DATA_HOME").map(PathBuf::from);
        let data = data.or_else(|| Some(Path::new(&set("HOME")?).join(".local/share")));
        let data = data.or_else(|| set("APPDATA").map(PathBuf::from));
        places.extend(data.map(|data| (Place::User, data.join("grimace/plugins"))));
        Self(places)
    }

    /// All plugins in them: those in folders of a place, and a place that is itself a plugin's folder.
    pub fn find(&self) -> Vec<Found> {
        let mut all: Vec<Found> = Vec::new();
        for (place, folder) in &self.0 {
            let inside = graph_core::node::folders_in(folder).into_iter().map(|name| folder.join(name));
            for folder in std::iter::once(folder.clone()).chain(inside) {
                let file = folder.join(manifest::FILE);
                if !file.is_file() || all.iter().any(|known| known.file == file) {
                    continue;
                }
                let manifest = Manifest::load(&file);
                let found = Found { file, place: *place, manifest, shadowed_by: None };
                let id = found.id();
                let first = all.iter().find(|known| known.shadowed_by.is_none() && known.id() == id);
                let shadowed_by = first.map(|first| first.file.clone());
                all.push(Found { shadowed_by, ..found });
            }
        }
        all
    }
}
