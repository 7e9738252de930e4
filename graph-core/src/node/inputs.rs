//! The values a node computes from, and those it gives back.

use super::{NodeError, Port};
use smallvec::SmallVec;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::{Data, Value};

/// What stands on a port: one value, or a list of named items.
#[derive(Debug, Clone)]
pub enum PortValue {
    /// One value.
    One(Arc<dyn Value>),
    /// Items in the order of their names.
    List(BTreeMap<String, Arc<dyn Value>>),
}

/// The values on a node's inputs.
#[derive(Debug, Clone, Default)]
pub struct Inputs {
    ports: Ports<2>,
}

/// Ports by their names; as many as most nodes have are held in place.
type Ports<const N: usize> = SmallVec<[(Cow<'static, str>, PortValue); N]>;

/// What stands on the port `name`.
fn on<'a>(ports: &'a [(Cow<'static, str>, PortValue)], name: &str) -> Option<&'a PortValue> {
    let called = |port: &str| std::ptr::eq(port, name) || port == name;
    ports.iter().find(|(port, _)| called(port)).map(|(_, value)| value)
}

/// Puts a value on a port, in place of what stood there.
fn put<const N: usize>(ports: &mut Ports<N>, name: Cow<'static, str>, value: PortValue) {
    match ports.iter_mut().find(|(port, _)| *port == name) {
        Some((_, place)) => *place = value,
        None => ports.push((name, value)),
    }
}

impl Inputs {
    /// Puts a value on the port `name`, on which nothing stands so far.
    pub(crate) fn add(&mut self, name: &'static str, value: PortValue) {
        self.ports.push((name.into(), value));
    }

    /// Puts a value on the port `name` (the engine and tests do).
    pub fn set(&mut self, name: impl Into<Cow<'static, str>>, value: PortValue) {
        put(&mut self.ports, name.into(), value);
    }

    /// The same inputs with `value` on `port`, for tests.
    #[must_use]
    pub fn with<T: Data>(mut self, port: &Port<T>, value: T) -> Self {
        self.set(port.name(), PortValue::One(Arc::new(value)));
        self
    }

    /// The same inputs with the items `values` on `port`, for tests.
    #[must_use]
    pub fn with_list<T: Data>(mut self, port: &Port<T>, values: impl IntoIterator<Item = (String, T)>) -> Self {
        let items = values.into_iter().map(|(name, value)| (name, Arc::new(value) as Arc<dyn Value>)).collect();
        self.set(port.name(), PortValue::List(items));
        self
    }

    /// The value on `port`.
    ///
    /// # Errors
    /// Where nothing is connected, or something of another type (the checker finds both before a cook).
    pub fn get<T: Data>(&self, port: &Port<T>) -> Result<&T, NodeError> {
        self.may_get(port)?.ok_or_else(|| NodeError::input(port.name(), "nothing is connected"))
    }

    /// The value on an optional `port`, where something is connected.
    ///
    /// # Errors
    /// Where what is connected is of another type.
    pub fn may_get<T: Data>(&self, port: &Port<T>) -> Result<Option<&T>, NodeError> {
        match on(&self.ports, port.name()) {
            None => Ok(None),
            Some(PortValue::One(value)) => typed(port, value).map(Some),
            Some(PortValue::List(_)) => Err(NodeError::input(port.name(), "a list stands where one value belongs")),
        }
    }

    /// The items on a gathering `port`, in the order of their names; empty where nothing is connected.
    ///
    /// # Errors
    /// Where an item is of another type.
    pub fn items<T: Data>(&self, port: &Port<T>) -> Result<Vec<(&str, &T)>, NodeError> {
        match on(&self.ports, port.name()) {
            None => Ok(Vec::new()),
            Some(PortValue::One(value)) => Ok(vec![("", typed(port, value)?)]),
            Some(PortValue::List(items)) => {
                items.iter().map(|(name, value)| Ok((name.as_str(), typed(port, value)?))).collect()
            }
        }
    }

    /// All ports that something stands on.
    pub fn ports(&self) -> impl Iterator<Item = (&str, &PortValue)> {
        self.ports.iter().map(|(name, value)| (name.as_ref(), value))
    }
}

fn typed<'a, T: Data>(port: &Port<T>, value: &'a Arc<dyn Value>) -> Result<&'a T, NodeError> {
    value
        .downcast_ref::<T>()
        .ok_or_else(|| NodeError::input(port.name(), format!("{} stands where {} belongs", value.kind().name, T::NAME)))
}

/// The values on a node's outputs.
#[derive(Debug, Clone, Default)]
pub struct Outputs {
    ports: Ports<1>,
}

impl Outputs {
    /// The same outputs with `value` on `port`.
    #[must_use]
    pub fn with<T: Data>(mut self, port: &Port<T>, value: T) -> Self {
        put(&mut self.ports, port.name().into(), PortValue::One(Arc::new(value)));
        self
    }

    /// The same outputs with the items `values` on the list `port`.
    #[must_use]
    pub fn with_list<T: Data>(mut self, port: &Port<T>, values: impl IntoIterator<Item = (String, T)>) -> Self {
        let items = values.into_iter().map(|(name, value)| (name, Arc::new(value) as Arc<dyn Value>)).collect();
        put(&mut self.ports, port.name().into(), PortValue::List(items));
        self
    }

    /// The same outputs with an untyped `value` on the port `name` (plugins give these).
    #[must_use]
    pub fn with_any(mut self, name: impl Into<Cow<'static, str>>, value: PortValue) -> Self {
        put(&mut self.ports, name.into(), value);
        self
    }

    /// The value on `port`, for tests.
    pub fn get<T: Data>(&self, port: &Port<T>) -> Option<&T> {
        match on(&self.ports, port.name())? {
            PortValue::One(value) => value.downcast_ref(),
            PortValue::List(_) => None,
        }
    }

    /// The items on the list `port`, for tests.
    pub fn items<T: Data>(&self, port: &Port<T>) -> Vec<(&str, &T)> {
        match on(&self.ports, port.name()) {
            Some(PortValue::List(items)) => {
                items.iter().filter_map(|(name, value)| Some((name.as_str(), value.downcast_ref()?))).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Takes what stands on the port `name`.
    pub fn take(&mut self, name: &str) -> Option<PortValue> {
        let at = self.ports.iter().position(|(port, _)| port == name)?;
        Some(self.ports.swap_remove(at).1)
    }
}
