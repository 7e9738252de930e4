//! From tokens to a [`Literal`] with places. After a mistake the parser goes on where the text makes sense again.

use super::group::Group;
use super::lexer::{Bracket, Cut, Lexed, Lexeme, SyntaxError, Token, lex};
use super::text::shown;
use crate::document::nearest::nearest_or_all;
use crate::document::{Literal, Span, Spanned};

/// How many strings are tried as the one whose closing quote is missing.
const OPEN_STRINGS_TRIED: usize = 12;
/// How often the parser looks ahead to tell a bracket too many from one too few.
const LOOKS_AHEAD: usize = 16;
const EXTENSIONS: [&str; 4] = ["explicit_struct_names", "implicit_some", "unwrap_newtypes", "unwrap_variant_newtypes"];

/// What a RON text holds.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::document) struct Parsed {
    /// The value; `None` where there is none.
    pub value: Option<Spanned<Literal>>,
    /// All mistakes, in the order of the text.
    pub errors: Vec<SyntaxError>,
}

/// Reads a RON text.
pub(in crate::document) fn parse(source: &str) -> Parsed {
    let lexed = lex(source, None);
    if !lexed.open_string {
        return parse_tokens(source, lexed);
    }
    // A closing quote is missing somewhere before the end, and every string after it is inside out. The one that
    // leaves the fewest mistakes when it is taken to end in its line is the culprit.
    let suspects = lexed.suspects.iter().take(OPEN_STRINGS_TRIED);
    let cuts = suspects.flat_map(|start| [false, true].map(|whole_line| Cut { start: *start, whole_line }));
    let attempts = cuts.map(|cut| lex(source, Some(cut)));
    let closed = attempts.filter(|attempt| !attempt.open_string).map(|attempt| parse_tokens(source, attempt));
    closed.min_by_key(|parsed| parsed.errors.len()).unwrap_or_else(|| parse_tokens(source, lexed))
}

fn parse_tokens(source: &str, lexed: Lexed) -> Parsed {
    let Lexed { tokens, errors, hidden_rest, .. } = lexed;
    let mut parser = Parser { source, tokens, at: 0, errors, open: Vec::new(), looks_ahead: LOOKS_AHEAD, hidden_rest };
    parser.extensions();
    let value = parser.value();
    parser.rest();
    parser.errors.sort_by_key(|error| error.span);
    Parsed { value, errors: parser.errors }
}

/// Where the parser is.
pub(super) struct Parser<'a> {
    pub source: &'a str,
    pub tokens: Vec<Token>,
    pub at: usize,
    pub errors: Vec<SyntaxError>,
    pub open: Vec<(Bracket, Span)>,
    pub looks_ahead: usize,
    /// Whether the end of the text is hidden, so that brackets may well be closed there.
    pub hidden_rest: bool,
}

