//! Lexing what stands in quotes: strings, raw strings, characters, and the ways in which quotes go wrong.

use super::lexer::{Cut, Lexeme, Lexer, ends_part, is_blank};
use super::text;

impl Lexer<'_> {
    /// A string.
    pub fn string(&mut self) {
        let start = self.at;
        let body = &self.source[start + 1..];
        let cut = self.cut.filter(|cut| cut.start == start);
        let length = if cut.is_some() { None } else { text::closing_quote(body) };
        self.suspect(length.is_none_or(|length| body[..length].contains('\n')));
        let Some(length) = length else { return self.open_string(cut) };
        let value = text::unescape(&body[..length], start + 1, &mut self.out.errors);
        self.push(Lexeme::Text(value), start + 1 + length + 1);
    }

    /// Notes that a string begins here; where it is a `long` one, it and those before it in its line are suspects.
    fn suspect(&mut self, long: bool) {
        if self.strings_of_line.last().is_some_and(|before| self.source[*before..self.at].contains('\n')) {
            self.strings_of_line.clear();
        }
        self.strings_of_line.push(self.at);
        if long {
            self.out.suspects.append(&mut self.strings_of_line);
        }
    }

    /// A string without an end: taken to end with its line, before the brackets and commas there, or before the first
    /// of these.
    fn open_string(&mut self, cut: Option<Cut>) {
        let start = self.at;
        self.out.open_string |= cut.is_none();
        let line = self.source[start + 1..].lines().next().unwrap_or("");
        let content = match cut {
            Some(Cut { whole_line: false, .. }) => line.split(ends_part).next().unwrap_or(""),
            _ => line.trim_end_matches(|c: char| is_blank(c) || ends_part(c)),
        };
        let end = start + 1 + content.len();
        let error = self.error(end, "this string is never closed");
        error.label = "a `\"` is missing at its end";
        self.push(Lexeme::Text(content.to_owned()), end);
    }

    /// `r"…"`, `r#"…"#`: the string has `hashes` signs on either side.
    pub fn raw_string(&mut self, hashes: usize) {
        let start = self.at;
        let content_start = start + 1 + hashes + 1;
        let closing = format!("\"{}", "#".repeat(hashes));
        let body = &self.source[content_start..];
        if let Some(length) = body.find(&closing) {
            let value = body[..length].to_owned();
            self.push(Lexeme::Text(value), content_start + length + closing.len());
        } else {
            self.out.hidden_rest = true;
            let error = self.error(content_start, "this raw string is never closed");
            error.help = Some(format!("close it with `{closing}`"));
            self.push(Lexeme::Broken, self.source.len());
        }
    }

    pub fn character(&mut self) {
        let start = self.at;
        let line = self.rest()[1..].lines().next().unwrap_or("");
        match text::character(line, start + 1) {
            Ok((value, length)) => self.push(Lexeme::Text(value.to_string()), start + 1 + length),
            Err(text::NoCharacter::String(length)) => {
                let value = line[..length].to_owned();
                let end = start + 1 + length + 1;
                self.error(end, "strings stand in double quotes").help = Some(format!("write \"{value}\""));
                self.push(Lexeme::Text(value), end);
            }
            Err(text::NoCharacter::Open) => {
                let content = line.split(ends_part).next().unwrap_or("").trim_end().to_owned();
                let end = start + 1 + content.len();
                let error = self.error(end, "strings stand in double quotes, and this one is never closed");
                error.help = Some(format!("write \"{content}\""));
                self.push(Lexeme::Text(content), end);
            }
            Err(text::NoCharacter::Escape(error, length)) => {
                self.out.errors.push(error);
                self.push(Lexeme::Broken, start + 1 + length);
            }
        }
    }

    /// “…”: what word processors make of quotes.
    pub fn curly_quotes(&mut self, content_start: usize) {
        let line = self.source[content_start..].lines().next().unwrap_or("");
        let length = line.find(['"', '\u{201c}', '\u{201d}']).unwrap_or(line.len());
        let closing = line[length..].chars().next().map_or(0, char::len_utf8);
        let value = line[..length].to_owned();
        let end = content_start + length + closing;
        self.error(end, "strings stand in straight double quotes").help = Some(format!("write \"{value}\""));
        self.push(Lexeme::Text(value), end);
    }
}
