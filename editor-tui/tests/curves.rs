//! Curve work: a state before, keys, a state after, and what is drawn of it.
#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

mod common;

use common::{EDITS, GRAPH, press, screen, text, worked};
use editor_tui::action::update;
use editor_tui::model::{Effect, Focus, Message, State};
use graph_core::cook::Summary;
use std::path::PathBuf;

fn edits(state: &State) -> String {
    text(state, "edits.ron")
}

fn frame(state: &State) -> i64 {
    state.work.as_ref().unwrap().frame_number()
}

/// Ends the cook that an edit began, as if it had given the same curves.
fn cooked(state: &mut State) -> Vec<Effect> {
    let work = state.work.as_ref().unwrap();
    let (of, desk) = (work.of.clone(), work.desk.clone().unwrap());
    let revision = state.cooking.as_ref().unwrap().revision;
    update(state, Message::Desk { of, revision, desk: Ok(desk) });
    update(state, Message::CookEnded(Ok(Summary::default())))
}

#[test]
fn keys_change_the_file_in_their_own_bytes() {
    // What is pressed, and what then stands in place of the key that was there.
    let cases = [
        ("enter ctrl-u \"0.4\" enter", "[(frame: 101, value: 0.4)]", "jawOpen"),
        ("enter ctrl-u \"+0.1\" enter", "[(frame: 101, offset: 0.1)]", "jawOpen"),
        ("enter ctrl-u \"=-0.1\" enter", "[(frame: 101, value: -0.1)]", "jawOpen"),
        ("+", "[(frame: 101, value: 0.26)]", "jawOpen"),
        ("L - -", "[(frame: 111, value: 0.23)]", "jawOpen"),
        ("K w t", "[(frame: 101, value: 0.35, falloff_frames: 10, curve: linear)]", "jawOpen"),
        ("+ > > >", "[(frame: 104, value: 0.26)]", "jawOpen"),
        ("/ \"sm\" enter ] enter ctrl-u \"0.7\" enter", "[(frame: 110, value: 0.7)]", "smile"),
        ("j ] <", "[(frame: 109, value: 0.5)]", "smile"),
    ];
    for (keys, stands, channel) in cases {
        let mut state = worked((100, 30));
        let effects = press(&mut state, keys);
        let kept = EDITS.replace("[(frame: 110, value: 0.5)]", stands);
        let added = EDITS.replace("0.5)]}", &format!("0.5)], \"jawOpen\": {stands}}}"));
        assert_eq!(edits(&state), if channel == "smile" { kept } else { added }, "{keys}");
        let first = matches!(effects.as_slice(), [Effect::Journal(_), Effect::Work(_, _), ..]);
        assert!(first, "the edit is noted and what it touches is cooked: {keys}: {effects:?}");
        assert!(state.texts.is_unsaved() && text(&state, "graph.ron") == GRAPH);
    }
}

#[test]
fn a_key_is_deleted_and_comes_back_with_undo() {
    let mut state = worked((100, 30));
    press(&mut state, "j ] d");
    assert!(!edits(&state).contains("frame: 110") && edits(&state).contains("// the first"), "{}", edits(&state));
    press(&mut state, "u");
    assert_eq!(edits(&state), EDITS);
    assert!(!state.texts.is_unsaved());
    press(&mut state, "U");
    assert!(!edits(&state).contains("frame: 110"));
    press(&mut state, "d");
    assert!(state.note.clone().unwrap().text.contains("has no key on `smile` at frame 110"));
}

#[test]
fn edits_during_a_cook_are_cooked_when_it_is_over() {
    let mut state = worked((100, 30));
    press(&mut state, "+");
    let effects = press(&mut state, "+ +");
    assert!(effects.iter().all(|effect| matches!(effect, Effect::Journal(_))), "{effects:?}");
    assert!(screen(&state).contains("newer than the curves"));
    assert!(matches!(cooked(&mut state).as_slice(), [Effect::Work(_, _)]));
    assert!(cooked(&mut state).is_empty());
    assert!(edits(&state).contains("value: 0.28"));
    assert!(!screen(&state).contains("newer than the curves"));
}

