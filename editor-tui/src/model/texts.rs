//! The texts of a graph and of the graphs nested in it, as they are being edited: operations, undo and redo, what is saved.

use super::merge::{Merged, merge};
use graph_core::document::edit::{Change, apply};
use graph_core::document::{Graph, Source, Span, read};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// One replacement in one file, with what it takes away, so that it can be undone.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Step {
    /// The file.
    pub file: PathBuf,
    /// First byte.
    pub at: usize,
    /// What stood there.
    pub removed: String,
    /// What stands there now.
    pub inserted: String,
}

/// One operation of a person: steps in one or several files, under one name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Operation {
    /// What it does, for people: `rename calm to quiet`.
    pub label: String,
    /// The steps, in the order in which they are made.
    pub steps: Vec<Step>,
}

/// A file that is being edited.
#[derive(Debug, Clone)]
pub struct Text {
    /// As it is now.
    pub now: String,
    /// As it was last read from or written to disk.
    pub base: String,
    /// The graph in it, as far as it can be understood.
    pub graph: Option<Arc<Graph>>,
    /// Whether it is no graph but a source that one of its nodes reads, such as a file of edits.
    pub source: bool,
}

impl Text {
    fn new(path: &Path, text: String, source: bool) -> Self {
        let mut made = Self { graph: None, base: text.clone(), now: text, source };
        made.understand(path);
        made
    }

    fn understand(&mut self, path: &Path) {
        self.graph = if self.source { None } else { parsed(path, &self.now) };
    }
}

fn parsed(path: &Path, text: &str) -> Option<Arc<Graph>> {
    let source = Arc::new(Source::new(path, text));
    read(source).0.map(Arc::new)
}

/// All files of a graph.
#[derive(Debug, Clone, Default)]
pub struct Texts {
    files: BTreeMap<PathBuf, Text>,
    done: Vec<Operation>,
    undone: Vec<Operation>,
    /// Raised by every change.
    pub revision: u64,
    /// Raised by every change of a graph.
    pub graphs_revision: u64,
}

/// What became of a file that changed on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Taken {
    /// It holds what is known already.
    Same,
    /// It was taken over; nothing was edited here.
    Read,
    /// Its changes and those made here do not touch and stand together now.
    Merged,
    /// They touch: someone has to choose.
    Conflict,
}

impl Texts {
    /// Adds a graph file as it is on disk.
    pub fn add(&mut self, path: PathBuf, text: String) {
        let text = Text::new(&path, text, false);
        self.files.insert(path, text);
        self.revision += 1;
        self.graphs_revision += 1;
    }

    /// Adds a file that a node reads, as it is on disk.
    pub fn add_source(&mut self, path: PathBuf, text: String) {
        let text = Text::new(&path, text, true);
        self.files.insert(path, text);
        self.revision += 1;
    }

    /// The file at `path`.
    pub fn get(&self, path: &Path) -> Option<&Text> {
        self.files.get(path)
    }

    /// All files.
    pub fn files(&self) -> impl Iterator<Item = (&PathBuf, &Text)> {
        self.files.iter()
    }

    /// The texts that differ from what is on disk.
    pub fn unsaved(&self) -> BTreeMap<PathBuf, String> {
        let differing = self.files.iter().filter(|(_, text)| text.now != text.base);
        differing.map(|(path, text)| (path.clone(), text.now.clone())).collect()
    }

    /// Whether some text differs from what is on disk.
    pub fn is_unsaved(&self) -> bool {
        self.files.values().any(|text| text.now != text.base)
    }

    /// Says that `path` now holds `text` on disk, as it was written.
    pub fn saved(&mut self, path: &Path, text: &str) {
        if let Some(file) = self.files.get_mut(path) {
            text.clone_into(&mut file.base);
        }
    }

