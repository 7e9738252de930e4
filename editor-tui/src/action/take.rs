//! What comes from outside: checks, cooks, values, files.

use super::{curves, peek, unread};
use crate::model::catalogue::Catalogue;
use crate::model::curves::{Desk, FRAMES_A_BEAT};
use crate::model::texts::Taken;
use crate::model::{Cooking, Effect, Message, Overlay, Question, State};
use graph_core::cook::{Event, Summary};
use std::path::Path;
use std::sync::Arc;

/// Takes a message that is no key.
pub fn take(state: &mut State, message: Message) -> Vec<Effect> {
    match message {
        Message::Checked { revision, mistakes, events } => {
            if revision >= state.checked {
                state.checked = revision;
                state.mistakes = Arc::new(mistakes);
                if !events.is_empty() && state.cooking.is_none() {
                    state.statuses.begin();
                    for event in &events {
                        state.statuses.take(event);
                    }
                }
            }
            Vec::new()
        }
        Message::CookBegan => {
            state.cooking.get_or_insert_default();
            Vec::new()
        }
        Message::Cook(event) => {
            cook(state, &event);
            Vec::new()
        }
        Message::CookEnded(summary) => {
            let cooked = state.cooking.take().map(|cooking| cooking.revision);
            state.statuses.stop();
            ended(state, summary);
            state.preview.forget();
            if let Some(work) = &state.work {
                // What was edited meanwhile is cooked now.
                let stale = work.asked_of != Some(state.texts.revision);
                return if stale { curves::refresh(state) } else { Vec::new() };
            }
            let mut effects = peek(state);
            if cooked != Some(state.texts.revision) {
                effects.push(Effect::Check);
            }
            effects
        }
        Message::Desk { of, revision, desk } => desk_made(state, &of, revision, desk),
        Message::Peeked { of, value } => {
            state.preview.shown(&of, value);
            Vec::new()
        }
        Message::OnDisk { file, text } => on_disk(state, &file, text),
        Message::Kinds(catalogue) => kinds(state, catalogue),
        Message::Saved(Ok(files)) => {
            for (file, text) in &files {
                state.texts.saved(file, text);
            }
            let names: Vec<_> = files.iter().map(|(file, _)| file.display().to_string()).collect();
            state.say(format!("saved {}", names.join(", ")));
            Vec::new()
        }
        Message::Saved(Err(problem)) => {
            state.complain(problem);
            Vec::new()
        }
        Message::JournalFound { operations, bases, sources } => {
            for (file, text) in sources {
                state.texts.add_source(file, text);
            }
            state.overlay = Overlay::Question(Question::Journal { operations, bases });
            Vec::new()
        }
        Message::Beat => {
            state.beat += 1;
            if state.preview.playing {
                state.preview.scrub(1);
            }
            if let Some(work) = state.work.as_mut().filter(|work| work.playing) {
                work.scrub(FRAMES_A_BEAT);
            }
            Vec::new()
        }
        Message::Size(columns, rows) => {
            state.size = (columns, rows);
            state.show_selected();
            Vec::new()
        }
        Message::Key(_) | Message::Mouse(_) | Message::Paste(_) => Vec::new(),
    }
}

fn cook(state: &mut State, event: &Event) {
    let cooking = state.cooking.get_or_insert_with(Cooking::default);
    match event {
        Event::Planned { cells } => cooking.cells = *cells,
        Event::Cooked { .. } | Event::Cached { .. } | Event::Skipped { .. } => cooking.done += 1,
        Event::Failed { node, error, .. } => {
            cooking.done += 1;
            if let Some(work) = &mut state.work {
                work.problem = Some(format!("{node}: {error}"));
            }
        }
        Event::Notice { about, message } => state.complain(format!("{about}: {message}")),
        _ => {}
    }
    state.statuses.take(event);
}

fn desk_made(state: &mut State, of: &(String, String), revision: u64, desk: Result<Arc<Desk>, String>) -> Vec<Effect> {
    if let Some(work) = state.work.as_mut().filter(|work| work.of == *of) {
        work.shown(desk, revision);
    }
    curves::unread(state)
}

fn ended(state: &mut State, summary: Result<Summary, String>) {
    match summary {
        Err(problem) => state.complain(problem),
        Ok(summary) => {
            let mut text = format!("{} cooked, {} up to date", summary.cooked, summary.cached);
            if summary.failed > 0 {
                text = format!("{} failed, {} skipped, {text}", summary.failed, summary.skipped);
            }
            if summary.cancelled {
                text = format!("cancelled: {text}");
            }
            let text = format!("{text} in {:.1} s", summary.seconds);
            if summary.failed > 0 { state.complain(text) } else { state.say(text) }
        }
    }
}

/// Plugins came, changed or went: boards have other ports, and what was cooked by the old ones is stale.
fn kinds(state: &mut State, catalogue: Arc<Catalogue>) -> Vec<Effect> {
    let count = catalogue.brought().count();
    state.catalogue = catalogue;
    state.refresh();
    state.preview.forget();
    state.say(format!("plugins: {count} {}", if count == 1 { "kind" } else { "kinds" }));
    let mut effects = vec![Effect::Forget, Effect::Check];
    effects.extend(if state.work.is_some() { curves::refresh(state) } else { peek(state) });
    effects
}

fn on_disk(state: &mut State, file: &Path, text: Result<String, String>) -> Vec<Effect> {
    let text = match text {
        Ok(text) => text,
        Err(problem) => {
            state.complain(problem);
            return Vec::new();
        }
    };
    if state.texts.get(file).is_none() {
        let desk = state.work.as_ref().and_then(|work| work.desk.as_ref());
        if desk.is_some_and(|desk| desk.file == file) {
            state.texts.add_source(file.to_owned(), text);
            // The desk was made of what is on disk.
            if let Some(work) = &mut state.work {
                (work.made_of, work.asked_of) = (state.texts.revision, Some(state.texts.revision));
            }
            return Vec::new();
        }
        state.texts.add(file.to_owned(), text);
        state.refresh();
        let mut effects = unread(state);
        effects.push(Effect::Check);
        return effects;
    }
    let name = file.display();
    match state.texts.changed_on_disk(file, &text) {
        Taken::Same => return Vec::new(),
        Taken::Read => state.say(format!("{name} changed on disk and was read again")),
        Taken::Merged => state.say(format!("{name} changed on disk; its changes and yours stand together now")),
        Taken::Conflict => {
            state.overlay = Overlay::Question(Question::Conflict { file: file.to_owned(), theirs: text });
            return Vec::new();
        }
    }
    state.refresh();
    state.select_first();
    let mut effects = unread(state);
    effects.extend(curves::refresh(state));
    effects.push(Effect::Check);
    effects
}
