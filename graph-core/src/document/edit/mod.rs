//! Edits of a graph's text by span: what a tool changes is replaced, every other byte stays as it is.
//!
//! A [`Draft`] is a text whose parts are known. Its functions give [`Change`]s, which [`apply`] makes; none of them
//! writes a file; [`save()`] does. What the new text means is checked as that of any graph is.

mod entries;
mod save;
#[cfg(test)]
mod tests;
mod wires;

pub use save::save;

use super::ron::parse;
use super::{Literal, Span, Spanned};

/// A run of bytes and what is to stand in its place.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Change {
    /// The bytes that go.
    pub span: Span,
    /// What comes.
    pub text: String,
}

/// Why a text cannot be edited so.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EditFault {
    /// The text is no RON, so that its parts are not known.
    #[error("line {line}: {message}; mend the text first")]
    Broken {
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        message: String,
    },
    /// A node is not there.
    #[error("there is no node `{0}` in this file")]
    NoNode(String),
    /// A name is taken.
    #[error("there is already a node `{0}`; choose another name")]
    Taken(String),
    /// A name cannot be used.
    #[error("`{0}` cannot be a name here: use letters, digits, `_` and `-`")]
    BadName(String),
    /// A value is no single RON value.
    #[error("{0}")]
    BadValue(String),
    /// A part of the graph is not what it should be.
    #[error("`{0}` is not written as a graph has it; mend the text first")]
    Shape(String),
}

/// Makes all `changes`, which refer to `text` and do not overlap.
pub fn apply(text: &str, changes: &[Change]) -> String {
    let mut sorted: Vec<&Change> = changes.iter().collect();
    // What is put in at one place stays in the order in which it is given.
    sorted.sort_by_key(|change| change.span);
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for change in sorted {
        // Two deletions may share bytes.
        let start = change.span.start.max(at);
        out.push_str(&text[at..start]);
        out.push_str(&change.text);
        at = change.span.end.max(at);
    }
    out.push_str(&text[at..]);
    out
}

/// Checks that `text` is one RON value.
///
/// # Errors
/// What is wrong with it.
pub fn check_value(text: &str) -> Result<Literal, EditFault> {
    let parsed = parse(text);
    match (parsed.value, parsed.errors.first()) {
        (_, Some(error)) => Err(EditFault::BadValue(error.message.clone())),
        (None, None) => Err(EditFault::BadValue("a value is missing".to_owned())),
        (Some(value), None) => Ok(value.value),
    }
}

/// `text` as a RON string.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// One step into a text: a field of a structure, `(name: …)`, or an entry of a map, `{"name": …}`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step<'a> {
    /// A field.
    Field(&'a str),
    /// An entry.
    Entry(&'a str),
}

impl<'a> Step<'a> {
    fn name(self) -> &'a str {
        let (Self::Field(name) | Self::Entry(name)) = self;
        name
    }

    /// The structure or map that holds nothing but `value` under this name.
    fn around(self, value: &str) -> String {
        match self {
            Self::Field(name) => format!("({name}: {value})"),
            Self::Entry(name) => format!("{{{}: {value}}}", quoted(name)),
        }
    }
}

type Field = (Spanned<String>, Spanned<Literal>);

/// A text whose parts are known.
#[derive(Debug)]
pub struct Draft<'a> {
    text: &'a str,
    root: Spanned<Literal>,
}

impl<'a> Draft<'a> {
    /// Reads `text`.
    ///
    /// # Errors
    /// Where it is no RON.
    pub fn of(text: &'a str) -> Result<Self, EditFault> {
        let parsed = parse(text);
        if let Some(error) = parsed.errors.first() {
            let line = text[..error.span.start.min(text.len())].matches('\n').count() + 1;
            return Err(EditFault::Broken { line, message: error.message.clone() });
        }
        let root = parsed.value.ok_or_else(|| EditFault::Shape("the graph".to_owned()))?;
        Ok(Self { text, root })
    }

