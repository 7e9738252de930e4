//! The registry of node kinds. `typetag` keeps no public list of its tags, so each node submits itself here too
//! (the macro [`register!`](crate::register) is one line). Kinds from elsewhere are made by a [`Maker`], and reach graphs
//! through a catalogue ([`super::Kinds`]).

use super::{Card, Node};
use schemars::JsonSchema;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// One kind of node: linked into this program, or brought by somebody else.
pub struct Kind(Origin);

enum Origin {
    Linked { make: fn() -> Box<dyn Node>, schema: fn() -> Value },
    Brought(Box<dyn Maker>),
}

/// Makes the nodes of a kind that is not linked into the program.
pub trait Maker: Send + Sync {
    /// The tag under which graphs name the kind.
    fn name(&self) -> &'static str;

    /// JSON schema of the parameters, as those of linked kinds: names, documentation, defaults, ranges.
    fn schema(&self) -> Value;

    /// A node with the parameters that are given; the others have their defaults.
    ///
    /// # Errors
    /// What is wrong with a parameter that the schema does not say.
    fn node(&self, parameters: &Map<String, Value>) -> Result<Box<dyn Node>, String>;

    /// A node with default parameters.
    fn default_node(&self) -> Box<dyn Node>;
}

impl std::fmt::Debug for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Kind {
    /// The kind whose parameters are `T`.
    pub const fn of<T: Node + Default + JsonSchema + 'static>() -> Self {
        Self(Origin::Linked { make: || Box::new(T::default()), schema: || schemars::schema_for!(T).to_value() })
    }

    /// A kind whose nodes `maker` makes.
    pub fn brought(maker: Box<dyn Maker>) -> Self {
        Self(Origin::Brought(maker))
    }

    /// The tag under which graphs name it.
    pub fn name(&self) -> &'static str {
        match &self.0 {
            Origin::Linked { make, .. } => make().typetag_name(),
            Origin::Brought(maker) => maker.name(),
        }
    }

    /// A node of this kind with its default parameters.
    pub fn default_node(&self) -> Box<dyn Node> {
        match &self.0 {
            Origin::Linked { make, .. } => make(),
            Origin::Brought(maker) => maker.default_node(),
        }
    }

    /// A node of this kind with the parameters that are given.
    ///
    /// # Errors
    /// What serde, or the maker, finds wrong with them.
    pub fn node(&self, parameters: &Map<String, Value>) -> Result<Box<dyn Node>, String> {
        match &self.0 {
            Origin::Linked { .. } => serde_json::from_value(serde_json::json!({ self.name(): parameters }))
                .map_err(|error: serde_json::Error| error.to_string()),
            Origin::Brought(maker) => maker.node(parameters),
        }
    }

    /// The card of a node with default parameters.
    pub fn card(&self) -> Card {
        self.default_node().card()
    }

    /// JSON schema of the parameters: names, documentation, defaults, ranges.
    pub fn schema(&self) -> Value {
        match &self.0 {
            Origin::Linked { schema, .. } => schema(),
            Origin::Brought(maker) => maker.schema(),
        }
    }
}

inventory::collect!(Kind);

/// Lists a node type in the registry: `register!(SmoothCurves);`.
#[macro_export]
macro_rules! register {
    ($node:ty) => {
        $crate::inventory::submit! { $crate::node::Kind::of::<$node>() }
    };
}

static KINDS: LazyLock<BTreeMap<&'static str, &'static Kind>> =
    LazyLock::new(|| inventory::iter::<Kind>.into_iter().map(|kind| (kind.name(), kind)).collect());

/// All linked kinds, in the order of their names.
pub fn kinds() -> impl Iterator<Item = (&'static str, &'static Kind)> {
    KINDS.iter().map(|(name, kind)| (*name, *kind))
}

/// The linked kind called `name`.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.get(name).copied()
}
