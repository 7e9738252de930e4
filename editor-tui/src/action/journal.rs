//! Questions: leaving with unsaved edits, files that changed on disk, edits of an editor that was not closed.

use super::{changed, curves, unread};
use crate::model::merge::{Merged, merge};
use crate::model::texts::{Operation, Texts};
use crate::model::{Effect, Overlay, Question, State};
use ratatui::crossterm::event::{KeyCode, KeyEvent};
use std::path::PathBuf;

/// Takes the answer to a question; another key asks again.
pub fn answer(state: &mut State, question: Question, key: &KeyEvent) -> Vec<Effect> {
    let KeyCode::Char(letter) = key.code else {
        let away = key.code == KeyCode::Esc && question == Question::Quit;
        state.overlay = if away { Overlay::None } else { Overlay::Question(question) };
        return Vec::new();
    };
    match (&question, letter) {
        (Question::Quit, 's') => return vec![Effect::Save, Effect::DropJournal, Effect::Quit],
        (Question::Quit, 'd') => return vec![Effect::DropJournal, Effect::Quit],
        (Question::Quit, 'c' | 'q') => return Vec::new(),
        (Question::Conflict { file, theirs }, 'm' | 't') => {
            state.texts.settle(file, theirs, letter == 'm');
            state.say(if letter == 'm' { "kept what is here; s writes it" } else { "took what is on disk; u undoes" });
            state.refresh();
            let mut effects = unread(state);
            effects.extend(curves::refresh(state));
            effects.push(Effect::Check);
            return effects;
        }
        (Question::Journal { operations, bases }, 'r') => return restore(state, operations.clone(), bases),
        (Question::Journal { .. }, 'd') => return vec![Effect::DropJournal],
        _ => {}
    }
    state.overlay = Overlay::Question(question);
    Vec::new()
}

/// Brings the edits back: as they were where the files are as they were, else merged with what the files are now.
fn restore(state: &mut State, operations: Vec<Operation>, bases: &[(PathBuf, String)]) -> Vec<Effect> {
    let count = operations.len();
    let mut effects = Vec::new();
    let unchanged = bases.iter().all(|(file, base)| state.texts.get(file).is_some_and(|text| text.now == *base));
    if unchanged {
        let mut last = None;
        for operation in operations {
            state.texts.replay(operation.clone());
            last = Some(operation);
        }
        if last.is_some() {
            state.refresh();
            effects.push(Effect::Check);
            effects.extend(unread(state));
        }
        state.say(format!("brought back {count} edits; s saves, u undoes"));
        return effects;
    }
    let mut then = Texts::default();
    for (file, base) in bases {
        then.add(file.clone(), base.clone());
    }
    for operation in operations {
        then.replay(operation);
    }
    for (file, base) in bases {
        let (Some(now), Some(edited)) = (state.texts.get(file).map(|text| text.now.clone()), then.get(file)) else {
            continue;
        };
        match merge(base, &edited.now, &now) {
            Merged::Clean(text) => {
                let span = graph_core::document::Span { start: 0, end: now.len() };
                let change = graph_core::document::edit::Change { span, text };
                let operation = state.texts.edit("bring back edits", file, &[change]);
                effects.extend(changed(state, operation));
            }
            Merged::Touching => {
                state.complain(format!("{} changed where it was edited: those edits are lost", file.display()));
                return effects;
            }
        }
    }
    state.say(format!("brought back {count} edits beside what changed on disk"));
    effects
}