impl Parser<'_> {
    pub fn peek(&self) -> &Lexeme {
        &self.tokens[self.at].lexeme
    }

    pub fn span(&self) -> Span {
        self.tokens[self.at].span
    }

    pub fn second(&self) -> &Lexeme {
        &self.tokens[(self.at + 1).min(self.tokens.len() - 1)].lexeme
    }

    /// Takes the next token; the end is never passed.
    pub fn next(&mut self) -> Token {
        let last = self.tokens.len() - 1;
        let blank = Token { lexeme: Lexeme::Broken, span: self.span() };
        if self.at == last {
            return Token { lexeme: Lexeme::End, ..blank };
        }
        self.at += 1;
        let token = &mut self.tokens[self.at - 1];
        match token.lexeme {
            Lexeme::Text(_) | Lexeme::Number(_) | Lexeme::Name(_) => std::mem::replace(token, blank),
            _ => token.clone(),
        }
    }

    /// End of the last token taken.
    pub fn end(&self) -> usize {
        self.at.checked_sub(1).map_or(0, |before| self.tokens[before].span.end)
    }

    pub fn found(&self) -> String {
        match self.peek() {
            Lexeme::End => "the end of the file".to_owned(),
            Lexeme::Text(_) => "a string".to_owned(),
            _ => format!("`{}`", shown(&self.source[self.span().start..self.span().end])),
        }
    }

    pub fn error(&mut self, span: Span, message: impl Into<String>) -> &mut SyntaxError {
        let index = self.errors.len();
        self.errors.push(SyntaxError::new(span, message));
        &mut self.errors[index]
    }

    /// `#![enable(…)]`, any number of times.
    pub fn extensions(&mut self) {
        use Lexeme::{Close, Comma, Name, Open, Sign};
        while *self.peek() == Sign('#') {
            let start = self.span().start;
            let enable = Name("enable".to_owned());
            let mut whole = [Sign('#'), Sign('!'), Open(Bracket::Square), enable, Open(Bracket::Round)]
                .iter()
                .all(|expected| self.take(expected));
            while whole && matches!(self.peek(), Name(_) | Comma) {
                let token = self.next();
                if let Name(name) = token.lexeme {
                    self.extension(&name, token.span);
                }
            }
            whole = whole && self.take(&Close(Bracket::Round)) && self.take(&Close(Bracket::Square));
            if !whole {
                let end = self.source[start..].find('\n').map_or(self.source.len(), |length| start + length);
                while self.span().start < end {
                    self.next();
                }
                let span = Span { start, end: self.end() };
                self.error(span, "this is no line of extensions").help =
                    Some("write `#![enable(implicit_some)]`, or leave it out".to_owned());
            }
        }
    }

    /// Takes the next token where it is `expected`.
    pub fn take(&mut self, expected: &Lexeme) -> bool {
        let found = self.peek() == expected;
        if found {
            self.next();
        }
        found
    }

    pub fn extension(&mut self, name: &str, span: Span) {
        if !EXTENSIONS.contains(&name) {
            let help = nearest_or_all("extensions", name, EXTENSIONS);
            self.error(span, format!("RON has no extension `{}`", shown(name))).help = help;
        }
    }

    /// What stands after the value.
    pub fn rest(&mut self) {
        if let Lexeme::Close(bracket) = *self.peek() {
            let span = self.span();
            self.error(span, format!("this `{}` closes nothing", bracket.close())).help =
                Some("take it away, or open it further up".to_owned());
        } else if *self.peek() != Lexeme::End && *self.peek() != Lexeme::Broken {
            let message = format!("expected the end of the file, found {}", self.found());
            let span = self.span();
            self.error(span, message).help = Some("a graph is one value: ( … )".to_owned());
        }
    }

    /// A value; `None`, with a mistake noted, where there is none.
    pub fn value(&mut self) -> Option<Spanned<Literal>> {
        let span = self.span();
        let value = match self.peek() {
            Lexeme::Text(_) | Lexeme::Number(_) | Lexeme::Name(_) => match self.next().lexeme {
                Lexeme::Text(text) => Literal::Text(text),
                Lexeme::Number(number) => number,
                Lexeme::Name(name) => return self.named(name, span),
                _ => return None,
            },
            Lexeme::Open(Bracket::Square) => match self.group(Bracket::Square) {
                Group::Items(items) => Literal::List(items),
                Group::Named(fields) => Literal::List(fields.into_iter().map(|(_, value)| value).collect()),
            },
            Lexeme::Open(Bracket::Curly) => match self.group(Bracket::Curly) {
                Group::Named(fields) => Literal::Map(fields),
                Group::Items(_) => Literal::Map(Vec::new()),
            },
            Lexeme::Open(Bracket::Round) => match self.group(Bracket::Round) {
                Group::Named(fields) => Literal::Map(fields),
                Group::Items(items) if items.is_empty() => Literal::Nothing,
                Group::Items(items) => Literal::List(items),
            },
            Lexeme::Broken => {
                self.next();
                return None;
            }
            Lexeme::End if !self.open.is_empty() => return None,
            Lexeme::End | Lexeme::Comma | Lexeme::Close(_) | Lexeme::Colon | Lexeme::Sign(_) => {
                let message = format!("expected a value, found {}", self.found());
                self.error(span, message);
                if matches!(self.peek(), Lexeme::Colon | Lexeme::Sign(_)) {
                    self.next();
                }
                return None;
            }
        };
        Some(Spanned { value, span: Span { start: span.start, end: self.end() } })
    }

    /// What a name that was just taken begins: `true`, `None`, `Some(x)`, `variant`, `variant(…)`.
    pub fn named(&mut self, name: String, span: Span) -> Option<Spanned<Literal>> {
        let is_raw = self.source[span.start..].starts_with("r#");
        let is_some = name == "Some" && !is_raw;
        if *self.peek() != Lexeme::Open(Bracket::Round) {
            let value = match name.as_str() {
                _ if is_raw => Literal::Text(name),
                "true" => Literal::Bool(true),
                "false" => Literal::Bool(false),
                "None" => Literal::Nothing,
                "Some" => {
                    self.error(span, "`Some` without a value").help = Some("write `Some(value)` or `None`".to_owned());
                    return None;
                }
                _ => Literal::Text(name),
            };
            return Some(Spanned { value, span });
        }
        let content_start = self.span().start;
        let group = self.group(Bracket::Round);
        let content_span = Span { start: content_start, end: self.end() };
        let whole = Span { start: span.start, end: self.end() };
        let content = match group {
            Group::Items(mut items) if items.len() == 1 => items.remove(0),
            Group::Items(items) if is_some => {
                self.error(whole, format!("`Some` takes one value, found {}", items.len()));
                return None;
            }
            Group::Items(items) if items.is_empty() => Spanned { value: Literal::Nothing, span: content_span },
            Group::Items(items) => Spanned { value: Literal::List(items), span: content_span },
            Group::Named(fields) => Spanned { value: Literal::Map(fields), span: content_span },
        };
        if is_some {
            return Some(content);
        }
        Some(Spanned { value: Literal::Variant(name, Box::new(content)), span: whole })
    }
}