    fn fields<'s>(value: &'s Spanned<Literal>, what: &str) -> Result<&'s [Field], EditFault> {
        match &value.value {
            Literal::Map(fields) => Ok(fields),
            // `()` is an empty structure too.
            Literal::Nothing => Ok(&[]),
            _ => Err(EditFault::Shape(what.to_owned())),
        }
    }

    fn field<'s>(value: &'s Spanned<Literal>, name: &str) -> Result<Option<&'s Field>, EditFault> {
        Ok(Self::fields(value, name)?.iter().find(|(key, _)| key.value == name))
    }

    fn nodes(&self) -> Result<Option<&Spanned<Literal>>, EditFault> {
        Ok(Self::field(&self.root, "nodes")?.map(|(_, value)| value))
    }

    fn entry(&self, node: &str) -> Result<&Spanned<Literal>, EditFault> {
        let missing = || EditFault::NoNode(node.to_owned());
        let nodes = self.nodes()?.ok_or_else(missing)?;
        Self::field(nodes, node)?.map(|(_, value)| value).ok_or_else(missing)
    }

    /// Sets the parameter `name` of `node` to `value`, a RON text. Where it is written already, exactly that value is replaced.
    ///
    /// # Errors
    /// Where there is no such node, or `value` is no RON value.
    pub fn set_param(&self, node: &str, name: &str, value: &str) -> Result<Vec<Change>, EditFault> {
        check_value(value)?;
        let entry = self.entry(node)?;
        match Self::field(entry, "with")? {
            Some((_, with)) => self.set(with, name, value),
            None => self.insert(entry, None, "with", &format!("({}: {value})", plain(name)?)),
        }
    }

    /// Takes the parameter `name` of `node` out, so that its default holds.
    ///
    /// # Errors
    /// Where there is no such node.
    pub fn unset_param(&self, node: &str, name: &str) -> Result<Vec<Change>, EditFault> {
        let entry = self.entry(node)?;
        let Some((_, with)) = Self::field(entry, "with")? else { return Ok(Vec::new()) };
        if Self::fields(with, "with")?.iter().all(|(key, _)| key.value == name) {
            return self.remove(entry, "with");
        }
        self.remove(with, name)
    }

    /// Sets the graph's own parameter `name` to `value`.
    ///
    /// # Errors
    /// Where `value` is no RON value.
    pub fn set_graph_param(&self, name: &str, value: &str) -> Result<Vec<Change>, EditFault> {
        check_value(value)?;
        match Self::field(&self.root, "params")? {
            Some((_, params)) => self.set(params, name, value),
            None => self.insert(&self.root, Some(0), "params", &format!("{{ {}: {value} }}", quoted(name))),
        }
    }

    /// Adds a node called `name` whose entry is `entry`, such as `(kind: "skin_jaw")`.
    ///
    /// # Errors
    /// Where the name is taken or cannot be one, or `entry` is no RON value.
    pub fn add_node(&self, name: &str, entry: &str) -> Result<Vec<Change>, EditFault> {
        node_name(name)?;
        check_value(entry)?;
        match self.nodes()? {
            Some(nodes) if Self::field(nodes, name)?.is_some() => Err(EditFault::Taken(name.to_owned())),
            Some(nodes) => self.insert(nodes, None, name, entry),
            None => {
                let nodes = format!("{{\n        {}: {entry},\n    }}", quoted(name));
                self.insert(&self.root, None, "nodes", &nodes)
            }
        }
    }

    /// Sets what stands at the end of `path`, from the root down, to `value`. Maps on the way that are missing are made.
    ///
    /// # Errors
    /// Where `value` is no RON value, or something on the way is no map.
    pub fn set_at(&self, path: &[Step<'_>], value: &str) -> Result<Vec<Change>, EditFault> {
        check_value(value)?;
        let mut map = &self.root;
        for (depth, step) in path.iter().enumerate() {
            let below = path[depth + 1..].iter().rev().fold(value.to_owned(), |text, step| step.around(&text));
            match Self::field(map, step.name())? {
                Some((_, found)) if depth + 1 == path.len() => {
                    return Ok(vec![Change { span: found.span, text: value.to_owned() }]);
                }
                Some((_, found)) if matches!(found.value, Literal::Nothing) => {
                    return Ok(vec![Change { span: found.span, text: below }]);
                }
                Some((_, found)) => map = found,
                None => return self.insert(map, None, step.name(), &below),
            }
        }
        Ok(Vec::new())
    }

    /// Takes out what stands at the end of `path`, from the root down; nothing where it is not there.
    ///
    /// # Errors
    /// Where something on the way is no map.
    pub fn remove_at(&self, path: &[Step<'_>]) -> Result<Vec<Change>, EditFault> {
        let Some((last, way)) = path.split_last() else { return Ok(Vec::new()) };
        let mut map = &self.root;
        for step in way {
            match Self::field(map, step.name())? {
                Some((_, found)) => map = found,
                None => return Ok(Vec::new()),
            }
        }
        match Self::field(map, last.name())? {
            Some(_) => self.remove(map, last.name()),
            None => Ok(Vec::new()),
        }
    }

    fn set(&self, map: &Spanned<Literal>, name: &str, value: &str) -> Result<Vec<Change>, EditFault> {
        match Self::field(map, name)? {
            Some((_, old)) => Ok(vec![Change { span: old.span, text: value.to_owned() }]),
            None => self.insert(map, None, name, value),
        }
    }
}

/// A field's name as it stands within round brackets.
fn plain(name: &str) -> Result<&str, EditFault> {
    let mut letters = name.chars();
    let is_name = letters.next().is_some_and(|c| c.is_alphabetic() || c == '_')
        && letters.all(|c| c.is_alphanumeric() || c == '_');
    if is_name { Ok(name) } else { Err(EditFault::BadName(name.to_owned())) }
}

fn node_name(name: &str) -> Result<(), EditFault> {
    let reserved = |c: char| c.is_whitespace() || c.is_control() || "./@,:={}$\"'*?[]#\\".contains(c);
    if name.is_empty() || name.contains(reserved) { Err(EditFault::BadName(name.to_owned())) } else { Ok(()) }
}
