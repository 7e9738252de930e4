//! The kinds of the plugins that one graph may use. Nothing is read before the graph names a kind of a plugin, and then
//! that plugin alone; all of them only for suggestions and lists.

use crate::component::{Plugin, read};
use crate::discover::{Found, Places};
use crate::fault::LoadError;
use crate::kind;
use crate::lock::{Lock, LockError};
use crate::manifest::Manifest;
use graph_core::node::{Bringer, Catalogue, Grounds, Kind, NoKind, folders_in};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use wire::{Digest, Hasher};

/// Brings the kinds of plugins to every graph that a program which links this crate loads.
#[derive(Debug)]
pub struct Bringing;

impl Bringer for Bringing {
    fn open(&self, graph: &Path, variable: &dyn Fn(&str) -> Option<String>) -> Arc<dyn Catalogue> {
        Arc::new(PluginKinds::new(Places::of(Some(graph), variable), Some(Lock::path(graph))))
    }
}

/// The kinds of one plugin, or why it cannot be used.
type Opened = Result<&'static [Kind], NoKind>;

/// Plugins that were made ready in this process, by digests of their manifests and components: loading a graph again costs no
/// more than reading the files. What is in it stays for as long as the program runs.
static READY: Mutex<BTreeMap<Digest, Opened>> = Mutex::new(BTreeMap::new());

/// The kinds of the plugins in some places.
#[derive(Debug)]
pub struct PluginKinds {
    places: Places,
    lock: Option<PathBuf>,
    seen: Mutex<Seen>,
}

#[derive(Debug, Default)]
struct Seen {
    found: Option<Vec<Found>>,
    opened: BTreeMap<String, Opened>,
    grounds: Grounds,
}

impl PluginKinds {
    /// The kinds of the plugins in `places`, held against the lock file `lock` where there is one.
    pub fn new(places: Places, lock: Option<PathBuf>) -> Self {
        Self { places, lock, seen: Mutex::default() }
    }

    fn plugins(&self, seen: &mut Seen) -> Vec<Found> {
        seen.found
            .get_or_insert_with(|| {
                let listed = self.places.0.iter().map(|(_, folder)| (folder.clone(), folders_in(folder)));
                seen.grounds.folders.extend(listed);
                self.places.find()
            })
            .clone()
    }

    /// The kinds of the plugin called `id`; `None` where there is none.
    fn open(&self, seen: &mut Seen, id: &str) -> Option<Opened> {
        if let Some(known) = seen.opened.get(id) {
            return Some(known.clone());
        }
        let found = self.plugins(seen).into_iter().find(|found| found.shadowed_by.is_none() && found.id() == id)?;
        let opened = self.ready(&mut seen.grounds, &found);
        seen.opened.insert(id.to_owned(), opened.clone());
        Some(opened)
    }

    fn ready(&self, grounds: &mut Grounds, found: &Found) -> Opened {
        let note = |grounds: &mut Grounds, path: &Path, bytes: &[u8]| {
            grounds.files.insert(path.to_owned(), Digest::of(bytes));
        };
        if let Ok(text) = std::fs::read(&found.file) {
            note(grounds, &found.file, &text);
        }
        let manifest = found.manifest.clone().map_err(|error| broken(found, &error.into()))?;
        let component = found.file.with_file_name(&manifest.file);
        let bytes = read(&component).map_err(|error| broken(found, &error))?;
        note(grounds, &component, &bytes);
        if let Some(file) = &self.lock {
            if let Ok(text) = std::fs::read(file) {
                note(grounds, file, &text);
            }
            held(file, &manifest, &bytes).map_err(|error| pinned(&error))?;
        }
        let mut hasher = Hasher::new("plugin");
        hasher.bytes(format!("{manifest:?}").as_bytes()).bytes(&bytes);
        let name = hasher.bytes(found.file.as_os_str().as_encoded_bytes()).finish();
        if let Some(known) = READY.lock().unwrap_or_else(PoisonError::into_inner).get(&name) {
            return known.clone();
        }
        let opened = Plugin::ready(&found.file, manifest, &bytes)
            .map(|plugin| &*kind::kinds(&Arc::new(plugin)).leak())
            .map_err(|error| broken(found, &error));
        READY.lock().unwrap_or_else(PoisonError::into_inner).entry(name).or_insert(opened).clone()
    }
}

fn held(file: &Path, manifest: &Manifest, bytes: &[u8]) -> Result<(), LockError> {
    match Lock::load(file)? {
        Some(lock) => lock.check(file, &manifest.id, &manifest.version, &crate::sha256(bytes)),
        None => Ok(()),
    }
}

fn broken(found: &Found, error: &LoadError) -> NoKind {
    let help =
        format!("`grimace plugin inspect {}` says more of it", found.file.parent().unwrap_or(Path::new(".")).display());
    NoKind { code: "broken-plugin", message: error.to_string(), help: Some(help) }
}

fn pinned(error: &LockError) -> NoKind {
    let help = "look at what changed, then `grimace plugin accept GRAPH` pins what is there now";
    NoKind { code: "changed-plugin", message: error.to_string(), help: Some(help.to_owned()) }
}

impl Catalogue for PluginKinds {
    fn kind(&self, name: &str) -> Option<Result<&'static Kind, NoKind>> {
        let (id, node) = name.split_once('/')?;
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let kinds = match self.open(&mut seen, id) {
            Some(Ok(kinds)) => kinds,
            Some(Err(problem)) => return Some(Err(problem)),
            None => {
                let places: Vec<String> =
                    self.places.0.iter().map(|(_, folder)| folder.display().to_string()).collect();
                let ids: Vec<String> = self.plugins(&mut seen).iter().map(Found::id).collect();
                let near = graph_core::document::did_you_mean(id, ids.iter().map(String::as_str));
                let near = near.map_or_else(String::new, |near| format!("did you mean `{near}/{node}`? "));
                let message = format!("there is no plugin `{id}`");
                let help = Some(format!("{near}plugins are looked for in {}", places.join(", ")));
                return Some(Err(NoKind { code: "unknown-plugin", message, help }));
            }
        };
        kinds.iter().find(|kind| kind.name() == name).map(Ok)
    }

    fn names(&self) -> Vec<&'static str> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let ids: Vec<String> = self.plugins(&mut seen).iter().map(Found::id).collect();
        let opened: Vec<Opened> = ids.iter().filter_map(|id| self.open(&mut seen, id)).collect();
        let mut names: Vec<&'static str> =
            opened.into_iter().flatten().flat_map(|kinds| kinds.iter().map(Kind::name)).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    fn grounds(&self) -> Grounds {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner).grounds.clone()
    }
}