    /// Makes an operation of `changes` in the file at `path`, and makes it.
    pub fn edit(&mut self, label: impl Into<String>, path: &Path, changes: &[Change]) -> Option<Operation> {
        let file = self.files.get(path)?;
        let after = apply(&file.now, changes);
        if after == file.now {
            return None;
        }
        // One step from the first changed byte to the last: overlapping deletions are one by then.
        let steps = vec![difference(path, &file.now, &after)];
        let operation = Operation { label: label.into(), steps };
        self.make(&operation);
        self.done.push(operation.clone());
        self.undone.clear();
        Some(operation)
    }

    /// Makes the steps of an operation again, as one that can be undone. Whether all of them fit the texts.
    pub fn replay(&mut self, operation: Operation) -> bool {
        let fits = self.make(&operation);
        if fits {
            self.done.push(operation);
        }
        fits
    }

    /// Undoes the last operation; gives the one that does so.
    pub fn undo(&mut self) -> Option<Operation> {
        let operation = self.done.pop()?;
        let inverse = Operation {
            label: format!("undo {}", operation.label),
            steps: operation.steps.iter().rev().map(inverse).collect(),
        };
        let fits = self.make(&inverse);
        if fits {
            self.undone.push(operation);
        }
        fits.then_some(inverse)
    }

    /// Makes the operation again that was undone last.
    pub fn redo(&mut self) -> Option<Operation> {
        let operation = self.undone.pop()?;
        let fits = self.make(&operation);
        if fits {
            self.done.push(operation.clone());
        }
        fits.then_some(operation)
    }

    fn make(&mut self, operation: &Operation) -> bool {
        let fits = operation.steps.iter().all(|step| {
            let Some(file) = self.files.get_mut(&step.file) else { return false };
            let end = step.at + step.removed.len();
            let stands = file.now.get(step.at..end) == Some(step.removed.as_str());
            if stands {
                file.now.replace_range(step.at..end, &step.inserted);
            }
            stands
        });
        for step in &operation.steps {
            if let Some(file) = self.files.get_mut(&step.file) {
                file.understand(&step.file);
                self.graphs_revision += u64::from(!file.source);
            }
        }
        self.revision += 1;
        fits
    }

    /// Takes in that the file at `path` holds `theirs` on disk.
    pub fn changed_on_disk(&mut self, path: &Path, theirs: &str) -> Taken {
        let Some(file) = self.files.get_mut(path) else { return Taken::Same };
        if file.base == theirs {
            return Taken::Same;
        }
        let (taken, now) = if file.now == file.base || file.now == theirs {
            (Taken::Read, theirs.to_owned())
        } else {
            match merge(&file.base, &file.now, theirs) {
                Merged::Clean(text) => (Taken::Merged, text),
                Merged::Touching => return Taken::Conflict,
            }
        };
        theirs.clone_into(&mut file.base);
        self.become_text(path, &now, "take in what changed on disk");
        taken
    }

    /// Settles a conflict: with `keep`, what is here is what counts and will be written; else what is on disk.
    pub fn settle(&mut self, path: &Path, theirs: &str, keep: bool) {
        if let Some(file) = self.files.get_mut(path) {
            theirs.clone_into(&mut file.base);
            if !keep {
                self.become_text(path, theirs, "take what is on disk");
            }
        }
    }

    /// Replaces a whole text, as an operation that can be undone.
    fn become_text(&mut self, path: &Path, text: &str, label: &str) {
        let Some(file) = self.files.get(path) else { return };
        if file.now != text {
            let operation = Operation { label: label.to_owned(), steps: vec![difference(path, &file.now, text)] };
            self.make(&operation);
            self.done.push(operation);
            self.undone.clear();
        }
    }

    /// All that is unsaved as one operation on what is on disk.
    pub fn unsaved_operation(&self) -> Option<Operation> {
        let differing = self.files.iter().filter(|(_, text)| text.now != text.base);
        let steps: Vec<Step> = differing.map(|(path, text)| difference(path, &text.base, &text.now)).collect();
        (!steps.is_empty()).then(|| Operation { label: "all edits".to_owned(), steps })
    }

