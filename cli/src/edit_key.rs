//! `grimace edit-key`: sets or takes out one key in a file of edits. All else in the file stays as it is written.

use crate::arguments::{EditKey, Way};
use crate::exit::{Exit, Trouble};
use crate::output;
use face_math::data::{Key, KeyCurve, KeyTarget};
use graph_core::document::edit::save;
use nodes::edits_text::{self, KeyEdit};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// Writes the key, and says what it was before.
pub fn edit_key(arguments: &EditKey) -> Result<Exit, Trouble> {
    let path = &arguments.edits;
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(problem) if problem.kind() == ErrorKind::NotFound && !arguments.remove => edits_text::EMPTY.to_owned(),
        Err(problem) => return Err(wrong(path, &problem)),
    };
    let edit = match wanted(arguments) {
        Some(key) => KeyEdit::Set(key),
        None => KeyEdit::Remove(arguments.frame),
    };
    let edited = edits_text::edit_key(&text, &arguments.take, &arguments.channel, &edit);
    let edited = edited.map_err(|problem| wrong(path, &problem))?;
    save(path, &edited.text).map_err(|problem| wrong(path, &problem))?;
    let now = match wanted(arguments).as_ref() {
        Some(key) => shown(key),
        None => "as it was solved".to_owned(),
    };
    output::say(&format!(
        "{}: `{}` of take `{}` is {now} at frame {}",
        path.display(),
        arguments.channel,
        arguments.take,
        arguments.frame
    ));
    output::say(&format!("to go back: {}", back(arguments, edited.before.as_ref())));
    Ok(Exit::Fine)
}

/// The key that is asked for; none where it is to be taken out.
fn wanted(arguments: &EditKey) -> Option<Key> {
    let number = arguments.value?;
    let to = if arguments.offset { KeyTarget::Offset(number) } else { KeyTarget::Value(number) };
    let curve = match arguments.curve {
        Way::Smooth => KeyCurve::Smooth,
        Way::Linear => KeyCurve::Linear,
        Way::Hold => KeyCurve::Hold,
    };
    Some(Key { frame: arguments.frame, to, falloff_frames: arguments.falloff, curve })
}

fn shown(key: &Key) -> String {
    match key.to {
        KeyTarget::Value(value) => value.to_string(),
        KeyTarget::Offset(offset) => format!("{offset:+} beside the solve"),
    }
}

/// The command that undoes this one.
fn back(arguments: &EditKey, before: Option<&Key>) -> String {
    let start =
        format!("grimace edit-key {} {} {}", quoted(&arguments.take), quoted(&arguments.channel), arguments.frame);
    let end = format!("--edits {}", quoted(&arguments.edits.to_string_lossy()));
    let Some(key) = before else { return format!("{start} --remove {end}") };
    let (number, offset) = match key.to {
        KeyTarget::Value(value) => (value, ""),
        KeyTarget::Offset(offset) => (offset, " --offset"),
    };
    let curve = match key.curve {
        KeyCurve::Smooth => "smooth",
        KeyCurve::Linear => "linear",
        KeyCurve::Hold => "hold",
    };
    format!("{start} {number}{offset} --falloff {} --curve {curve} {end}", key.falloff_frames)
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = word.chars().all(|c| c.is_alphanumeric() || "_-./".contains(c));
    if plain && !word.is_empty() { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

fn wrong(path: &Path, problem: &dyn std::fmt::Display) -> Trouble {
    Trouble::command_line(format!("{}: {problem}", path.display()), None)
}
