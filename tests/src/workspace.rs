//! The workspace as cargo knows it: its packages, and who depends on whom.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The root of the checkout.
pub fn root() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own).to_owned()
}

/// The packages of the workspace and everything that they build on.
#[derive(Debug)]
pub struct Workspace {
    /// The workspace's own packages, with their folders.
    pub members: BTreeMap<String, PathBuf>,
    /// What each package names in its manifest as needed to run (tests and build scripts left out).
    direct: BTreeMap<String, BTreeSet<String>>,
}

impl Workspace {
    /// Asks cargo what is built on this machine. Crates of other systems are left out, since they may not be here.
    ///
    /// # Panics
    /// Where cargo cannot be asked.
    pub fn load() -> Self {
        let said = output_of("RUSTC", "rustc", &["-vV"]);
        let host = said.lines().find_map(|line| line.strip_prefix("host: ")).unwrap_or_default();
        let metadata = ["metadata", "--format-version", "1", "--locked", "--filter-platform", host];
        let metadata = serde_json::from_str(&output_of("CARGO", "cargo", &metadata));
        Self::of(&metadata.unwrap_or_else(|problem| panic!("cargo metadata: {problem}")))
    }

    fn of(metadata: &Value) -> Self {
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let own: BTreeSet<String> = list(&metadata["workspace_members"]).iter().map(text).collect();
        let (mut names, mut members) = (BTreeMap::new(), BTreeMap::new());
        for package in list(&metadata["packages"]) {
            let (id, name) = (text(&package["id"]), text(&package["name"]));
            if own.contains(&id) {
                let manifest = PathBuf::from(text(&package["manifest_path"]));
                members.insert(name.clone(), manifest.parent().unwrap_or(&manifest).to_owned());
            }
            names.insert(id, name);
        }
        // Of a crate that is there in several versions, all dependencies count.
        let mut direct: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for node in list(&metadata["resolve"]["nodes"]) {
            let needs = direct.entry(names[&text(&node["id"])].clone()).or_default();
            for dependency in list(&node["deps"]) {
                if list(&dependency["dep_kinds"]).iter().any(|kind| kind["kind"].is_null()) {
                    needs.insert(names[&text(&dependency["pkg"])].clone());
                }
            }
        }
        Self { members, direct }
    }

    /// What the manifest of `package` names.
    pub fn direct(&self, package: &str) -> BTreeSet<&str> {
        self.direct.get(package).into_iter().flatten().map(String::as_str).collect()
    }

    /// Everything that `package` builds on, and how: each with the package that names it.
    pub fn all(&self, package: &str) -> BTreeMap<&str, &str> {
        let mut found = BTreeMap::new();
        let mut open: Vec<&str> = self.direct.keys().map(String::as_str).filter(|name| *name == package).collect();
        while let Some(user) = open.pop() {
            for needed in self.direct(user) {
                if !found.contains_key(needed) {
                    found.insert(needed, user);
                    open.push(needed);
                }
            }
        }
        found
    }

    /// The path from `package` down to `needed`, for messages: `nodes → learn → dfdx`.
    pub fn chain(&self, package: &str, needed: &str) -> String {
        let all = self.all(package);
        let mut chain = vec![needed];
        while let Some(user) = all.get(chain[chain.len() - 1]).copied() {
            chain.push(user);
            if user == package {
                break;
            }
        }
        chain.reverse();
        chain.join(" → ")
    }
}

/// What the program says that the variable `variable` names, or else the one called `name`.
fn output_of(variable: &str, name: &str, arguments: &[&str]) -> String {
    let program = std::env::var_os(variable).unwrap_or_else(|| name.into());
    let output = Command::new(program).args(arguments).current_dir(root()).output();
    let output = output.unwrap_or_else(|problem| panic!("{name} cannot be started: {problem}"));
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}
