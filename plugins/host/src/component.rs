//! A plugin made ready: its manifest, its bytes, what it imports and speaks, its compiled code and its nodes.

use crate::compiled::Compiled;
use crate::digests::sha256;
use crate::engine::engine;
use crate::fault::{LoadError, RunError};
use crate::manifest::{Limits, Manifest};
use crate::run::{Notes, run};
use crate::schema::{self, NodeSchema, Setting};
use crate::since_0_1;
use graph_core::node::{Context, Inputs, Outputs};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use wire::Digest;

/// Bytes that a component may have.
const LARGEST: u64 = 100 << 20;
/// Seconds in which a plugin must have described its nodes.
const DESCRIBE_S: f64 = 5.0;

/// A plugin that can be run.
pub struct Plugin {
    /// What its `plugin.ron` says.
    pub manifest: Manifest,
    /// What is known of its component.
    pub facts: Facts,
    /// Its nodes.
    pub nodes: Vec<NodeSchema>,
    name: Arc<str>,
    ready: since_0_1::Ready,
}

/// What is known of a component without running it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Facts {
    /// Its size in bytes.
    pub bytes: usize,
    /// Its digest, as keys hold it.
    pub digest: Digest,
    /// Its SHA-256, as manifests and lock files hold it.
    pub sha256: String,
    /// What it imports.
    pub imports: Vec<String>,
    /// The version of the interface that it speaks.
    pub interface: String,
}

impl std::fmt::Debug for Plugin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "plugin {} {} ({})", self.manifest.id, self.manifest.version, self.facts.digest.short())
    }
}

impl Plugin {
    /// Reads the component beside the manifest at `file`, which says `manifest`, and makes the plugin ready.
    ///
    /// # Errors
    /// Whatever is wrong with it.
    pub fn load(file: &Path, manifest: Manifest) -> Result<Self, LoadError> {
        let bytes = read(&file.with_file_name(&manifest.file))?;
        Self::ready(file, manifest, &bytes)
    }

    /// Makes a plugin of the manifest at `file` and the bytes of its component.
    ///
    /// # Errors
    /// Whatever is wrong with it.
    pub fn ready(file: &Path, manifest: Manifest, bytes: &[u8]) -> Result<Self, LoadError> {
        Self::made(file, manifest, bytes, Compiled::of_user().as_ref())
    }

    /// The same without keeping compiled code, for tests and benchmarks.
    ///
    /// # Errors
    /// Whatever is wrong with it.
    pub fn unkept(file: &Path, manifest: Manifest, bytes: &[u8]) -> Result<Self, LoadError> {
        Self::made(file, manifest, bytes, None)
    }

    fn made(file: &Path, manifest: Manifest, bytes: &[u8], kept: Option<&Compiled>) -> Result<Self, LoadError> {
        let sha = sha256(bytes);
        if let Some(expected) = manifest.sha256.as_ref().filter(|expected| !expected.eq_ignore_ascii_case(&sha)) {
            let file = file.with_file_name(&manifest.file);
            return Err(LoadError::Digest { file, expected: expected.clone(), found: sha });
        }
        let plugin = || manifest.id.clone();
        let digest = Digest::of(bytes);
        let broken = |problem: String| LoadError::Component { plugin: plugin(), problem };
        let component =
            Compiled::component(kept, engine(), bytes, &digest).map_err(|problem| broken(format!("{problem:#}")))?;
        let (imports, interface) = since_0_1::look(&component, &manifest)?;
        let ready = since_0_1::Ready::new(&component).map_err(|problem| broken(format!("{problem:#}")))?;
        let name: Arc<str> = manifest.id.as_str().into();
        let limits = Limits { time_s: manifest.limits.time_s.min(DESCRIBE_S), ..manifest.limits };
        let nodes = run(&name, limits, None, |store| ready.describe(store)).0?;
        schema::check(&nodes).map_err(|problem| LoadError::Schema { plugin: plugin(), problem })?;
        let facts = Facts { bytes: bytes.len(), digest, sha256: sha, imports, interface };
        Ok(Self { manifest, facts, nodes, name, ready })
    }

    /// Computes the node called `node` with the defaults of its parameters, but for `settings`.
    ///
    /// # Errors
    /// Why it gave nothing.
    pub fn compute(
        &self,
        node: &str,
        settings: &[(&str, Setting)],
        context: Option<&Context<'_>>,
        inputs: &Inputs,
    ) -> Result<Outputs, RunError> {
        let schema = self.nodes.iter().find(|known| known.name == node).ok_or_else(|| RunError::Engine {
            plugin: self.manifest.id.clone(),
            problem: format!("it has no node `{node}`"),
        })?;
        let defaults = schema.parameters.iter().map(|parameter| (parameter.name.clone(), parameter.default.clone()));
        let mut all: BTreeMap<String, Setting> = defaults.collect();
        all.extend(settings.iter().map(|(name, setting)| ((*name).to_owned(), setting.clone())));
        self.evaluate(schema, &all, context, inputs).0
    }

    /// Seconds a call of `node` takes on average where it is called `times` times in one store: what crossing costs without
    /// the fresh store that each evaluation of a cook has. For benchmarks.
    ///
    /// # Errors
    /// Where a call fails.
    #[doc(hidden)]
    pub fn crossing_s(&self, node: &str, inputs: &Inputs, times: u32) -> Result<f64, RunError> {
        let wrong = |problem: String| RunError::Engine { plugin: self.manifest.id.clone(), problem };
        let schema = self.nodes.iter().find(|known| known.name == node);
        let schema = schema.ok_or_else(|| wrong(format!("it has no node `{node}`")))?;
        let defaults = schema.parameters.iter().map(|parameter| (parameter.name.clone(), parameter.default.clone()));
        let settings = defaults.collect();
        let given = since_0_1::Given::stage(schema, &settings, inputs).map_err(wrong)?;
        run(&self.name, self.manifest.limits, None, |store| self.ready.crossing_s(store, &given, times)).0
    }

    /// Computes the node `node` with every parameter of its schema.
    ///
    /// # Errors
    /// Why it gave nothing.
    pub(crate) fn evaluate(
        &self,
        node: &NodeSchema,
        settings: &BTreeMap<String, Setting>,
        context: Option<&Context<'_>>,
        inputs: &Inputs,
    ) -> (Result<Outputs, RunError>, Notes) {
        let plugin = || self.manifest.id.clone();
        let given = match since_0_1::Given::stage(node, settings, inputs) {
            Ok(given) => given,
            Err(problem) => return (Err(RunError::Engine { plugin: plugin(), problem }), Notes::default()),
        };
        let (told, notes) = run(&self.name, self.manifest.limits, context, |store| self.ready.evaluate(store, &given));
        let outputs = told.and_then(|told| match told {
            Ok(standing) => {
                since_0_1::outputs(node, standing).map_err(|problem| RunError::Gave { plugin: plugin(), problem })
            }
            Err(fault) => Err(since_0_1::fault(plugin(), node, fault)),
        });
        (outputs, notes)
    }
}

/// The bytes of the component at `file`.
pub(crate) fn read(file: &Path) -> Result<Vec<u8>, LoadError> {
    let failed = |problem: String| LoadError::File { file: file.to_owned(), problem };
    let size = std::fs::metadata(file).map_err(|problem| failed(problem.to_string()))?.len();
    if size > LARGEST {
        return Err(failed(format!("{size} bytes; a component has at most {LARGEST}")));
    }
    std::fs::read(file).map_err(|problem| failed(problem.to_string()))
}
