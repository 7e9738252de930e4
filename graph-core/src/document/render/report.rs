//! One diagnostic in the form that miette renders: the source line made safe for terminals, long lines cut and broken.

use crate::document::{Diagnostic, Place};
use miette::{LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use std::fmt;

/// Source lines longer than this are cut around the place.
const LONGEST_LINE: usize = 240;

/// A diagnostic as miette renders it.
#[derive(Debug)]
pub(super) struct Report {
    code: &'static str,
    pub message: String,
    help: Option<String>,
    snippet: Option<Snippet>,
    nested: Option<Nested>,
}

impl Report {
    /// The diagnostic with its lines broken at `width` columns.
    pub fn new(diagnostic: &Diagnostic, width: usize) -> Self {
        let through = diagnostic.through.iter();
        let nested = through.fold(None, |outer: Option<Nested>, place| {
            Some(Nested { text: format!("nested at {}", place.text()), outer: outer.map(Box::new) })
        });
        Self {
            code: diagnostic.code,
            message: wrapped(&clean(&diagnostic.message), width - 4),
            help: diagnostic.help.as_deref().map(|help| wrapped(&clean(help), width - 8)),
            snippet: diagnostic.place.as_ref().map(|(place, label)| Snippet::new(place, label)),
            nested,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Report {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.nested.as_ref().map(|nested| nested as &(dyn std::error::Error + 'static))
    }
}

impl miette::Diagnostic for Report {
    fn code(&self) -> Option<Box<dyn fmt::Display + '_>> {
        Some(Box::new(self.code))
    }

    fn help(&self) -> Option<Box<dyn fmt::Display + '_>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.snippet.as_ref().map(|snippet| snippet as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = self.snippet.as_ref()?.mark.clone();
        Some(Box::new(std::iter::once(label)))
    }
}

/// A place through which a graph is nested, and those around it.
#[derive(Debug)]
struct Nested {
    text: String,
    outer: Option<Box<Nested>>,
}

impl fmt::Display for Nested {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl std::error::Error for Nested {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.outer.as_ref().map(|outer| outer as &(dyn std::error::Error + 'static))
    }
}

/// The line in which a place begins, cut where it is long, and what is marked in it.
#[derive(Debug)]
struct Snippet {
    name: String,
    text: String,
    mark: LabeledSpan,
    /// Line and column, both from 0, columns in characters.
    line: usize,
    column: usize,
}

impl Snippet {
    fn new(place: &Place, label: &str) -> Self {
        let text = &place.source.text;
        let boundary = |mut at: usize| {
            at = at.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let (start, end) = (boundary(place.span.start), boundary(place.span.end));
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let line_end = if text[start..line_end].ends_with('\r') { line_end - 1 } else { line_end };
        let mut window = line_start..line_end;
        if window.len() > LONGEST_LINE {
            window.start = boundary(start.saturating_sub(LONGEST_LINE / 3)).max(line_start);
            window.end = boundary(window.start + LONGEST_LINE).min(line_end);
        }
        let end = end.clamp(start, window.end.max(start));
        let label = Some(clean(label)).filter(|label| !label.is_empty());
        let (line, column) = place.source.line_column(start);
        Self {
            name: place.source.path.display().to_string(),
            text: text[window.clone()].chars().fold(String::new(), push_shown),
            mark: LabeledSpan::new(label, start - window.start, end - start),
            line: line - 1,
            column: column - 1,
        }
    }
}

impl SourceCode for Snippet {
    fn read_span<'a>(
        &'a self,
        _span: &SourceSpan,
        _before: usize,
        _after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let whole = SourceSpan::from(0..self.text.len());
        let name = self.name.clone();
        let text = self.text.as_bytes();
        Ok(Box::new(MietteSpanContents::new_named(name, text, whole, self.line, self.column, 1)))
    }
}

/// Puts `c` at the end of `line`; a sign that would steer a terminal becomes as many question marks as it has bytes.
fn push_shown(mut line: String, c: char) -> String {
    if c.is_control() && c != '\t' {
        line.push_str(&"??"[..c.len_utf8()]);
    } else {
        line.push(c);
    }
    line
}

/// Signs that would steer a terminal are written as escapes.
fn clean(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut out, c| {
        if c.is_control() && c != '\n' {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
        out
    })
}

/// Breaks lines at blanks so that they have at most `width` characters, where words allow it. (miette would break
/// within words and paths, too, and so keep terminals from recognising them.)
pub(super) fn wrapped(text: &str, width: usize) -> String {
    let mut out = String::with_capacity(text.len());
    let mut column = 0;
    for (index, word) in text.split(' ').enumerate() {
        let length = word.chars().count();
        if index > 0 && column + 1 + length > width {
            out.push('\n');
            column = 0;
        } else if index > 0 {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column = word.rsplit_once('\n').map_or(column + length, |(_, tail)| tail.chars().count());
    }
    out
}
