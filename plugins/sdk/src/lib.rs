//! Write nodes for grimace in Rust: a schema, a function, and `export!`.
//!
//! ```
//! use grimace_plugin::{Call, Fault, Node, Outputs, Schema};
//!
//! struct Gain;
//!
//! impl Node for Gain {
//!     fn schema() -> Schema {
//!         Schema::new("gain", "Multiplies every value of the curves.")
//!             .takes("curves", "Curves", "what to multiply")
//!             .gives("curves", "Curves", "the products")
//!             .number("factor", 1.0, -10.0..=10.0, "What to multiply by.")
//!             .per_frame(0)
//!     }
//!
//!     fn evaluate(call: &mut Call) -> Result<Outputs, Fault> {
//!         let factor = call.number("factor") as f32;
//!         let mut curves = call.curves("curves")?;
//!         curves.values.iter_mut().for_each(|value| *value *= factor);
//!         Ok(Outputs::of("curves", curves))
//!     }
//! }
//!
//! grimace_plugin::export!(Gain);
//! ```
//!
//! The same node runs natively in unit tests: [`Call::to`] makes a call, and [`Outputs`] says what came of it. A panic reaches
//! the user with its message and the functions it went through; a wrong input is better told as [`Fault::input`].

#[doc(hidden)]
#[allow(clippy::all, clippy::pedantic, missing_docs)]
pub mod bindings;
mod call;
mod outputs;
mod runtime;
mod schema;

pub use bindings::grimace::node::types::{
    Blob, Curves, FeatureSet, Features, Frames, Image, Markers, Meshes, Numbers, Part, RegionFeatures, Tensor, Value,
    Views,
};
pub use call::{Call, Fault};
pub use outputs::Outputs;
pub use runtime::log;
pub use schema::Schema;

/// A node: what it says of itself, and what it computes.
pub trait Node {
    /// Name, ports, parameters, and how it uses time.
    fn schema() -> Schema;

    /// Computes the outputs.
    ///
    /// # Errors
    /// A [`Fault`] that tells the user what was wrong with which input or parameter.
    fn evaluate(call: &mut Call) -> Result<Outputs, Fault>;
}

/// Makes the nodes of this crate the nodes of the plugin: `export!(Smooth, Sharpen);`.
#[macro_export]
macro_rules! export {
    ($($node:ty),+ $(,)?) => {
        #[cfg(target_arch = "wasm32")]
        const _: () = {
            struct Plugin;

            impl $crate::bindings::exports::grimace::node::nodes::Guest for Plugin {
                fn describe() -> Vec<$crate::bindings::grimace::node::types::NodeSchema> {
                    $crate::__private::listen();
                    vec![$($crate::__private::schema::<$node>()),+]
                }

                fn evaluate(
                    call: $crate::bindings::grimace::node::types::Call,
                ) -> Result<
                    Vec<$crate::bindings::grimace::node::types::Standing>,
                    $crate::bindings::grimace::node::types::Fault,
                > {
                    $crate::__private::listen();
                    $(
                        if $crate::__private::is::<$node>(&call) {
                            return $crate::__private::evaluate::<$node>(call);
                        }
                    )+
                    $crate::__private::unknown(call)
                }
            }

            $crate::__export_plugin_impl!(Plugin with_types_in $crate::bindings);
        };
    };
}

/// What [`export!`] needs of this crate.
#[doc(hidden)]
pub mod __private {
    use super::{Call, Node};
    use crate::bindings::grimace::node::types as wit;

    pub use crate::runtime::listen;

    pub fn schema<N: Node>() -> wit::NodeSchema {
        N::schema().0
    }

    pub fn is<N: Node>(call: &wit::Call) -> bool {
        N::schema().0.name == call.node
    }

    pub fn evaluate<N: Node>(call: wit::Call) -> Result<Vec<wit::Standing>, wit::Fault> {
        let outputs = N::evaluate(&mut Call::of_host(call)).map_err(|fault| fault.0)?;
        Ok(outputs.0)
    }

    pub fn unknown(call: wit::Call) -> Result<Vec<wit::Standing>, wit::Fault> {
        Err(wit::Fault::Failed(format!("this plugin has no node `{}`", call.node)))
    }
}
