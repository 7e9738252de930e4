//! A look at the file system: which files that a graph depends on are there, how they look, and which folders hold them.

use crate::files::{Pattern, PatternError, Signature};
use crate::plan::Plan;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What a graph depends on: its files, and files or patterns of files that its nodes read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The graph and what is nested in it, and the files that its kinds came from: plugins.
    pub graphs: BTreeSet<PathBuf>,
    /// Patterns whose matches are items, and single files.
    pub sources: BTreeSet<PathBuf>,
}

impl Wanted {
    /// What `plan` says that it depends on. Files whose names depend on an item are known once the items are.
    pub fn of(plan: &Plan) -> Self {
        let read = plan.nodes.iter().filter(|node| !node.template.mentions_item).filter_map(|node| node.reads.as_ref());
        Self {
            graphs: plan
                .sources
                .iter()
                .map(|source| source.path.clone())
                .chain(plan.kinds().grounds().files.into_keys())
                .collect(),
            sources: read.map(|pattern| pattern.path().to_owned()).collect(),
        }
    }
}

/// What there is to see at one moment.
#[derive(Debug, Default)]
pub struct Look {
    /// Graph files that are there.
    pub graphs: BTreeMap<PathBuf, Signature>,
    /// Source files that are there.
    pub sources: BTreeMap<PathBuf, Signature>,
    /// Folders in which files may come and go, with whether those in folders of theirs matter too.
    pub folders: BTreeMap<PathBuf, bool>,
    /// Patterns that could not be followed.
    pub problems: Vec<PatternError>,
}

/// Looks at everything that `wanted` names.
pub fn look(wanted: &Wanted) -> Look {
    let mut look = Look::default();
    for path in &wanted.graphs {
        look.graphs.extend(Signature::of(path).ok().map(|signature| (path.clone(), signature)));
        folder_of(path, false, &mut look.folders);
    }
    for path in &wanted.sources {
        let pattern = Pattern::new(path);
        match pattern.files() {
            Ok(files) => {
                for file in files.into_values() {
                    let signature = Signature::of(&file).ok();
                    look.sources.extend(signature.map(|signature| (file, signature)));
                }
            }
            Err(problem) => look.problems.push(problem),
        }
        let fixed = if pattern.is_wild() { fixed_part(path) } else { path.clone() };
        // Folders below matter where the wild part goes on below the first folder.
        let deep = path.components().count() > fixed.components().count() + 1;
        let fixed = if pattern.is_wild() { fixed.join("_") } else { fixed };
        folder_of(&fixed, deep, &mut look.folders);
    }
    look
}

/// The folders before the first wild card.
fn fixed_part(path: &Path) -> PathBuf {
    let wild = |part: &std::path::Component<'_>| part.as_os_str().to_string_lossy().contains(['*', '?', '[', '{']);
    path.components().take_while(|part| !wild(part)).collect()
}

/// Notes the folder that `file` is in and the one around it, in which it may go and come again; for a folder that is not
/// there, the nearest around it that is.
fn folder_of(file: &Path, deep: bool, folders: &mut BTreeMap<PathBuf, bool>) {
    let named = |folder: &Path| if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_owned() };
    let mut above = file.ancestors().skip(1).map(named).filter(|folder| folder.is_dir());
    let Some(nearest) = above.next() else { return };
    let is_own = file.parent().is_some_and(|own| named(own) == nearest);
    *folders.entry(nearest).or_default() |= deep && is_own;
    if let (true, Some(around)) = (is_own, above.next()) {
        folders.entry(around).or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_finds_files_and_the_folders_to_follow() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("takes/day_1")).unwrap();
        for file in ["graph.ron", "takes/a.c3d", "takes/day_1/b.c3d"] {
            std::fs::write(at(file), "x").unwrap();
        }
        let wanted = Wanted {
            graphs: [at("graph.ron")].into(),
            sources: [at("takes/*.c3d"), at("takes/**/*.trc"), at("gone/deep/*.c3d"), at("rig.glb")].into(),
        };
        let look = look(&wanted);
        assert_eq!(look.graphs.keys().collect::<Vec<_>>(), [&at("graph.ron")]);
        assert_eq!(look.sources.keys().collect::<Vec<_>>(), [&at("takes/a.c3d")]);
        assert_eq!(look.folders.get(&at("takes")), Some(&true));
        // The folder that is not there is waited for in the one around it.
        assert_eq!(look.folders.get(folder.path()), Some(&false));
        assert!(look.problems.is_empty());
    }
}
