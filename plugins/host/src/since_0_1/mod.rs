//! Interface 0.1, as `plugins/wit/since-0.1` writes it: how a component that speaks it is looked at, asked and understood.
//! When the interface grows, the next version gets a module of its own, and this one stays, so that what was built runs on.

mod describe;
mod lift;
mod lower;

pub use lift::{fault, outputs};
pub use lower::Given;

use crate::fault::LoadError;
use crate::manifest::Manifest;
use crate::run::{Level, State};
use crate::schema::NodeSchema;
use bindings::exports::grimace::node::nodes::{Fault, Standing};
use bindings::grimace::node::host;
use bindings::{Plugin, PluginPre};
use wasmtime::Store;
use wasmtime::component::{Component, HasSelf, Linker};

mod bindings {
    #![allow(missing_docs, clippy::all, clippy::pedantic, reason = "made by a macro from the interface")]
    wasmtime::component::bindgen!({
        path: "../wit/since-0.1",
        world: "plugin",
        ownership: Borrowing { duplicate_if_necessary: true },
        imports: { default: trappable },
    });
}

/// What this program calls the interface.
const NAME: &str = "0.1";

impl host::Host for State {
    fn log(&mut self, level: host::Level, message: String) -> wasmtime::Result<()> {
        let level = match level {
            host::Level::Debug => Level::Debug,
            host::Level::Info => Level::Info,
            host::Level::Warning => Level::Warning,
            host::Level::Panic => Level::Panic,
        };
        State::log(self, level, &message);
        Ok(())
    }

    fn progress(&mut self, fraction: f64, numbers: Vec<(String, f64)>) -> wasmtime::Result<bool> {
        Ok(State::progress(self, fraction, &numbers))
    }
}

impl bindings::grimace::node::types::Host for State {}

/// The version that follows `prefix@` in `name`.
fn version<'a>(name: &'a str, prefix: &str) -> Option<&'a str> {
    name.strip_prefix(prefix)?.strip_prefix('@')
}

/// Whether `version` is one of 0.1.
fn is_own(version: &str) -> bool {
    version.strip_prefix(NAME).is_some_and(|rest| rest.starts_with('.'))
}

/// What `component` imports, and the version of the interface that it speaks.
pub fn look(component: &Component, manifest: &Manifest) -> Result<(Vec<String>, String), LoadError> {
    let shape = component.component_type();
    let imports: Vec<String> = shape.imports(component.engine()).map(|(name, _)| name.to_owned()).collect();
    let plugin = || manifest.id.clone();
    let supported = || crate::INTERFACES.join(", ");
    let foreign: Vec<String> = imports.iter().filter(|name| !name.starts_with("grimace:node/")).cloned().collect();
    if !foreign.is_empty() {
        return Err(LoadError::Imports { plugin: plugin(), imports: foreign });
    }
    for name in &imports {
        let known = ["grimace:node/host", "grimace:node/types"].iter().find_map(|known| version(name, known));
        if !known.is_some_and(is_own) {
            return Err(LoadError::Interface { plugin: plugin(), found: name.clone(), supported: supported() });
        }
    }
    let mut exports = shape.exports(component.engine());
    let found = exports.find_map(|(name, _)| version(name, "grimace:node/nodes")).map(str::to_owned);
    match found {
        Some(found) if is_own(&found) && manifest.api == NAME => Ok((imports, found)),
        Some(found) if is_own(&found) => {
            let found = format!("{} as its plugin.ron says, and {found} as its component does", manifest.api);
            Err(LoadError::Interface { plugin: plugin(), found, supported: supported() })
        }
        found => {
            let found = found.unwrap_or_else(|| "no `grimace:node/nodes`".to_owned());
            Err(LoadError::Interface { plugin: plugin(), found, supported: supported() })
        }
    }
}

/// A component whose imports are found, ready to be instantiated.
pub struct Ready(PluginPre<State>);

impl Ready {
    /// Finds the imports.
    pub fn new(component: &Component) -> wasmtime::Result<Self> {
        let mut linker = Linker::new(component.engine());
        Plugin::add_to_linker::<State, HasSelf<State>>(&mut linker, |state| state)?;
        Ok(Self(PluginPre::new(linker.instantiate_pre(component)?)?))
    }

    /// Its nodes, as it describes them.
    pub fn describe(&self, store: &mut Store<State>) -> wasmtime::Result<Vec<NodeSchema>> {
        let plugin = self.0.instantiate(&mut *store)?;
        let nodes = plugin.grimace_node_nodes().call_describe(&mut *store)?;
        Ok(nodes.into_iter().map(describe::node).collect())
    }

    /// Seconds that one of `times` calls in the same instance takes, on average.
    pub fn crossing_s(&self, store: &mut Store<State>, given: &Given<'_>, times: u32) -> wasmtime::Result<f64> {
        let plugin = self.0.instantiate(&mut *store)?;
        let start = std::time::Instant::now();
        for _ in 0..times {
            drop(given.with(|call| plugin.grimace_node_nodes().call_evaluate(&mut *store, call))?);
        }
        Ok(start.elapsed().as_secs_f64() / f64::from(times))
    }

    /// Evaluates one of its nodes.
    pub fn evaluate(
        &self,
        store: &mut Store<State>,
        given: &Given<'_>,
    ) -> wasmtime::Result<Result<Vec<Standing>, Fault>> {
        let plugin = self.0.instantiate(&mut *store)?;
        given.with(|call| plugin.grimace_node_nodes().call_evaluate(&mut *store, call))
    }
}