    /// The label of the operation that undo would undo.
    pub fn last(&self) -> Option<&str> {
        self.done.last().map(|operation| operation.label.as_str())
    }
}

fn inverse(step: &Step) -> Step {
    Step { removed: step.inserted.clone(), inserted: step.removed.clone(), ..step.clone() }
}

/// The one replacement that makes `after` of `before`.
fn difference(path: &Path, before: &str, after: &str) -> Step {
    let same = |(a, b): &(u8, u8)| a == b;
    let mut start = before.bytes().zip(after.bytes()).take_while(same).count();
    while !before.is_char_boundary(start) || !after.is_char_boundary(start) {
        start -= 1;
    }
    let most = before.len().min(after.len()) - start;
    let mut end = before.bytes().rev().zip(after.bytes().rev()).take(most).take_while(same).count();
    while !before.is_char_boundary(before.len() - end) || !after.is_char_boundary(after.len() - end) {
        end -= 1;
    }
    let span = Span { start, end: before.len() - end };
    Step {
        file: path.to_owned(),
        at: start,
        removed: before[span.start..span.end].to_owned(),
        inserted: after[start..after.len() - end].to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts() -> (Texts, PathBuf) {
        let path = PathBuf::from("graph.ron");
        let mut texts = Texts::default();
        texts.add(path.clone(), "one\ntwo\nthree\nfour\n".to_owned());
        (texts, path)
    }

    fn replace(texts: &mut Texts, path: &Path, from: &str, to: &str) {
        let start = texts.get(path).unwrap().now.find(from).unwrap();
        let change = Change { span: Span { start, end: start + from.len() }, text: to.to_owned() };
        texts.edit(format!("{from} to {to}"), path, &[change]).unwrap();
    }

    #[test]
    fn operations_are_undone_and_redone_in_their_order() {
        let (mut texts, path) = texts();
        replace(&mut texts, &path, "one", "1");
        replace(&mut texts, &path, "four", "vier – 4");
        assert!(texts.is_unsaved());
        assert_eq!(texts.undo().unwrap().label, "undo four to vier – 4");
        assert_eq!(texts.get(&path).unwrap().now, "1\ntwo\nthree\nfour\n");
        texts.redo().unwrap();
        assert_eq!(texts.get(&path).unwrap().now, "1\ntwo\nthree\nvier – 4\n");
        texts.undo().unwrap();
        texts.undo().unwrap();
        assert!(texts.undo().is_none() && !texts.is_unsaved());
        // A new operation ends what could be redone.
        replace(&mut texts, &path, "two", "2");
        assert!(texts.redo().is_none());
    }

    #[test]
    fn what_changed_on_disk_is_merged_or_asked_about() {
        let (mut texts, path) = texts();
        assert_eq!(texts.changed_on_disk(&path, "one\ntwo\nthree\nfive\n"), Taken::Read);
        replace(&mut texts, &path, "one", "1");
        assert_eq!(texts.changed_on_disk(&path, "one\ntwo\nthree\nsix\n"), Taken::Merged);
        assert_eq!(texts.get(&path).unwrap().now, "1\ntwo\nthree\nsix\n");
        assert_eq!(texts.changed_on_disk(&path, "uno\ntwo\nthree\nsix\n"), Taken::Conflict);
        assert_eq!(texts.get(&path).unwrap().now, "1\ntwo\nthree\nsix\n");
        texts.settle(&path, "uno\ntwo\nthree\nsix\n", true);
        assert!(texts.is_unsaved());
        assert_eq!(texts.changed_on_disk(&path, "uno\ntwo\nthree\nsix\n"), Taken::Same);
        // A merge can be undone like any operation.
        texts.undo().unwrap();
        assert_eq!(texts.get(&path).unwrap().now, "1\ntwo\nthree\nfive\n");
    }
}
