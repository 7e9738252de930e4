//! Groups: what stands between brackets, and how the parser finds back after a bracket, comma or colon is missing.

use super::lexer::{Bracket, Lexeme, is_name};
use super::parser::Parser;
use super::text::shown;
use crate::document::{Literal, Span, Spanned};
use std::collections::BTreeSet;

/// Brackets may nest this deep, as in the `ron` crate.
const DEEPEST: usize = 128;

/// What stands between round brackets.
pub(super) enum Group {
    Named(Vec<(Spanned<String>, Spanned<Literal>)>),
    Items(Vec<Spanned<Literal>>),
}

impl Parser<'_> {
    /// Everything between the bracket that stands here and its partner.
    pub fn group(&mut self, bracket: Bracket) -> Group {
        let opening = self.next().span;
        self.open.push((bracket, opening));
        let mut fields = Vec::new();
        let mut items = Vec::new();
        if self.open.len() > DEEPEST {
            self.error(opening, format!("brackets nest deeper than {DEEPEST}"));
            self.skip_group();
        } else {
            let mut styles = BTreeSet::new();
            while !self.closes(bracket, !fields.is_empty()) {
                self.item(bracket, &mut fields, &mut items, &mut styles);
            }
        }
        self.open.pop();
        if bracket == Bracket::Curly || !fields.is_empty() { Group::Named(fields) } else { Group::Items(items) }
    }

    /// Takes everything up to the partner of the bracket just taken, without looking at it.
    fn skip_group(&mut self) {
        let mut depth = 1_usize;
        while depth > 0 && *self.peek() != Lexeme::End {
            match self.next().lexeme {
                Lexeme::Open(_) => depth += 1,
                Lexeme::Close(_) => depth -= 1,
                _ => {}
            }
        }
    }

    /// Whether the group ends here: at its bracket, or where that must be missing.
    fn closes(&mut self, bracket: Bracket, has_fields: bool) -> bool {
        match *self.peek() {
            Lexeme::Close(closing) if closing == bracket => {
                self.next();
                true
            }
            Lexeme::Close(closing) => {
                let enclosing = &self.open[..self.open.len() - 1];
                let belongs_outside = enclosing.iter().any(|(open, _)| *open == closing);
                if belongs_outside && !self.balances_from(self.at + 1) {
                    self.unclosed(bracket);
                    return true;
                }
                let span = self.next().span;
                let message = format!("expected `{}`, found `{}`", bracket.close(), closing.close());
                self.error(span, message).label = "closes nothing";
                // What follows is as if the bracket were not there.
                self.take(&Lexeme::Comma);
                false
            }
            Lexeme::End => {
                self.unclosed(bracket);
                true
            }
            // `"name":` belongs into { }, `name:` into ( ): where the surrounding bracket is of that kind and this
            // one is not, this one should have been closed before.
            Lexeme::Text(_) | Lexeme::Name(_) if *self.second() == Lexeme::Colon => {
                let wanted = if matches!(self.peek(), Lexeme::Text(_)) { Bracket::Curly } else { Bracket::Round };
                let outer = self.open.len().checked_sub(2).map(|outer| self.open[outer].0);
                let missing = bracket != wanted
                    && outer == Some(wanted)
                    && (has_fields || bracket == Bracket::Square)
                    && !self.balances_from(self.at);
                if missing {
                    self.unclosed(bracket);
                }
                missing
            }
            _ => false,
        }
    }

    fn unclosed(&mut self, bracket: Bracket) {
        let Some((_, opening)) = self.open.last().copied() else { return };
        let before = if *self.peek() == Lexeme::End {
            if self.hidden_rest {
                return;
            }
            self.error(opening, format!("this `{}` is never closed", bracket.open()))
        } else {
            let line = self.source[..self.span().start].matches('\n').count() + 1;
            let message =
                format!("this `{}` is not closed before {} in line {line}", bracket.open(), self.found_text());
            self.error(opening, message)
        };
        before.label = "opened here";
        before.help = Some(format!("add the missing `{}`", bracket.close()));
    }

    fn found_text(&self) -> String {
        format!("`{}`", shown(&self.source[self.span().start..self.span().end]))
    }

    /// Whether every bracket that is open here is closed by the tokens from `from` on, and every bracket there too.
    fn balances_from(&mut self, from: usize) -> bool {
        if self.looks_ahead == 0 {
            return false;
        }
        self.looks_ahead -= 1;
        let mut open: Vec<Bracket> = self.open.iter().map(|(bracket, _)| *bracket).collect();
        for token in &self.tokens[from..] {
            match token.lexeme {
                Lexeme::Open(bracket) => open.push(bracket),
                Lexeme::Close(bracket) if open.pop() != Some(bracket) => return false,
                _ => {}
            }
        }
        open.is_empty()
    }

    /// One item or field of a group, and the comma after it. `styles` keeps mistakes of style to one a group.
    fn item(
        &mut self,
        bracket: Bracket,
        fields: &mut Vec<(Spanned<String>, Spanned<Literal>)>,
        items: &mut Vec<Spanned<Literal>>,
        styles: &mut BTreeSet<&'static str>,
    ) {
        if *self.peek() == Lexeme::Comma {
            let span = self.next().span;
            let what = if bracket == Bracket::Curly { "a key" } else { "a value" };
            self.error(span, format!("expected {what} or `{}`, found `,`", bracket.close()));
            return;
        }
        let is_key = match self.second() {
            Lexeme::Colon | Lexeme::Sign('=') => {
                matches!(self.peek(), Lexeme::Text(_) | Lexeme::Name(_) | Lexeme::Number(_) | Lexeme::Broken)
            }
            // `(nodes { … })`: a name with its `:` missing.
            Lexeme::Open(Bracket::Curly | Bracket::Square) | Lexeme::Text(_) | Lexeme::Number(_) => {
                bracket == Bracket::Round && matches!(self.peek(), Lexeme::Name(_))
            }
            _ => false,
        };
        if is_key || bracket == Bracket::Curly {
            let first = fields.is_empty() && items.is_empty();
            if bracket == Bracket::Round && !items.is_empty() && styles.insert("mixed") {
                let span = self.span();
                self.error(span, "either all values in ( ) have names, or none");
            }
            let (value_follows, key) = self.key(bracket, first, styles);
            let value = if value_follows { self.value() } else { None };
            fields.extend(key.zip(value));
        } else {
            let span = self.span();
            if !fields.is_empty() && styles.insert("mixed") {
                self.error(span, "either all values in ( ) have names, or none");
            }
            items.extend(self.value());
        }
        match self.peek() {
            Lexeme::Comma => {
                self.next();
            }
            Lexeme::Close(_) | Lexeme::End => {}
            // A group within was closed for want of its bracket, after its last comma.
            _ if self.tokens[self.at - 1].lexeme == Lexeme::Comma => {}
            _ => {
                let message = format!("expected `,` or `{}`, found {}", bracket.close(), self.found());
                let end = self.end();
                self.error(Span { start: end, end }, message).label = "a `,` is missing here";
            }
        }
    }

    /// A key with the `:` after it: whether a value follows, and the key, where it is one.
    fn key(
        &mut self,
        bracket: Bracket,
        first: bool,
        styles: &mut BTreeSet<&'static str>,
    ) -> (bool, Option<Spanned<String>>) {
        let written = &self.source[self.span().start..self.span().end];
        if bracket == Bracket::Round && matches!(self.peek(), Lexeme::Number(_)) && is_name(written) {
            // `inf` and `NaN` are names before a `:`.
            self.tokens[self.at].lexeme = Lexeme::Name(written.to_owned());
        }
        let starts_bare = matches!(self.peek(), Lexeme::Name(_));
        let key = self.value();
        let end = self.end();
        let value_follows = match self.peek() {
            Lexeme::Colon => {
                self.next();
                true
            }
            Lexeme::Sign('=') => {
                let span = self.next().span;
                self.error(span, "expected `:` after a name, found `=`");
                true
            }
            _ if key.is_some() => {
                let message = format!("expected `:` and a value, found {}", self.found());
                self.error(Span { start: end, end }, message).label = "a `:` is missing here";
                matches!(self.peek(), Lexeme::Text(_) | Lexeme::Number(_) | Lexeme::Name(_) | Lexeme::Open(_))
            }
            _ => false,
        };
        let Some(Spanned { value, span }) = key else { return (value_follows, None) };
        let is_bare = starts_bare && matches!(value, Literal::Text(_));
        let name = match value {
            Literal::Text(text) => text,
            Literal::Integer(number) => number.to_string(),
            Literal::Number(number) => number.to_string(),
            Literal::Bool(value) => value.to_string(),
            Literal::Nothing | Literal::List(_) | Literal::Map(_) | Literal::Variant(..) => {
                self.error(span, "a key must be a string");
                return (value_follows, None);
            }
        };
        self.key_style(bracket, span, (is_bare, first), styles);
        (value_follows, Some(Spanned { value: name, span }))
    }

    /// Notes a key that is quoted in ( ), bare in { }, or stands in [ ].
    fn key_style(&mut self, bracket: Bracket, span: Span, (bare, first): (bool, bool), styles: &mut BTreeSet<&str>) {
        let braces = "use { } around quoted keys";
        let (style, message, help) = match (bracket, bare) {
            (Bracket::Curly, true) if first => ("bare", "keys in { } stand in quotes", "use quotes, or ( ) for fields"),
            (Bracket::Curly, true) => ("bare", "keys in { } stand in quotes", "write it in quotes"),
            (Bracket::Round, false) => ("quoted", "names in ( ) stand without quotes", braces),
            (Bracket::Square, _) => ("keyed", "a list [ ] has no names", braces),
            (Bracket::Curly, false) | (Bracket::Round, true) => return,
        };
        if styles.insert(style) {
            self.error(span, message).help = Some(help.to_owned());
        }
    }
}
