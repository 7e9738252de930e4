//! Why a cell is cooked: compares what its key is made of with what it was made of before.

use super::key::Part;
use super::session::{Cause, CellRecord, short};

/// The first difference between the parts of a key and those of the cook before.
pub(crate) enum Difference {
    /// The cell was never cooked before.
    New,
    /// A part that was not there before.
    Added(String),
    /// A part that is no longer there.
    Removed(String),
    /// A part that differs.
    Changed(String),
    /// Nothing differs, but the store no longer knows the result.
    Forgotten,
}

/// Compares the parts in their order: version, parameters, file, inputs. Parts that are `unknown` as yet count as equal.
pub(crate) fn difference(before: Option<&CellRecord>, now: &[Part], unknown: &[String]) -> Difference {
    let Some(before) = before else { return Difference::New };
    for part in now {
        match before.parts.iter().find(|(label, _)| *label == part.label) {
            None => return Difference::Added(part.label.clone()),
            Some((_, digest)) if *digest != short(&part.digest) => return Difference::Changed(part.label.clone()),
            Some(_) => {}
        }
    }
    let gone = |label: &String| now.iter().all(|part| part.label != *label) && !unknown.contains(label);
    let removed = before.parts.iter().find(|(label, _)| gone(label));
    removed.map_or(Difference::Forgotten, |(label, _)| Difference::Removed(label.clone()))
}

/// Tells the story of a cell from its session: what differed, and what that came from, up to its first cause.
pub fn story(session: &super::Session, cell: &str) -> Option<String> {
    let record = session.cells.get(cell)?;
    let mut lines = Vec::new();
    match &record.cooked {
        Some((run, cause)) if *run == session.run => {
            lines.push(format!("{cell} was cooked in the last run: {}", told(cause)));
            follow(session, cause, &mut lines);
        }
        Some((run, cause)) => {
            lines.push(format!(
                "{cell} was not cooked in the last run (number {}): nothing it depends on changed",
                session.run
            ));
            lines.push(format!("it was last cooked in run {run}: {}", told(cause)));
        }
        None => lines.push(format!("{cell} has not been cooked here: its result was found in the store")),
    }
    Some(lines.join("\n"))
}

/// A cause in words, with its place.
pub(crate) fn told(cause: &Cause) -> String {
    cause.place.as_ref().map_or_else(|| cause.text.clone(), |place| format!("{} ({place})", cause.text))
}

fn follow(session: &super::Session, cause: &Cause, lines: &mut Vec<String>) {
    let mut upstream = cause.upstream.as_ref();
    // A story longer than the graph would go in a circle.
    for depth in 1..=session.cells.len() {
        let Some(name) = upstream else { return };
        let Some(record) = session.cells.get(name) else { return };
        let indent = "  ".repeat(depth.min(20));
        match &record.cooked {
            Some((run, cause)) if *run == session.run => {
                lines.push(format!("{indent}← {name} was cooked: {}", told(cause)));
                upstream = cause.upstream.as_ref();
            }
            _ => {
                lines.push(format!("{indent}← {name} gave a result that the store already held"));
                return;
            }
        }
    }
}
