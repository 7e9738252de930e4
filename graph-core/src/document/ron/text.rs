//! Strings and characters of RON: where they end, and what their escapes mean.

use super::lexer::SyntaxError;
use crate::document::Span;

/// Bytes before the `"` that ends a string whose content is at the beginning of `body`.
pub(super) fn closing_quote(body: &str) -> Option<usize> {
    let bytes = body.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b'"' => return Some(at),
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    None
}

/// The text that `body`, the content of a string at byte `start`, stands for. A wrong escape is noted and kept as
/// it is written.
pub(super) fn unescape(body: &str, start: usize, errors: &mut Vec<SyntaxError>) -> String {
    let mut out = String::with_capacity(body.len());
    let mut at = 0;
    while let Some(offset) = body[at..].find('\\') {
        out.push_str(&body[at..at + offset]);
        at += offset;
        let rest = &body[at + 1..];
        if rest.starts_with('\n') || rest.starts_with("\r\n") {
            at = body.len() - rest.trim_start_matches([' ', '\t', '\n', '\r']).len();
            continue;
        }
        match escape(&body[at..], true) {
            Ok((c, length)) => {
                out.push(c);
                at += length;
            }
            Err(fault) => {
                let length = fault.length.min(body.len() - at);
                let span = Span { start: start + at, end: start + at + length };
                errors.push(fault.at(span));
                out.push_str(&body[at..at + length]);
                at += length;
            }
        }
    }
    out.push_str(&body[at..]);
    out
}

/// Why there is no character.
pub(super) enum NoCharacter {
    /// It is a string in single quotes, of so many bytes.
    String(usize),
    /// It has no end.
    Open,
    /// Its escape is wrong; so many bytes to skip, with the closing quote.
    Escape(SyntaxError, usize),
}

/// The character whose content is at the beginning of `line` (at byte `start`), and its length with the `'`.
pub(super) fn character(line: &str, start: usize) -> Result<(char, usize), NoCharacter> {
    let first = line.chars().next().ok_or(NoCharacter::Open)?;
    let (value, length) = if first == '\\' {
        match escape(line, false) {
            Ok(found) => found,
            Err(fault) => {
                let length = fault.length.min(line.len());
                let error = fault.at(Span { start, end: start + length });
                let closing = usize::from(line[length..].starts_with('\''));
                return Err(NoCharacter::Escape(error, length + closing));
            }
        }
    } else {
        (first, first.len_utf8())
    };
    if line[length..].starts_with('\'') {
        return Ok((value, length + 1));
    }
    line.find('\'').map_or(Err(NoCharacter::Open), |length| Err(NoCharacter::String(length)))
}

/// A word as messages show it: at most 40 characters.
pub(super) fn shown(word: &str) -> String {
    let mut letters = word.chars();
    let mut out: String = letters.by_ref().take(40).collect();
    if letters.next().is_some() {
        out.push('…');
    }
    out
}

struct EscapeFault {
    length: usize,
    message: String,
    help: Option<String>,
}

impl EscapeFault {
    fn new(length: usize, message: &str) -> Self {
        Self { length, message: message.to_owned(), help: None }
    }

    fn at(self, span: Span) -> SyntaxError {
        SyntaxError { span, message: self.message, label: "", help: self.help }
    }
}

/// The character that the escape at the beginning of `text` stands for, and the escape's length. In strings,
/// several `\x` may together be the bytes of one character.
fn escape(text: &str, in_string: bool) -> Result<(char, usize), EscapeFault> {
    let Some(sign) = text[1..].chars().next() else {
        return Err(EscapeFault::new(1, "a `\\` stands at the end"));
    };
    let plain = match sign {
        '\'' | '"' | '\\' => sign,
        'n' => '\n',
        'r' => '\r',
        't' => '\t',
        '0' => '\0',
        'x' => return bytes_escape(text, in_string),
        'u' => return unicode_escape(text),
        other => {
            let length = 1 + other.len_utf8();
            let fault = EscapeFault::new(length, &format!("`\\{}` is no escape", other.escape_debug()));
            let help = "write `\\\\` for a backslash; in paths, write `/`, or use a raw string: r\"…\"";
            return Err(EscapeFault { help: Some(help.to_owned()), ..fault });
        }
    };
    Ok((plain, 2))
}

fn bytes_escape(text: &str, in_string: bool) -> Result<(char, usize), EscapeFault> {
    let most = if in_string { 4 } else { 1 };
    let mut bytes = Vec::new();
    while bytes.len() < most {
        let at = 4 * bytes.len();
        let Some(byte) = text.get(at..at + 4).and_then(|part| part.strip_prefix("\\x")).and_then(hexadecimal) else {
            break;
        };
        bytes.push(byte as u8);
        if let Some(c) = std::str::from_utf8(&bytes).ok().and_then(|text| text.chars().next()) {
            return Ok((c, at + 4));
        }
    }
    let message = if bytes.is_empty() { "`\\x` needs two hexadecimal digits" } else { "these bytes are no character" };
    Err(EscapeFault::new((4 * bytes.len()).max(2), message))
}

fn unicode_escape(text: &str) -> Result<(char, usize), EscapeFault> {
    let digits = text[2..].strip_prefix('{').and_then(|rest| rest.split_once('}')).map(|(digits, _)| digits);
    match digits {
        Some(digits) if (1..=6).contains(&digits.len()) => {
            let length = 2 + 1 + digits.len() + 1;
            let c = hexadecimal(digits).and_then(char::from_u32);
            c.map(|c| (c, length))
                .ok_or_else(|| EscapeFault::new(length, &format!("`\\u{{{digits}}}` is no character")))
        }
        _ => Err(EscapeFault::new(2, "`\\u` needs one to six hexadecimal digits in braces, as in `\\u{e9}`")),
    }
}

fn hexadecimal(digits: &str) -> Option<u32> {
    if digits.chars().all(|c| c.is_ascii_hexdigit()) { u32::from_str_radix(digits, 16).ok() } else { None }
}
