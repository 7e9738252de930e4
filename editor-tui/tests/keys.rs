//! What keys do: a state before, keys, a state after.
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

mod common;

use common::{GRAPH, INNER, editor, press, text};
use editor_tui::action::update;
use editor_tui::model::{Effect, Focus, Message, Overlay};
use std::path::PathBuf;

fn selected(state: &editor_tui::model::State) -> &str {
    state.level().selected.as_deref().unwrap_or("")
}

#[test]
fn the_selection_follows_wires() {
    for (from, keys, to) in [
        ("actor", "l", "calm"),
        ("save", "h", "inner"),
        ("inner", "h", "calm"),
        ("rig", "h", "actor"),
        ("inner", "l", "save"),
    ] {
        let mut state = editor();
        state.select(from);
        press(&mut state, keys);
        let (went, expected) = (selected(&state), to);
        assert!(went == expected || (from == "actor" && went == "rig"), "{from} {keys}: {went}, not {expected}");
    }
}

#[test]
fn a_value_is_edited_in_its_own_bytes() {
    let mut state = editor();
    state.select("actor");
    let at = state.fields().iter().position(|field| field.name == "frames").unwrap();
    let effects = press(&mut state, &format!("e {} enter ctrl-u \"96\" enter", "j ".repeat(at)));
    assert_eq!(text(&state, "graph.ron"), GRAPH.replace("*/ 48", "*/ 96"));
    assert!(matches!(effects.as_slice(), [Effect::Journal(_), Effect::Check]), "{effects:?}");
    // What is no value is told, and nothing changes.
    press(&mut state, "enter ctrl-u \"9 6\" enter");
    assert!(state.form.error.is_some() && text(&state, "graph.ron").contains("*/ 96"));
    press(&mut state, "esc esc u");
    assert_eq!(text(&state, "graph.ron"), GRAPH);
    press(&mut state, "U");
    assert_eq!(text(&state, "graph.ron"), GRAPH.replace("*/ 48", "*/ 96"));
}

#[test]
fn nested_graphs_open_in_place_and_undo_reaches_them() {
    let mut state = editor();
    state.select("inner");
    press(&mut state, "enter");
    assert_eq!((state.trail.len(), state.level().prefix.as_str()), (2, "inner/"));
    state.select("slow");
    press(&mut state, "n ctrl-u \"calmer\" enter");
    assert!(text(&state, "inner.ron").contains("\"slow\": \"calmer\"") && selected(&state) == "calmer");
    press(&mut state, "esc");
    assert_eq!(state.trail.len(), 1);
    state.select("calm");
    press(&mut state, "d");
    assert!(!text(&state, "graph.ron").contains("\"calm\""));
    press(&mut state, "u u");
    assert_eq!((text(&state, "graph.ron"), text(&state, "inner.ron")), (GRAPH.to_owned(), INNER.to_owned()));
    assert!(!state.texts.is_unsaved());
}

#[test]
fn nodes_are_added_from_the_palette_and_wired() {
    let mut state = editor();
    press(&mut state, "a \"gf\" enter enter");
    assert!(text(&state, "graph.ron").contains("\"graph_features\": (kind: \"graph_features\"),\n    },\n)"));
    // From a port, the palette holds what fits, and wires it.
    state.select("rig");
    press(&mut state, ". . a \"attm\" enter enter");
    assert!(
        text(&state, "graph.ron").contains("\"attach_markers\": (kind: \"attach_markers\", in: {\"rig\": \"rig\"})")
    );
    press(&mut state, "u u");
    assert_eq!(text(&state, "graph.ron"), GRAPH);
}

#[test]
fn wires_that_cannot_be_are_refused_with_the_reason() {
    let mut state = editor();
    state.select("calm");
    press(&mut state, ". w \"rig.rig\" enter");
    let note = state.note.clone().unwrap();
    assert!(note.bad && note.text.contains("gives Rig, and `curves` takes Curves"), "{}", note.text);
    press(&mut state, "ctrl-u \"inner.slow\" enter");
    assert!(state.note.clone().unwrap().text.contains("that would be a circle"));
    press(&mut state, "ctrl-u \"actor.rom\" enter");
    assert_eq!(text(&state, "graph.ron"), GRAPH.replace("\"actor.truth\"", "\"actor.rom\""));
    press(&mut state, "W");
    assert!(text(&state, "graph.ron").contains("\"calm\":  (kind: \"smooth_curves\"),"));
}

#[test]
fn files_that_change_on_disk_are_merged_or_asked_about() {
    let mut state = editor();
    state.select("calm");
    press(&mut state, "n ctrl-u \"quiet\" enter");
    let theirs = GRAPH.replace("// The head.", "// The actor's head.");
    update(&mut state, Message::OnDisk { file: PathBuf::from("graph.ron"), text: Ok(theirs.clone()) });
    let merged = text(&state, "graph.ron");
    assert!(merged.contains("The actor's head") && merged.contains("\"quiet\""));
    let touching = theirs.replace("\"calm\":  (kind", "\"calmer\":  (kind");
    update(&mut state, Message::OnDisk { file: PathBuf::from("graph.ron"), text: Ok(touching.clone()) });
    assert!(matches!(state.overlay, Overlay::Question(_)));
    assert_eq!(text(&state, "graph.ron"), merged);
    press(&mut state, "t");
    assert_eq!(text(&state, "graph.ron"), touching);
    press(&mut state, "u");
    assert_eq!(text(&state, "graph.ron"), merged);
}

#[test]
fn leaving_asks_where_something_is_unsaved() {
    let mut state = editor();
    assert_eq!(press(&mut state, "q"), [Effect::DropJournal, Effect::Quit]);
    press(&mut state, "d q");
    assert!(matches!(state.overlay, Overlay::Question(_)));
    assert_eq!(press(&mut state, "s"), [Effect::Save, Effect::DropJournal, Effect::Quit]);
}

#[test]
fn a_broken_text_shows_and_stays() {
    let mut state = common::over(&[("graph.ron", "( grimace: 1, nodes: { \"a\": (kind: ")], (80, 24));
    press(&mut state, "j l a \"gf\" enter enter esc d n w p r tab ? esc");
    assert_eq!(text(&state, "graph.ron"), "( grimace: 1, nodes: { \"a\": (kind: ");
    common::screen(&state);
    assert_eq!(state.focus, Focus::Form);
}
