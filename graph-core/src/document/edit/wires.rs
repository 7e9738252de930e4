//! Connections in a text: made, undone, and kept when nodes leave or change their names.

use super::{Change, Draft, EditFault, node_name, quoted};
use crate::document::{Literal, Span, Spanned};

impl Draft<'_> {
    /// Connects the input `input` of `node` to `source` (`node.port`). Where `gather`, what it is connected to already stays.
    ///
    /// # Errors
    /// Where there is no such node.
    pub fn connect(&self, node: &str, input: &str, source: &str, gather: bool) -> Result<Vec<Change>, EditFault> {
        let entry = self.entry(node)?;
        let source = quoted(source);
        let Some((_, inputs)) = Self::field(entry, "in")? else {
            let fields = Self::fields(entry, "in")?;
            let head = |key: &str| ["kind", "graph", "for_each"].contains(&key);
            let after = fields.iter().rposition(|(key, _)| head(&key.value));
            return self.insert(entry, after, "in", &format!("{{{}: {source}}}", quoted(input)));
        };
        let Some((_, old)) = Self::field(inputs, input)? else { return self.insert(inputs, None, input, &source) };
        let change = |span: Span, text: String| Ok(vec![Change { span, text }]);
        match &old.value {
            Literal::Text(_) if gather => {
                let before = &self.text[old.span.start..old.span.end];
                change(old.span, format!("[{before}, {source}]"))
            }
            Literal::List(items) if gather => match items.last() {
                Some(last) => change(Span { start: last.span.end, end: last.span.end }, format!(", {source}")),
                None => change(old.span, format!("[{source}]")),
            },
            _ => change(old.span, source),
        }
    }

    /// Undoes the connection of `input` of `node` to `source`, or all connections of that input.
    ///
    /// # Errors
    /// Where there is no such node.
    pub fn disconnect(&self, node: &str, input: &str, source: Option<&str>) -> Result<Vec<Change>, EditFault> {
        let entry = self.entry(node)?;
        let Some((_, inputs)) = Self::field(entry, "in")? else { return Ok(Vec::new()) };
        let Some((_, value)) = Self::field(inputs, input)? else { return Ok(Vec::new()) };
        self.cut(entry, inputs, input, value, |text| source.is_none_or(|source| text == source))
    }

    /// Takes from the input's `value` the sources that `goes` names.
    fn cut(
        &self,
        entry: &Spanned<Literal>,
        inputs: &Spanned<Literal>,
        input: &str,
        value: &Spanned<Literal>,
        goes: impl Fn(&str) -> bool,
    ) -> Result<Vec<Change>, EditFault> {
        let gone = |value: &Spanned<Literal>| matches!(&value.value, Literal::Text(text) if goes(text));
        match &value.value {
            Literal::List(items) if !items.iter().all(gone) => Ok(items
                .iter()
                .enumerate()
                .filter(|(_, item)| gone(item))
                .map(|(at, item)| self.removal(item.span, at.checked_sub(1).map(|at| items[at].span.end)))
                .collect()),
            Literal::List(items) if items.is_empty() => Ok(Vec::new()),
            Literal::List(_) => self.remove_input(entry, inputs, input),
            _ if gone(value) => self.remove_input(entry, inputs, input),
            _ => Ok(Vec::new()),
        }
    }

    fn remove_input(
        &self,
        entry: &Spanned<Literal>,
        inputs: &Spanned<Literal>,
        input: &str,
    ) -> Result<Vec<Change>, EditFault> {
        let only = Self::fields(inputs, "in")?.len() == 1;
        if only { self.remove(entry, "in") } else { self.remove(inputs, input) }
    }

    /// Takes `node` out, with every connection to it.
    ///
    /// # Errors
    /// Where there is no such node.
    pub fn delete_node(&self, node: &str) -> Result<Vec<Change>, EditFault> {
        self.entry(node)?;
        let Some(nodes) = self.nodes()? else { return Ok(Vec::new()) };
        let mut changes = self.remove(nodes, node)?;
        let goes = |text: &str| names(text, node);
        for (name, entry) in Self::fields(nodes, "nodes")?.iter().filter(|(name, _)| name.value != node) {
            if let Some((_, Spanned { value: Literal::Text(text), .. })) = Self::field(entry, "for_each")?
                && goes(text)
            {
                changes.extend(self.remove(entry, "for_each")?);
            }
            let Some((_, inputs)) = Self::field(entry, "in")? else { continue };
            let fields = Self::fields(inputs, &name.value)?;
            let dies = |value: &Spanned<Literal>| match &value.value {
                Literal::Text(text) => goes(text),
                Literal::List(items) => {
                    !items.is_empty() && items.iter().all(|item| matches!(&item.value, Literal::Text(t) if goes(t)))
                }
                _ => false,
            };
            if !fields.is_empty() && fields.iter().all(|(_, value)| dies(value)) {
                changes.extend(self.remove(entry, "in")?);
                continue;
            }
            for (input, value) in fields {
                if dies(value) {
                    changes.extend(self.remove(inputs, &input.value)?);
                } else {
                    changes.extend(self.cut(entry, inputs, &input.value, value, goes)?);
                }
            }
        }
        if let Some((_, outputs)) = Self::field(&self.root, "outputs")? {
            for (output, value) in Self::fields(outputs, "outputs")? {
                if matches!(&value.value, Literal::Text(text) if goes(text)) {
                    changes.extend(self.remove(outputs, &output.value)?);
                }
            }
        }
        Ok(changes)
    }

    /// Gives `node` the name `to`, in every connection too.
    ///
    /// # Errors
    /// Where there is no such node, or the new name is taken or cannot be one.
    pub fn rename_node(&self, node: &str, to: &str) -> Result<Vec<Change>, EditFault> {
        self.entry(node)?;
        node_name(to)?;
        let Some(nodes) = self.nodes()? else { return Ok(Vec::new()) };
        let mut changes = Vec::new();
        let mut point = |value: &Spanned<Literal>| {
            if let Literal::Text(text) = &value.value
                && names(text, node)
            {
                changes.push(Change { span: value.span, text: quoted(&format!("{to}{}", &text[node.len()..])) });
            }
        };
        let fields = Self::fields(nodes, "nodes")?;
        if fields.iter().any(|(name, _)| name.value == to) {
            return Err(EditFault::Taken(to.to_owned()));
        }
        for (_, entry) in fields {
            Self::field(entry, "for_each")?.into_iter().for_each(|(_, value)| point(value));
            let Some((_, inputs)) = Self::field(entry, "in")? else { continue };
            for (_, value) in Self::fields(inputs, "in")? {
                match &value.value {
                    Literal::List(items) => items.iter().for_each(&mut point),
                    _ => point(value),
                }
            }
        }
        if let Some((_, outputs)) = Self::field(&self.root, "outputs")? {
            Self::fields(outputs, "outputs")?.iter().for_each(|(_, value)| point(value));
        }
        let key = Self::field(nodes, node)?.map(|(name, _)| name.span);
        changes.extend(key.map(|span| Change { span, text: quoted(to) }));
        Ok(changes)
    }
}

/// Whether the connection `text` (`node` or `node.port`) is to `node`.
fn names(text: &str, node: &str) -> bool {
    text.strip_prefix(node).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}