#[test]
fn a_frame_is_an_anchor_and_none_again() {
    let mut state = worked((100, 30));
    press(&mut state, "l a");
    let stands = "anchors: [(frame: 102, weights: {\"jawOpen\": 0.25, \"smile\": 0.01})]";
    assert!(edits(&state).contains(stands), "{}", edits(&state));
    assert!(cooked(&mut state).is_empty() && screen(&state).contains("▲ this frame is an anchor"));
    press(&mut state, "a");
    assert_eq!(edits(&state), EDITS);
}

#[test]
fn keys_lead_to_keys_and_to_the_worst_frames() {
    for (keys, expected) in [
        ("n", 181),
        ("n n", 141),
        ("n n N", 181),
        ("e n", 121),
        ("end", 200),
        ("L h", 110),
        ("end home l", 102),
        ("j ]", 110),
        ("j end [", 110),
        ("] ]", 101),
    ] {
        let mut state = worked((100, 30));
        press(&mut state, keys);
        assert_eq!(frame(&state), expected, "{keys}");
    }
    let mut state = worked((100, 30));
    press(&mut state, "n");
    assert!(state.note.clone().unwrap().text.contains("2.00 mm off (all) at frame 181"), "{:?}", state.note);
}

#[test]
fn what_stands_in_the_way_is_told() {
    let mut state = worked((100, 30));
    press(&mut state, "<");
    assert!(state.note.clone().unwrap().text.contains("no key in this frame"));
    press(&mut state, "enter ctrl-u \"wide\" enter");
    assert!(screen(&state).contains("`wide` is no weight"));
    press(&mut state, "esc + <");
    assert!(state.note.clone().unwrap().text.contains("the take ends here"));
    // A file that is no longer one of edits is told, and not written over.
    let mut state = worked((100, 30));
    update(&mut state, Message::OnDisk { file: PathBuf::from("edits.ron"), text: Ok("(takes: {".to_owned()) });
    press(&mut state, "+");
    assert!(state.note.clone().unwrap().bad && edits(&state) == "(takes: {");
}

#[test]
fn edits_on_disk_are_merged_or_asked_about() {
    let mut state = worked((100, 30));
    press(&mut state, "j ] +");
    let theirs = EDITS.replace("// By hand.", "// By two hands.");
    let effects = update(&mut state, Message::OnDisk { file: PathBuf::from("edits.ron"), text: Ok(theirs) });
    assert!(effects.contains(&Effect::Check) && edits(&state).contains("two hands") && edits(&state).contains("0.51"));
    let touching = EDITS.replace("0.5)", "0.9)");
    update(&mut state, Message::OnDisk { file: PathBuf::from("edits.ron"), text: Ok(touching.clone()) });
    assert!(screen(&state).contains("keep mine"));
    press(&mut state, "t");
    assert_eq!(edits(&state), touching);
}

#[test]
fn leaving_shows_the_graph_and_looks_at_it_again() {
    let mut state = worked((100, 30));
    assert_eq!(press(&mut state, "esc"), [Effect::Check]);
    assert!(state.work.is_none() && state.focus == Focus::Canvas);
    assert!(screen(&state).contains("sample_actor"));
}

#[test]
fn the_chart_shows_keys_errors_and_what_is_wrong() {
    let mut state = worked((80, 24));
    press(&mut state, "j ]");
    let shown = screen(&state);
    for part in [
        "take_00  1 keys, 0 anchors in edits.ron",
        "›smile",
        "◆",
        "smile 0.090 (solved 0.090)  frame 110",
        "mm off by region, at most 2.00",
        "›all",
        " lips",
    ] {
        assert!(shown.contains(part), "{part} is not on\n{shown}");
    }
    press(&mut state, "?");
    let mut help = screen(&state);
    press(&mut state, &"j ".repeat(40));
    help += &screen(&state);
    assert!(
        help.contains("type a key's value") && help.contains("anchor this frame") && !help.contains("rename"),
        "{help}"
    );
    for size in [(80, 24), (40, 12), (20, 6), (200, 60)] {
        for keys in ["", "z", "z z", "?", "enter", "/", "n", "e e"] {
            let mut state = worked(size);
            press(&mut state, keys);
            assert_eq!(screen(&state).lines().count(), usize::from(size.1), "{size:?} {keys}");
        }
    }
}
