//! Nodes: the trait, and what a node is given to compute with.

mod card;
mod context;
mod describe;
mod error;
mod inputs;
mod kinds;
mod port;
mod registry;

pub use card::{Card, Code, Time};
pub use context::{Context, Host, SourceFile};
pub use describe::{
    ChoiceDescription, KindDescription, ParameterDescription, PortDescription, describe, first_sentence,
};
pub use error::NodeError;
pub use inputs::{Inputs, Outputs, PortValue};
pub use kinds::{Bringer, Catalogue, Grounds, Kinds, Linked, NoKind, folders_in};
pub use port::{Port, PortFacts, type_text};
pub use registry::{Kind, Maker, kind, kinds};

/// A node: parameters as its fields, typed ports on its card, and a computation.
///
/// A node is a pure function of its inputs, its parameters and the files it declares. It reports progress and
/// checks for cancellation through its [`Context`], and never prints.
#[typetag::serde]
pub trait Node: std::fmt::Debug + Send + Sync {
    /// What the node says of itself. Ports and halo may depend on the parameters.
    fn card(&self) -> Card;

    /// Computes the outputs.
    ///
    /// # Errors
    /// A [`NodeError`] that tells the user what was wrong with which input, parameter or file.
    fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError>;
}
