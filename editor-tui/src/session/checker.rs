//! Checking on a thread of its own: whether the texts make a plan, and what a cook of it would do.

use super::Asked;
use crate::model::Message;
use graph_core::cook::{Engine, Event, Options};
use graph_core::document::Diagnostic;
use graph_core::plan::load_texts;
use graph_core::store::Store;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

type Texts = BTreeMap<PathBuf, String>;

/// Takes texts to be checked; of several that wait, only the last is.
pub struct Checker {
    sender: Sender<(u64, Texts)>,
}

impl Checker {
    /// Starts the thread.
    pub fn begin(asked: &Asked, root: &Path, store: &Arc<Store>, tell: &Sender<(Instant, Message)>) -> Self {
        let (sender, receiver) = channel::<(u64, Texts)>();
        let (asked, root, store, tell) = (asked.clone(), root.to_owned(), Arc::clone(store), tell.clone());
        std::thread::spawn(move || {
            while let Ok(mut next) = receiver.recv() {
                while let Ok(newer) = receiver.try_recv() {
                    next = newer;
                }
                let (revision, texts) = next;
                let checked = catch_unwind(AssertUnwindSafe(|| check(&asked, &root, &store, &texts)));
                let (mistakes, events) = checked.unwrap_or_else(|_| {
                    (vec![Diagnostic::new("check", "the check itself failed; please report this graph")], Vec::new())
                });
                if tell.send((Instant::now(), Message::Checked { revision, mistakes, events })).is_err() {
                    return;
                }
            }
        });
        Self { sender }
    }

    /// Asks for a check.
    pub fn check(&self, revision: u64, texts: Texts) {
        // The thread lives as long as someone listens to it.
        drop(self.sender.send((revision, texts)));
    }
}

/// The mistakes in the texts, or what a cook would do with each cell.
fn check(asked: &Asked, root: &Path, store: &Arc<Store>, texts: &Texts) -> (Vec<Diagnostic>, Vec<Event>) {
    let plan = match load_texts(root, &asked.overrides, texts.clone()) {
        Ok(plan) => plan,
        Err(mistakes) => return (mistakes.0, Vec::new()),
    };
    let events = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&events);
    let tell = Arc::new(move |event| noted.lock().unwrap_or_else(PoisonError::into_inner).push(event));
    let options = Options { dry: true, only: Vec::new(), ..asked.options.clone() };
    let cancel = Arc::new(AtomicBool::new(false));
    let engine = Engine::new(plan, &asked.overrides, Arc::clone(store), options, cancel, Some(tell));
    let planned = engine.and_then(|mut engine| {
        engine.hold(texts);
        engine.cook().map(drop)
    });
    let mistakes = planned.err().map(|problem| Diagnostic::new("plan", problem.to_string()));
    let events = std::mem::take(&mut *events.lock().unwrap_or_else(PoisonError::into_inner));
    (mistakes.into_iter().collect(), events)
}
