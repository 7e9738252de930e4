//! Kinds that come and go: plugins are looked for on a thread of its own, and again whenever a file or folder that they came from
//! looks different. Compiling one takes seconds the first time, and never delays a key.

use crate::model::Message;
use crate::model::catalogue::Catalogue;
use graph_core::files::Signature;
use graph_core::node::{Grounds, Kinds, folders_in};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

/// How often files are looked at.
const LOOK: Duration = Duration::from_millis(700);

/// Looks for the kinds of the graph at `root` until no one listens.
pub fn follow(root: &Path, tell: &Sender<(Instant, Message)>) {
    let (root, tell) = (root.to_owned(), tell.clone());
    std::thread::spawn(move || {
        let mut known = Grounds::default();
        loop {
            let found = catch_unwind(AssertUnwindSafe(|| {
                let kinds = Kinds::of_graph(&root, &|name| std::env::var(name).ok());
                (Catalogue::of(&kinds), kinds.grounds())
            }));
            // A plugin that cannot be read says so when the graph is checked.
            let Ok((catalogue, grounds)) = found else { return };
            let looks = looks(&grounds);
            if grounds.files != known.files {
                known = grounds.clone();
                if tell.send((Instant::now(), Message::Kinds(Arc::new(catalogue)))).is_err() {
                    return;
                }
            }
            while looks == self::looks(&grounds) {
                std::thread::sleep(LOOK);
            }
        }
    });
}

/// How the files and folders look now.
fn looks(grounds: &Grounds) -> (Vec<Option<Signature>>, Vec<Vec<String>>) {
    let files = grounds.files.keys().map(|file| Signature::of(file).ok()).collect();
    (files, grounds.folders.keys().map(|folder| folders_in(folder)).collect())
}
