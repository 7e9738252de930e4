//! What a node gives.

use crate::bindings::grimace::node::types as wit;

/// The values on a node's outputs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outputs(pub(crate) Vec<wit::Standing>);

impl Outputs {
    /// A value on one output.
    pub fn of(output: &str, value: impl Into<wit::Value>) -> Self {
        Self::default().with(output, value)
    }

    /// The same outputs with a value on one more.
    #[must_use]
    pub fn with(mut self, output: &str, value: impl Into<wit::Value>) -> Self {
        let item = wit::Item { name: String::new(), value: value.into() };
        self.0.push(wit::Standing { port: output.to_owned(), items: vec![item] });
        self
    }

    /// The same outputs with named values on a list output.
    #[must_use]
    pub fn with_list<V: Into<wit::Value>>(
        mut self,
        output: &str,
        items: impl IntoIterator<Item = (String, V)>,
    ) -> Self {
        let items = items.into_iter().map(|(name, value)| wit::Item { name, value: value.into() });
        self.0.push(wit::Standing { port: output.to_owned(), items: items.collect() });
        self
    }

    /// The value on an output, for tests.
    #[must_use]
    pub fn get(&self, output: &str) -> Option<&wit::Value> {
        let standing = self.0.iter().find(|standing| standing.port == output)?;
        standing.items.first().map(|item| &item.value)
    }

    /// The curves on an output, for tests.
    #[must_use]
    pub fn curves(&self, output: &str) -> Option<&wit::Curves> {
        match self.get(output)? {
            wit::Value::Curves(curves) => Some(curves),
            _ => None,
        }
    }
}

macro_rules! into_value {
    ($($variant:ident: $type:ty),+ $(,)?) => {
        $(
            impl From<$type> for wit::Value {
                fn from(value: $type) -> Self {
                    Self::$variant(value)
                }
            }
        )+
    };
}

into_value!(
    Number: f64,
    Text: String,
    Tensor: wit::Tensor,
    Markers: wit::Markers,
    Curves: wit::Curves,
    Views: wit::Views,
    Features: wit::Features,
    Meshes: wit::Meshes,
    Image: wit::Image,
    Blob: wit::Blob,
);
