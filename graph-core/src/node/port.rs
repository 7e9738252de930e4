//! Ports: the named, typed ends of wires.

use std::marker::PhantomData;
use wire::{Data, ValueKind};

/// An input or output of a node: its name, its type, and what it means, said once.
pub struct Port<T> {
    name: &'static str,
    meaning: &'static str,
    carries: PhantomData<fn() -> T>,
}

impl<T: Data> Port<T> {
    /// A port called `name`; `meaning` is for the manual: what a value is, its shape and units.
    pub const fn new(name: &'static str, meaning: &'static str) -> Self {
        Self { name, meaning, carries: PhantomData }
    }

    /// The port's name.
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The facts of the port, without its Rust type.
    pub const fn facts(&self) -> PortFacts {
        PortFacts {
            name: self.name,
            meaning: self.meaning,
            kind: ValueKind::of::<T>(),
            list: false,
            optional: false,
            still: false,
        }
    }
}

/// What the engine knows of a port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PortFacts {
    /// The port's name.
    pub name: &'static str,
    /// What a value on it is.
    pub meaning: &'static str,
    /// The type of its values.
    pub kind: ValueKind,
    /// Whether it carries a list of named items.
    pub list: bool,
    /// Whether the node works without it.
    pub optional: bool,
    /// Whether a per-frame node gets it whole even though it varies over time.
    pub still: bool,
}

impl PortFacts {
    /// The type as messages print it: `Markers`, or `[Markers]` for a list.
    pub fn type_text(&self) -> String {
        type_text(self.kind.name, self.list)
    }
}

/// A type name as messages print it.
pub fn type_text(name: &str, list: bool) -> String {
    if list { format!("[{name}]") } else { name.to_owned() }
}
