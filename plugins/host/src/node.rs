//! A node whose computation is in a plugin, as the engine sees it.

use crate::component::Plugin;
use crate::engine::identity;
use crate::schema::{NodeSchema, PortSchema, Setting, TimeUse, kind_of};
use graph_core::node::{Card, Code, Context, Inputs, Node, NodeError, Outputs, PortFacts};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use wire::Digest;

/// Texts that live as long as the program, each once: what the engine calls ports and kinds.
static TEXTS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// `text`, kept for as long as the program runs.
pub(crate) fn kept(text: &str) -> &'static str {
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = texts.get(text) {
        return known;
    }
    let new: &'static str = Box::leak(text.to_owned().into_boxed_str());
    texts.insert(new);
    new
}

/// What all nodes of one kind share.
pub(crate) struct Shared {
    pub plugin: Arc<Plugin>,
    /// Position among the plugin's nodes.
    pub node: usize,
    /// `plugin-id/node`.
    pub tag: &'static str,
    card: Card,
}

impl Shared {
    pub fn of(plugin: &Arc<Plugin>, node: usize) -> Self {
        let (schema, manifest, facts) = (&plugin.nodes[node], &plugin.manifest, &plugin.facts);
        let mut card = Card::new(kept(&format!("plugins/{}", manifest.id))).version(schema.version);
        let engine = format!("{}, interface {}", identity(), facts.interface);
        card.code = vec![
            Code {
                label: "plugin code",
                text: format!("{} {} ({})", manifest.id, manifest.version, facts.digest.short()),
                digest: facts.digest,
            },
            Code { label: "plugin engine", digest: Digest::of(engine.as_bytes()), text: engine },
        ];
        card.inputs = schema.inputs.iter().filter_map(port).collect();
        card.outputs = schema.outputs.iter().filter_map(port).collect();
        let tag = kept(&format!("{}/{}", manifest.id, schema.name));
        Self { plugin: Arc::clone(plugin), node, tag, card }
    }

    pub fn schema(&self) -> &NodeSchema {
        &self.plugin.nodes[self.node]
    }
}

fn port(port: &PortSchema) -> Option<PortFacts> {
    Some(PortFacts {
        name: kept(&port.name),
        meaning: kept(&port.doc),
        kind: kind_of(&port.type_name)?,
        list: port.many,
        optional: port.optional,
        still: port.still,
    })
}

/// A node of a plugin with its parameters.
pub(crate) struct PluginNode {
    pub shared: Arc<Shared>,
    /// Every parameter of the schema.
    pub settings: BTreeMap<String, Setting>,
}

impl std::fmt::Debug for PluginNode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {:?}", self.shared.tag, self.settings)
    }
}

/// Parameters in the order of the schema, as nodes written in Rust have them in that of their fields.
impl Serialize for PluginNode {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.settings.len()))?;
        for parameter in &self.shared.schema().parameters {
            map.serialize_entry(&parameter.name, self.settings.get(&parameter.name).unwrap_or(&parameter.default))?;
        }
        map.end()
    }
}

impl Node for PluginNode {
    fn typetag_name(&self) -> &'static str {
        self.shared.tag
    }

    fn typetag_deserialize(&self) {}

    fn card(&self) -> Card {
        let card = self.shared.card.clone();
        match &self.shared.schema().time {
            TimeUse::Whole => card,
            TimeUse::PerFrame(halo) => card.per_frame(*halo as usize),
            TimeUse::PerFrameBy(name) => match self.settings.get(name) {
                Some(Setting::Integer(halo)) => card.per_frame(usize::try_from(*halo).unwrap_or_default()),
                _ => card,
            },
        }
    }

    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let plugin = &self.shared.plugin;
        let (outputs, _) = plugin.evaluate(self.shared.schema(), &self.settings, Some(context), inputs);
        Ok(outputs?)
    }
}
