//! Keys while a line is typed, a palette is open, or a question is asked.

use super::{add, curves, edit_key, edit_value, find, help, journal, rename, wire};
use crate::model::line::Line;
use crate::model::{Ask, Effect, Overlay, State};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

/// Types a key into a line; whether it was one for it.
pub fn type_into(line: &mut Line, key: &KeyEvent) -> bool {
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    match key.code {
        KeyCode::Char('u') if control => line.clear(),
        KeyCode::Char('a') if control => line.home(),
        KeyCode::Char('e') if control => line.end(),
        KeyCode::Char(letter) if !control => line.put(letter),
        KeyCode::Backspace => line.back(),
        KeyCode::Delete => line.delete(),
        KeyCode::Left => line.left(),
        KeyCode::Right => line.right(),
        KeyCode::Home => line.home(),
        KeyCode::End => line.end(),
        _ => return false,
    }
    true
}

/// A key while a value is typed in the form.
pub fn in_form(state: &mut State, key: &KeyEvent) -> Vec<Effect> {
    match key.code {
        KeyCode::Enter => edit_value::done(state),
        KeyCode::Esc => {
            (state.form.editing, state.form.error) = (None, None);
            Vec::new()
        }
        _ => {
            if let Some(line) = &mut state.form.editing
                && type_into(line, key)
            {
                state.form.error = None;
            }
            Vec::new()
        }
    }
}

/// A key while something lies over everything.
pub fn in_overlay(state: &mut State, key: &KeyEvent) -> Vec<Effect> {
    let step = |at: usize, count: usize| match key.code {
        KeyCode::Down | KeyCode::Tab => (at + 1).min(count.saturating_sub(1)),
        KeyCode::Up | KeyCode::BackTab => at.saturating_sub(1),
        _ => 0,
    };
    match std::mem::take(&mut state.overlay) {
        Overlay::None => Vec::new(),
        Overlay::Help(top) => {
            help::scroll(state, top, key);
            Vec::new()
        }
        Overlay::Question(question) => journal::answer(state, question, key),
        _ if key.code == KeyCode::Esc => Vec::new(),
        Overlay::Palette { mut line, at, fit } => {
            let listed = add::listed(state, &line.text, fit.as_ref());
            if key.code == KeyCode::Enter {
                let kind = listed.get(at).map(|kind| kind.manual.name.clone());
                return kind.map(|kind| add::chosen(state, &kind, fit)).unwrap_or_default();
            }
            let at = step(at, listed.len());
            type_into(&mut line, key);
            state.overlay = Overlay::Palette { line, at, fit };
            Vec::new()
        }
        Overlay::Wiring { fit, mut line, choices, at } => {
            let listed = wire::listed(&choices, &line.text);
            if key.code == KeyCode::Enter {
                let choice = listed.get(at).map(|choice| (*choice).clone());
                state.overlay = Overlay::Wiring { fit: fit.clone(), line, choices, at };
                return choice.map(|choice| wire::chosen(state, &fit, &choice)).unwrap_or_default();
            }
            let at = step(at, listed.len());
            type_into(&mut line, key);
            state.overlay = Overlay::Wiring { fit, line, choices, at };
            Vec::new()
        }
        Overlay::Prompt { ask, mut line, mut error } => {
            if key.code == KeyCode::Enter {
                let typed = line.text.trim().to_owned();
                let done = match &ask {
                    Ask::Rename(from) => rename::done(state, from, &typed),
                    Ask::NewName(kind, fit) => add::done(state, kind, fit.as_ref(), &typed),
                    Ask::Find => find::done(state, &typed),
                    Ask::Channel => curves::channel_found(state, &typed),
                    Ask::Key => edit_key::typed(state, &typed),
                };
                return done.unwrap_or_else(|message| {
                    state.overlay = Overlay::Prompt { ask, line, error: Some(message) };
                    Vec::new()
                });
            }
            if type_into(&mut line, key) {
                error = None;
            }
            state.overlay = Overlay::Prompt { ask, line, error };
            Vec::new()
        }
    }
}
