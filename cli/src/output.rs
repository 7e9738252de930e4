//! Where text goes: results to standard output, words for people to standard error.

use crate::exit::Trouble;
use console::style;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Writes a result to standard output.
///
/// # Errors
/// Where it cannot be written, a reader that went away included.
pub fn print(text: &str) -> Result<(), Trouble> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// Writes one JSON object as one line to standard output.
///
/// # Errors
/// As [`print()`].
pub fn print_json(object: &impl Serialize) -> Result<(), Trouble> {
    print(&json_line(object)?)
}

/// One JSON object as one line.
///
/// # Errors
/// Never for plain data.
pub fn json_line(object: &impl Serialize) -> io::Result<String> {
    let mut line = serde_json::to_string(object)?;
    line.push('\n');
    Ok(line)
}

/// Writes a line for people to standard error. Where nobody reads it, that is no trouble.
pub fn say(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Tells people of an error and its cure.
pub fn error(message: &str, help: Option<&str>) {
    let mut text = format!("{} {message}", style("error:").red().bold().for_stderr());
    if let Some(help) = help {
        let _ = write!(text, "\n  {} {help}", style("help:").cyan().for_stderr());
    }
    say(&text);
}
