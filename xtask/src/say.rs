//! Words to the person at the terminal: what was asked for on standard output, troubles on standard error.

use std::io::Write;

/// Writes a line to standard output. A reader that has gone away is no trouble.
pub fn line(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{text}").and_then(|()| out.flush());
}

/// Writes a line to standard error.
pub fn error(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}
