//! Why a cell is cooked: compares what its key is made of with what it was made of before.

use super::cell::{Link, Settings};
use super::key::Part;
use super::session::{Cause, CellRecord, Reason, short};
use wire::Digest;

/// What a key is made of now; inputs that are not known yet count as equal.
pub(crate) struct Now<'a> {
    pub settings: &'a Settings,
    pub file: Option<Digest>,
    pub links: &'a [Link],
    pub inputs: Vec<Option<Digest>>,
}

/// The first part that differs from those of an earlier process, in their order: version, parameters, file, inputs.
pub(crate) fn difference(before: Option<&CellRecord>, now: &Now<'_>) -> Reason {
    let Some(before) = before else { return Reason::New };
    let was = |label: &str| before.parts.iter().find(|(known, _)| known == label).map(|(_, digest)| *digest);
    let own = now.settings.parts.iter().map(|part| (part.label.clone(), part.digest));
    for (label, digest) in own.chain(now.file.map(|file| ("file".to_owned(), file))) {
        match was(&label) {
            None => return Reason::Added(label),
            Some(known) if known != short(&digest) => return Reason::Changed(label),
            Some(_) => {}
        }
    }
    for (index, (link, digest)) in now.links.iter().zip(&now.inputs).enumerate() {
        let label = link.label();
        match (was(&label), digest) {
            (None, _) => return Reason::Added(label),
            (Some(known), Some(digest)) if known != short(digest) => return Reason::Input(index, None),
            _ => {}
        }
    }
    let stands = |label: &String| {
        now.settings.parts.iter().any(|part| part.label == *label)
            || (label == "file" && now.file.is_some())
            || now.links.iter().any(|link| link.label() == *label)
    };
    let removed = before.parts.iter().find(|(label, _)| !stands(label));
    removed.map_or(Reason::Forgotten, |(label, _)| Reason::Removed(label.clone()))
}

/// The first part of a cell's own settings that differs.
pub(crate) fn settings_difference(before: &[Part], now: &[Part]) -> Option<Reason> {
    for part in now {
        match before.iter().find(|known| known.label == part.label) {
            None => return Some(Reason::Added(part.label.clone())),
            Some(known) if known.digest != part.digest => return Some(Reason::Changed(part.label.clone())),
            Some(_) => {}
        }
    }
    let removed = before.iter().find(|known| now.iter().all(|part| part.label != known.label));
    removed.map(|part| Reason::Removed(part.label.clone()))
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
