//! The engine from graph files to cooked results, on a small world of numbers over frames.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

mod cook;
mod growth;
mod live;
mod model;
mod nesting;
mod oracle;
mod parts;
mod random;
mod rendered;
mod rest;
mod told;
mod world;
