//! Graph files: from RON text to [`Graph`], with every part's place kept, and every mistake reported.

mod diagnostic;
mod model;

pub use diagnostic::{Diagnostic, Diagnostics};
pub use model::{Body, Entry, EntryInput, EntryParam, Graph, GraphInput, Literal, Place, Source, Span, Spanned};
