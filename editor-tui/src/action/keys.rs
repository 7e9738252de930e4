//! The one way in: messages to actions.

use super::{ACTIONS, mouse, prompt, take};
use crate::model::keymap::Key;
use crate::model::{Effect, Focus, Message, Overlay, State};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// Takes a message: the state changes, and what it gives is to be done outside of it.
pub fn update(state: &mut State, message: Message) -> Vec<Effect> {
    let effects = updated(state, message);
    state.read_edits();
    effects
}

fn updated(state: &mut State, message: Message) -> Vec<Effect> {
    match message {
        Message::Key(key) if key.kind == KeyEventKind::Release => Vec::new(),
        Message::Key(key) => key_pressed(state, &key),
        Message::Mouse(event) => mouse::mouse(state, event),
        Message::Paste(text) => {
            let letters = text.chars().filter(|letter| !letter.is_control());
            letters
                .flat_map(|letter| {
                    let typing = state.form.editing.is_some() || state.overlay != Overlay::None;
                    let key = KeyEvent::new(KeyCode::Char(letter), KeyModifiers::NONE);
                    if typing { key_pressed(state, &key) } else { Vec::new() }
                })
                .collect()
        }
        other => take::take(state, other),
    }
}

fn key_pressed(state: &mut State, key: &KeyEvent) -> Vec<Effect> {
    if state.overlay != Overlay::None {
        return prompt::in_overlay(state, key);
    }
    if state.form.editing.is_some() {
        return prompt::in_form(state, key);
    }
    let place = match state.focus {
        Focus::Canvas => "canvas",
        Focus::Form => "form",
        Focus::Preview => "preview",
        Focus::Curves => "curves",
    };
    let keymap = std::sync::Arc::clone(&state.keymap);
    let Some(name) = keymap.action(place, Key::of(key)) else { return Vec::new() };
    state.note = None;
    let action = ACTIONS.iter().find(|action| action.name == name);
    action.map(|action| (action.run)(state)).unwrap_or_default()
}
