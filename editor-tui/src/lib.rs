//! The editor: a graph in a terminal.
//!
//! [`model`] is the state and knows nothing of terminals; [`action`] changes it, one file an action, and says what is to be
//! done outside ([`model::Effect`]); [`view`] draws it; [`preview`] makes values ready to be drawn; [`session`] does what is
//! to be done: it reads keys and files, cooks on a thread of its own, and sends what happens back as [`model::Message`]s.

// Nodes are known to a program only where their crate is linked.
use nodes as _;

pub mod action;
pub mod model;
pub mod preview;
pub mod session;
pub mod view;
