//! Entries of maps and structures in a text: put in and taken out in the way of those that stand beside them.

use super::{Change, Draft, EditFault, plain, quoted};
use crate::document::{Literal, Span, Spanned};

impl Draft<'_> {
    /// Puts `name: value` into `map`, after the entry at `after`, or at its end.
    pub(super) fn insert(
        &self,
        map: &Spanned<Literal>,
        after: Option<usize>,
        name: &str,
        value: &str,
    ) -> Result<Vec<Change>, EditFault> {
        let fields = Self::fields(map, name)?;
        let open = map.span.start;
        let key = match self.text.as_bytes().get(open) {
            Some(b'{') => quoted(name),
            Some(b'(') => plain(name)?.to_owned(),
            _ => return Err(EditFault::Shape(name.to_owned())),
        };
        let last = fields.len().checked_sub(1).map(|last| after.map_or(last, |after| after.min(last)));
        let Some(last) = last else {
            let inner = &self.text[open + 1..map.span.end.saturating_sub(1).max(open + 1)];
            let text = if inner.contains('\n') {
                format!("\n{}    {key}: {value},", self.indent(open))
            } else {
                format!("{key}: {value}")
            };
            return Ok(vec![Change { span: empty(open + 1), text }]);
        };
        let (own_key, own_value) = &fields[last];
        let end = own_value.span.end;
        let comma = self.comma_after(end);
        let first_on_line = self.text[..own_key.span.start].rsplit('\n').next().is_some_and(is_blank);
        if !first_on_line || !self.text[open..own_key.span.start].contains('\n') {
            let text = format!(" {key}: {value}");
            return Ok(match comma {
                Some(comma) if last + 1 == fields.len() => vec![Change { span: empty(comma + 1), text }],
                Some(comma) => vec![Change { span: empty(comma + 1), text: text + "," }],
                None => vec![Change { span: empty(end), text: format!(",{text}") }],
            });
        }
        let gap = self.text[own_key.span.end..own_value.span.start].strip_prefix(':').unwrap_or(" ");
        let aligned = is_blank(gap) && gap.len() > 1;
        let room = own_value.span.start - own_key.span.start;
        let blanks = if aligned { room.saturating_sub(key.len() + 1).max(1) } else { 1 };
        let indent = self.indent(own_key.span.start);
        let line = format!("\n{indent}{key}:{}{value},", " ".repeat(blanks));
        let line_end = self.line_end(comma.map_or(end, |comma| comma + 1));
        let mut changes = Vec::new();
        if comma.is_none() {
            changes.push(Change { span: empty(end), text: ",".to_owned() });
        }
        // The bracket may be closed in the line of the last entry.
        let close = map.span.end - 1;
        if line_end > close {
            changes.push(Change { span: empty(comma.map_or(end, |comma| comma + 1)), text: line });
        } else {
            changes.push(Change { span: empty(line_end), text: line });
        }
        Ok(changes)
    }

    /// Takes the entry `name` out of `map`, with its line where it has one of its own.
    pub(super) fn remove(&self, map: &Spanned<Literal>, name: &str) -> Result<Vec<Change>, EditFault> {
        let fields = Self::fields(map, name)?;
        let Some(at) = fields.iter().position(|(key, _)| key.value == name) else { return Ok(Vec::new()) };
        let before = at.checked_sub(1).map(|before| fields[before].1.span.end);
        let span = Span { start: fields[at].0.span.start, end: fields[at].1.span.end };
        Ok(vec![self.removal(span, before)])
    }

    /// Takes out what stands at `span` with its comma; `before` is where the neighbour before it ends.
    pub(super) fn removal(&self, span: Span, before: Option<usize>) -> Change {
        let comma = self.comma_after(span.end);
        let end = comma.map_or(span.end, |comma| comma + 1);
        let line_start = self.text[..span.start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = self.line_end(end);
        let rest = self.text[end..line_end].trim();
        let alone = is_blank(&self.text[line_start..span.start]) && (rest.is_empty() || rest.starts_with("//"));
        if alone && line_end < self.text.len() {
            return deletion(line_start, line_end + 1);
        }
        if comma.is_none()
            && let Some(before) = before
            && self.text[before..span.start].chars().all(|c| c == ',' || c == ' ')
        {
            return deletion(before, span.end);
        }
        let blanks = self.text[end..].len() - self.text[end..].trim_start_matches(' ').len();
        deletion(span.start, end + blanks)
    }

    /// Where the comma is that follows `at`, past blanks and comments.
    fn comma_after(&self, at: usize) -> Option<usize> {
        let at = self.past_trivia(at, true);
        self.text[at..].starts_with(',').then_some(at)
    }

    /// The end of the line in which `at` is, or where a comment that begins in it ends.
    fn line_end(&self, at: usize) -> usize {
        let at = self.past_trivia(at, false);
        self.text[at..].find('\n').map_or(self.text.len(), |length| at + length)
    }

    /// Past blanks and comments from `at`, past ends of lines where `lines`.
    fn past_trivia(&self, mut at: usize, lines: bool) -> usize {
        loop {
            let rest = &self.text[at..];
            if rest.starts_with("//") {
                let length = rest.find('\n').unwrap_or(rest.len());
                if !lines {
                    return at + length;
                }
                at += length;
            } else if rest.starts_with("/*") {
                at += block_comment(rest);
            } else {
                match rest.chars().next() {
                    Some('\n') if !lines => return at,
                    Some(c) if c.is_whitespace() => at += c.len_utf8(),
                    _ => return at,
                }
            }
        }
    }

    /// The blanks that begin the line in which `at` is.
    fn indent(&self, at: usize) -> String {
        let line = &self.text[self.text[..at].rfind('\n').map_or(0, |at| at + 1)..at];
        line.chars().take_while(|c| *c == ' ' || *c == '\t').collect()
    }
}

/// The length of the block comment that `text` begins with; they nest.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    while at < text.len() {
        let rest = &text[at..];
        if rest.starts_with("/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if rest.starts_with("*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                return at;
            }
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
        }
    }
    text.len()
}

fn empty(at: usize) -> Span {
    Span { start: at, end: at }
}

fn deletion(start: usize, end: usize) -> Change {
    Change { span: Span { start, end }, text: String::new() }
}

fn is_blank(text: &str) -> bool {
    text.chars().all(|c| c == ' ' || c == '\t')
}
