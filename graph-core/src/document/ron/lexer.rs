//! From RON text to tokens with their places. Faults of a lexeme are noted, and a token stands for it all the same.

use super::number;
use super::text;
use crate::document::{Literal, Span};
use unicode_ident::{is_xid_continue, is_xid_start};

/// A mistake in the spelling of a RON text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::document) struct SyntaxError {
    /// Where.
    pub span: Span,
    /// What was expected and what was found.
    pub message: String,
    /// A few words to stand at the place.
    pub label: &'static str,
    /// The cure, where one is known.
    pub help: Option<String>,
}

impl SyntaxError {
    /// A mistake at `span`.
    pub fn new(span: Span, message: impl Into<String>) -> Self {
        Self { span, message: message.into(), label: "", help: None }
    }
}

/// The three pairs of brackets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bracket {
    /// `( )`
    Round,
    /// `[ ]`
    Square,
    /// `{ }`
    Curly,
}

impl Bracket {
    pub fn open(self) -> char {
        match self {
            Self::Round => '(',
            Self::Square => '[',
            Self::Curly => '{',
        }
    }

    pub fn close(self) -> char {
        match self {
            Self::Round => ')',
            Self::Square => ']',
            Self::Curly => '}',
        }
    }
}

/// What a token is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Lexeme {
    Open(Bracket),
    Close(Bracket),
    Comma,
    Colon,
    /// A string or a character.
    Text(String),
    /// A number.
    Number(Literal),
    /// An identifier, `true`, `None` and the like.
    Name(String),
    /// A sign that RON knows only in `#![enable(…)]`, or not at all.
    Sign(char),
    /// Something that is no token; it was reported.
    Broken,
    /// The end of the text.
    End,
}

/// A lexeme and its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Token {
    pub lexeme: Lexeme,
    pub span: Span,
}

/// What lexing gives.
pub(super) struct Lexed {
    /// The tokens; the last is [`Lexeme::End`].
    pub tokens: Vec<Token>,
    pub errors: Vec<SyntaxError>,
    /// Where strings begin that may lack their closing quote: those that go over several lines, and those before them
    /// in the same line.
    pub suspects: Vec<usize>,
    /// Whether the text ends within a string.
    pub open_string: bool,
    /// Whether a comment or raw string without an end hides the rest of the text.
    pub hidden_rest: bool,
}

/// A string that is taken to lack its closing quote.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cut {
    /// Where it begins.
    pub start: usize,
    /// Whether it goes to the end of its line, or only to the next comma or closing bracket.
    pub whole_line: bool,
}

/// Cuts `source` into tokens, with the string `cut` taken to lack its closing quote.
pub(super) fn lex(source: &str, cut: Option<Cut>) -> Lexed {
    let out =
        Lexed { tokens: Vec::new(), errors: Vec::new(), suspects: Vec::new(), open_string: false, hidden_rest: false };
    let last_comment_end = source.rfind("*/");
    let mut lexer = Lexer { source, at: 0, cut, strings_of_line: Vec::new(), last_comment_end, out };
    lexer.at = if source.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    while lexer.token() {}
    let end = source.len();
    lexer.out.tokens.push(Token { lexeme: Lexeme::End, span: Span { start: end, end } });
    lexer.out
}

/// Where the lexer is.
pub(super) struct Lexer<'a> {
    pub source: &'a str,
    pub at: usize,
    pub cut: Option<Cut>,
    /// Where the strings begin that stand in the line of the last one.
    pub strings_of_line: Vec<usize>,
    last_comment_end: Option<usize>,
    pub out: Lexed,
}

