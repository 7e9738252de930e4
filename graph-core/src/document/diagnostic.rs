//! Diagnostics: what is wrong with a graph, where, and the cure.

use super::model::{Place, Source, Span};
use std::sync::Arc;

/// One mistake in a graph, or one file that could not be read.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnostic {
    /// A stable name of the kind of mistake, for example `unknown-port`.
    pub code: &'static str,
    /// What is wrong: what was expected and what was found.
    pub message: String,
    /// Where, with a short label.
    pub place: Option<(Place, String)>,
    /// What to do about it.
    pub help: Option<String>,
    /// For a mistake in a nested graph: the places that nest it, outermost first.
    pub through: Vec<Place>,
}

impl Diagnostic {
    /// A mistake without a place in a graph file.
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), place: None, help: None, through: Vec::new() }
    }

    /// A mistake at `span` of `source`.
    pub fn at(code: &'static str, source: &Arc<Source>, span: Span, message: impl Into<String>) -> Self {
        let place = Place { source: Arc::clone(source), span };
        Self { place: Some((place, String::new())), ..Self::new(code, message) }
    }

    /// The same with a label at its place.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        if let Some((_, text)) = &mut self.place {
            *text = label.into();
        }
        self
    }

    /// The same with a cure.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The same with a cure, where there is one.
    #[must_use]
    pub fn may_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }
}

/// All mistakes found in one pass; never empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnostics(pub Vec<Diagnostic>);
