//! RON text to [`Literal`](super::Literal)s with places, tolerant of mistakes: the first step of reading a graph.
//!
//! It accepts what the `ron` crate accepts, except byte strings, ranges and whole numbers beyond 64 bits, which mean
//! nothing in a graph. Unlike `ron` it goes on after a mistake, so that a graph's mistakes show in one pass.

mod group;
mod lexer;
mod number;
mod parser;
mod quoted;
mod text;

#[cfg(test)]
mod tests;

pub(super) use parser::parse;