impl Lexer<'_> {
    pub fn rest(&self) -> &str {
        &self.source[self.at..]
    }

    pub fn push(&mut self, lexeme: Lexeme, end: usize) {
        self.out.tokens.push(Token { lexeme, span: Span { start: self.at, end } });
        self.at = end;
    }

    pub fn error(&mut self, end: usize, message: impl Into<String>) -> &mut SyntaxError {
        let index = self.out.errors.len();
        self.out.errors.push(SyntaxError::new(Span { start: self.at, end }, message));
        &mut self.out.errors[index]
    }

    /// Reads one token; false at the end.
    fn token(&mut self) -> bool {
        self.skip_blanks();
        let Some(first) = self.rest().chars().next() else { return false };
        let after = self.at + first.len_utf8();
        match first {
            '(' => self.push(Lexeme::Open(Bracket::Round), after),
            ')' => self.push(Lexeme::Close(Bracket::Round), after),
            '[' => self.push(Lexeme::Open(Bracket::Square), after),
            ']' => self.push(Lexeme::Close(Bracket::Square), after),
            '{' => self.push(Lexeme::Open(Bracket::Curly), after),
            '}' => self.push(Lexeme::Close(Bracket::Curly), after),
            ',' => self.push(Lexeme::Comma, after),
            ':' => self.push(Lexeme::Colon, after),
            '=' | ';' | '#' | '!' => self.push(Lexeme::Sign(first), after),
            '"' => self.string(),
            '\'' => self.character(),
            '\u{201c}' | '\u{201d}' | '\u{201e}' => self.curly_quotes(after),
            _ => self.prefixed_or_word(),
        }
        true
    }

    fn skip_blanks(&mut self) {
        loop {
            let rest = self.rest();
            self.at += rest.len() - rest.trim_start_matches(is_blank).len();
            if self.rest().starts_with("//") {
                self.at += self.rest().find('\n').unwrap_or(self.rest().len());
            } else if self.rest().starts_with("/*") {
                if let Some(length) = block_comment(self.rest()) {
                    self.at += length;
                } else {
                    self.out.hidden_rest = true;
                    let error = self.error(self.at + 2, "this comment is never closed");
                    error.label = "opened here";
                    error.help = Some(
                        "close it with `*/`; a path or pattern with `/*` in it belongs in double quotes".to_owned(),
                    );
                    self.at = self.source.len();
                }
            } else {
                return;
            }
        }
    }

    fn prefixed_or_word(&mut self) {
        let rest = self.rest();
        if let Some(after) = rest.strip_prefix('r') {
            let hashes = after.len() - after.trim_start_matches('#').len();
            if after[hashes..].starts_with('"') {
                return self.raw_string(hashes);
            }
            if hashes == 1 && after[1..].starts_with(is_raw_name) {
                return self.raw_name();
            }
        }
        if let Some(line) = rest.strip_prefix("b'").and_then(|after| after.lines().next())
            && let Ok((value, length)) = text::character(line, self.at + 2)
            && value.is_ascii()
        {
            return self.push(Lexeme::Number(Literal::Integer(i64::from(u32::from(value)))), self.at + 2 + length);
        }
        if rest.starts_with("b\"") || rest.starts_with("br\"") || rest.starts_with("br#") {
            self.error(self.at + 2, "byte strings have no meaning in a graph").help =
                Some("write a string without the `b`".to_owned());
            self.at += 1;
            return;
        }
        self.word();
    }

    /// `r#name`: a name that may hold `.`, `+` and `-`.
    fn raw_name(&mut self) {
        let name: String = self.rest()[2..].chars().take_while(|c| is_raw_name(*c)).collect();
        let end = self.at + 2 + name.len();
        self.push(Lexeme::Name(name), end);
    }

    /// A run of characters up to the next blank, bracket, quote or comment: a name or a number, or neither.
    fn word(&mut self) {
        let rest = self.rest();
        let mut length = rest.find(ends_word).unwrap_or(rest.len());
        let word = &rest[..length];
        length = length.min(word.find("//").unwrap_or(length));
        // `takes/*.c3d`: what looks like a comment is none where nothing closes it.
        let comment = word.find("/*").filter(|offset| self.last_comment_end > Some(self.at + offset + 1));
        length = length.min(comment.unwrap_or(length));
        let word = rest[..length].to_owned();
        let end = self.at + length;
        if number::is_like(&word) {
            match number::read(&word) {
                Ok(value) => return self.push(Lexeme::Number(value), end),
                Err(fault) => {
                    let error = self.error(end, fault.message);
                    error.help = fault.help;
                }
            }
        } else if is_name(&word) {
            return self.push(Lexeme::Name(word), end);
        } else {
            self.error(end, format!("`{}` is neither a name nor a number", text::shown(&word))).help =
                Some(format!("if it is meant as text, write \"{}\"", text::shown(&word)));
        }
        self.push(Lexeme::Broken, end);
    }
}

/// The blanks of RON.
pub(super) fn is_blank(c: char) -> bool {
    matches!(
        c,
        ' ' | '\t' | '\n' | '\r' | '\x0b' | '\x0c' | '\u{85}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}'
    )
}

fn ends_word(c: char) -> bool {
    matches!(c, '(' | ')' | '[' | ']' | '{' | '}' | ',' | ':' | '=' | ';' | '#' | '!' | '"' | '\'')
        || matches!(c, '\u{201c}' | '\u{201d}')
        || is_blank(c)
}

/// What may stand after a value.
pub(super) fn ends_part(c: char) -> bool {
    matches!(c, ',' | ')' | ']' | '}')
}

fn is_raw_name(c: char) -> bool {
    is_xid_continue(c) || matches!(c, '.' | '+' | '-')
}

/// Whether `word` is a name that needs no quotes.
pub(super) fn is_name(word: &str) -> bool {
    let mut letters = word.chars();
    letters.next().is_some_and(|c| is_xid_start(c) || c == '_') && letters.all(is_xid_continue)
}

/// Length of the block comment, which may hold others, at the beginning of `text`.
fn block_comment(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (0, 0_usize);
    while at + 1 < bytes.len() {
        match &bytes[at..at + 2] {
            b"/*" => (depth, at) = (depth + 1, at + 2),
            b"*/" => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            return Some(at);
        }
    }
    None
}
