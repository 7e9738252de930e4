//! A graph file as data, every part with its place in the text.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A run of bytes in a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// The byte after the last.
    pub end: usize,
}

/// Something with its place in the text.
#[derive(Debug, Clone, PartialEq)]
pub struct Spanned<T> {
    /// The thing.
    pub value: T,
    /// Where it stands.
    pub span: Span,
}

/// A graph file's path and text.
#[derive(Debug, PartialEq, Eq)]
pub struct Source {
    /// Path, as it was reached (absolute or relative to where the program runs).
    pub path: PathBuf,
    /// The whole text.
    pub text: String,
    /// Where each line begins.
    lines: Vec<usize>,
}

impl Source {
    /// The text of a file.
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        let text = text.into();
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let lines = std::iter::once(0).chain(ends.map(|(end, _)| end + 1)).collect();
        Self { path: path.into(), text, lines }
    }

    /// Line and column, both from 1, of the byte at `offset`; columns count characters.
    pub fn line_column(&self, offset: usize) -> (usize, usize) {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let line = self.lines.partition_point(|start| *start <= offset);
        let column = self.text[self.lines[line - 1]..offset].chars().count() + 1;
        (line, column)
    }

    /// The folder that relative paths in the file start from.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }
}

/// A place in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The file.
    pub source: Arc<Source>,
    /// Where in it.
    pub span: Span,
}

impl Place {
    /// `file:line:col`.
    pub fn text(&self) -> String {
        let (line, column) = self.source.line_column(self.span.start);
        format!("{}:{line}:{column}", self.source.path.display())
    }
}

/// A value as written in a graph.
#[derive(Debug, Clone, PartialEq)]
pub enum Literal {
    /// `None` or `()`.
    Nothing,
    /// `true`, `false`.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// Any other number.
    Number(f64),
    /// A string, or a bare enum variant such as `constant`.
    Text(String),
    /// `[…]`, or a tuple.
    List(Vec<Spanned<Literal>>),
    /// `{…}` or `(name: …)`, in the order of the file.
    Map(Vec<(Spanned<String>, Spanned<Literal>)>),
    /// An enum variant with content: `one_cycle(…)`.
    Variant(String, Box<Spanned<Literal>>),
}

/// A graph file.
#[derive(Debug, Clone, PartialEq)]
pub struct Graph {
    /// Path and text.
    pub source: Arc<Source>,
    /// The `doc` line.
    pub doc: Option<String>,
    /// The graph's knobs with their defaults.
    pub params: BTreeMap<String, Spanned<Literal>>,
    /// What the graph takes when it is nested in another.
    pub inputs: BTreeMap<String, GraphInput>,
    /// What the graph gives when it is nested: `node.port` by name.
    pub outputs: BTreeMap<String, Spanned<String>>,
    /// The nodes, by name.
    pub nodes: BTreeMap<String, Entry>,
}

/// An input of a nested graph: `"markers": "Markers"`, `"rom": "[Curves]"`, `"anchors": "Anchors?"`.
#[derive(Debug, Clone, PartialEq)]
pub struct GraphInput {
    /// Where the input's type stands.
    pub span: Span,
    /// Name of the type.
    pub type_name: String,
    /// Whether it is a list (`[Type]`).
    pub list: bool,
    /// Whether it may be left open (`Type?`).
    pub optional: bool,
}

/// One node of a graph file.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Where the node's name stands.
    pub name_span: Span,
    /// What it is.
    pub body: Body,
    /// The list whose items it is cooked for (`node.port`).
    pub for_each: Option<Spanned<String>>,
    /// Where its inputs come from: one or several `node.port`, by input name.
    pub inputs: BTreeMap<String, EntryInput>,
    /// Its parameters as written.
    pub with: BTreeMap<String, EntryParam>,
}

/// What a node is.
#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    /// A node of a kind.
    Kind(Spanned<String>),
    /// A nested graph file.
    Graph(Spanned<String>),
}

/// Where an input comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct EntryInput {
    /// Where the input's name stands.
    pub name_span: Span,
    /// The sources: one, or several that are gathered.
    pub sources: Vec<Spanned<String>>,
}

/// A parameter as written.
#[derive(Debug, Clone, PartialEq)]
pub struct EntryParam {
    /// Where the parameter's name stands.
    pub name_span: Span,
    /// Its value.
    pub value: Spanned<Literal>,
}
