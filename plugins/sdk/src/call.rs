//! What a node computes from: its parameters and inputs, and its way to the engine.

use crate::Node;
use crate::bindings::grimace::node::types as wit;
use crate::runtime;

/// Why a node could not compute.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault(pub(crate) wit::Fault);

impl Fault {
    /// Something is wrong with the input `name`: say what, and what to do about it.
    pub fn input(name: &str, problem: impl ToString) -> Self {
        Self(wit::Fault::Input(wit::Complaint { name: name.to_owned(), problem: problem.to_string() }))
    }

    /// The value of the parameter `name` does not fit.
    pub fn parameter(name: &str, problem: impl ToString) -> Self {
        Self(wit::Fault::Parameter(wit::Complaint { name: name.to_owned(), problem: problem.to_string() }))
    }

    /// The computation found no answer.
    pub fn failed(problem: impl ToString) -> Self {
        Self(wit::Fault::Failed(problem.to_string()))
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.0 {
            wit::Fault::Input(wit::Complaint { name, problem }) => write!(f, "input `{name}`: {problem}"),
            wit::Fault::Parameter(wit::Complaint { name, problem }) => write!(f, "parameter `{name}`: {problem}"),
            wit::Fault::Failed(problem) => f.write_str(problem),
            wit::Fault::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl std::error::Error for Fault {}

/// One evaluation of a node.
#[derive(Debug)]
pub struct Call {
    node: String,
    settings: Vec<wit::Parameter>,
    inputs: Vec<wit::Standing>,
}

macro_rules! input {
    ($(#[$doc:meta])* $function:ident, $variant:ident, $type:ty) => {
        $(#[$doc])*
        ///
        /// # Errors
        /// Where nothing is connected to it.
        ///
        /// # Panics
        /// Where the schema gives the input another type.
        pub fn $function(&mut self, input: &str) -> Result<$type, Fault> {
            match self.take(input)? {
                wit::Value::$variant(value) => Ok(value),
                _ => panic!("the schema of `{}` does not say that `{input}` is {}", self.node, stringify!($variant)),
            }
        }
    };
}

macro_rules! setting {
    ($(#[$doc:meta])* $function:ident, $variant:ident, $type:ty) => {
        $(#[$doc])*
        ///
        /// # Panics
        /// Where the schema has no such parameter.
        #[must_use]
        pub fn $function(&self, parameter: &str) -> $type {
            match self.settings.iter().find(|known| known.name == parameter).map(|known| &known.value) {
                Some(wit::Setting::$variant(value)) => value.clone(),
                _ => panic!("the schema of `{}` has no parameter `{parameter}` of this type", self.node),
            }
        }
    };
}

impl Call {
    pub(crate) fn of_host(call: wit::Call) -> Self {
        Self { node: call.node, settings: call.parameters, inputs: call.inputs }
    }

    /// A call to the node `N` with the defaults of its parameters and nothing on its inputs, for tests.
    #[must_use]
    pub fn to<N: Node>() -> Self {
        let schema = N::schema().0;
        let given = |parameter: wit::ParameterSchema| wit::Parameter { name: parameter.name, value: parameter.default };
        let settings = schema.parameters.into_iter().map(given).collect();
        Self { node: schema.name, settings, inputs: Vec::new() }
    }

    /// The same call with a value on an input.
    #[must_use]
    pub fn with(mut self, input: &str, value: impl Into<wit::Value>) -> Self {
        let item = wit::Item { name: String::new(), value: value.into() };
        self.inputs.push(wit::Standing { port: input.to_owned(), items: vec![item] });
        self
    }

    /// The same call with another value of a parameter that is a number.
    #[must_use]
    pub fn number_set(self, parameter: &str, value: f64) -> Self {
        self.set(parameter, wit::Setting::Number(value))
    }

    /// The same call with another value of a parameter that is a whole number.
    #[must_use]
    pub fn integer_set(self, parameter: &str, value: i64) -> Self {
        self.set(parameter, wit::Setting::Integer(value))
    }

    /// The same call with another value of a parameter that is a text or a choice.
    #[must_use]
    pub fn text_set(self, parameter: &str, value: &str) -> Self {
        self.set(parameter, wit::Setting::Text(value.to_owned()))
    }

    fn set(mut self, parameter: &str, value: wit::Setting) -> Self {
        self.settings.retain(|known| known.name != parameter);
        self.settings.push(wit::Parameter { name: parameter.to_owned(), value });
        self
    }

    setting!(/** The value of a number. */ number, Number, f64);
    setting!(/** The value of a whole number. */ integer, Integer, i64);
    setting!(/** The value of a switch. */ flag, Flag, bool);
    setting!(/** The value of a text or a choice. */ text, Text, String);
    setting!(/** The value of a list of numbers. */ numbers, Numbers, Vec<f64>);

    /// Whether something is connected to an input that may be left open.
    #[must_use]
    pub fn has(&self, input: &str) -> bool {
        self.inputs.iter().any(|standing| standing.port == input)
    }

    /// Takes the value on an input.
    ///
    /// # Errors
    /// Where nothing is connected to it.
    pub fn take(&mut self, input: &str) -> Result<wit::Value, Fault> {
        let standing = self.inputs.iter_mut().find(|standing| standing.port == input);
        let item = standing.and_then(|standing| standing.items.pop());
        item.map(|item| item.value).ok_or_else(|| Fault::input(input, "nothing is connected"))
    }

    /// Takes the named values on an input that gathers a list.
    pub fn items(&mut self, input: &str) -> Vec<(String, wit::Value)> {
        let at = self.inputs.iter().position(|standing| standing.port == input);
        let items = at.map(|at| self.inputs.swap_remove(at).items).unwrap_or_default();
        items.into_iter().map(|item| (item.name, item.value)).collect()
    }

    input!(/** Takes the curves on an input. */ curves, Curves, wit::Curves);
    input!(/** Takes the markers on an input. */ markers, Markers, wit::Markers);
    input!(/** Takes the meshes on an input. */ meshes, Meshes, wit::Meshes);
    input!(/** Takes the image on an input. */ image, Image, wit::Image);
    input!(/** Takes the views on an input. */ views, Views, wit::Views);
    input!(/** Takes the features on an input. */ features, Features, wit::Features);
    input!(/** Takes the tensor on an input. */ tensor, Tensor, wit::Tensor);
    input!(/** Takes the number on an input. */ value, Number, f64);
    input!(/** Takes the text on an input. */ words, Text, String);
    input!(/** Takes the bytes on an input. */ blob, Blob, wit::Blob);

    /// Says how far the node is, 0 to 1. Long loops do so at least every 100 ms.
    ///
    /// # Errors
    /// Where the user no longer wants the result: hand it on with `?`.
    pub fn progress(&self, fraction: f64) -> Result<(), Fault> {
        self.progress_with(fraction, &[])
    }

    /// The same with named numbers, such as a loss.
    ///
    /// # Errors
    /// Where the user no longer wants the result: hand it on with `?`.
    pub fn progress_with(&self, fraction: f64, numbers: &[(&str, f64)]) -> Result<(), Fault> {
        if runtime::progress(fraction, numbers) { Err(Fault(wit::Fault::Cancelled)) } else { Ok(()) }
    }
}
