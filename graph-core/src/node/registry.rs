//! The registry of node kinds. `typetag` keeps no public list of its tags, so each node submits itself here too
//! (the macro [`register!`](crate::register) is one line).

use super::{Card, Node};
use schemars::JsonSchema;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// One kind of node, as linked into this program.
pub struct Kind {
    make: fn() -> Box<dyn Node>,
    schema: fn() -> serde_json::Value,
}

impl Kind {
    /// The kind whose parameters are `T`.
    pub const fn of<T: Node + Default + JsonSchema + 'static>() -> Self {
        Self { make: || Box::new(T::default()), schema: || schemars::schema_for!(T).to_value() }
    }

    /// The tag under which graphs name it.
    pub fn name(&self) -> &'static str {
        (self.make)().typetag_name()
    }

    /// A node of this kind with its default parameters.
    pub fn default_node(&self) -> Box<dyn Node> {
        (self.make)()
    }

    /// The card of a node with default parameters.
    pub fn card(&self) -> Card {
        (self.make)().card()
    }

    /// JSON schema of the parameters: names, documentation, defaults, ranges.
    pub fn schema(&self) -> serde_json::Value {
        (self.schema)()
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

/// All kinds, in the order of their names.
pub fn kinds() -> impl Iterator<Item = (&'static str, &'static Kind)> {
    KINDS.iter().map(|(name, kind)| (*name, *kind))
}

/// The kind called `name`.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.get(name).copied()
}
