//! An editor without a terminal: a state over texts, keys by their names, the screen as text.
#![allow(
    clippy::unwrap_used,
    dead_code,
    reason = "a failing unwrap is a failing test; not every test uses all of this"
)]

use editor_tui::action::{names, update};
use editor_tui::model::catalogue::Catalogue;
use editor_tui::model::curves::Desk;
use editor_tui::model::keymap::Keymap;
use editor_tui::model::texts::Texts;
use editor_tui::model::{Effect, Message, State};
use editor_tui::view::{Theme, draw};
use face_math::data::Curves;
use graph_core::cook::Summary;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use std::path::PathBuf;
use std::sync::Arc;
use wire::FrameAxis;

/// A graph with a comment at every turn.
pub const GRAPH: &str = r#"#![enable(implicit_some)]
(
    grimace: 1,
    params: { "out": "out" },
    nodes: {
        // The head.
        "actor": (kind: "sample_actor", with: (takes: 2, frames: /* short */ 48)),
        "rig":   (kind: "skin_jaw", in: {"rig": "actor.rig"}), // its jaw
        "calm":  (kind: "smooth_curves", in: {"curves": "actor.truth"}),
        "inner": (graph: "inner.ron", in: {"curves": "calm"}),
        "save":  (kind: "save_curves", in: {"curves": "inner.slow"}, with: (path: "${out}/{take}.csv")),
    },
)
"#;

/// What it nests.
pub const INNER: &str = r#"(
    grimace: 1,
    params: { "cutoff": 4.0 },
    inputs: { "curves": "Curves" },
    outputs: { "slow": "slow" },
    nodes: {
        "slow": (kind: "smooth_curves", in: {"curves": "curves"}, with: (cutoff_hz: "${cutoff}")),
    },
)
"#;

/// The editor over these two, of a usual size.
pub fn editor() -> State {
    over(&[("graph.ron", GRAPH), ("inner.ron", INNER)], (120, 40))
}

/// The editor over these files, the first the root.
pub fn over(files: &[(&str, &str)], size: (u16, u16)) -> State {
    let mut texts = Texts::default();
    for (name, text) in files {
        texts.add(PathBuf::from(name), (*text).to_owned());
    }
    let keymap = Keymap::read(None, &names()).unwrap();
    let root = PathBuf::from(files[0].0);
    State::new(&root, texts, Arc::new(Catalogue::of_program()), Arc::new(keymap), size)
}

/// Presses keys, written as in `j j enter "9.5" enter`: names, letters, or text in quotes.
pub fn press(state: &mut State, keys: &str) -> Vec<Effect> {
    let mut effects = Vec::new();
    let mut rest = keys.trim();
    while !rest.is_empty() {
        if let Some(text) = rest.strip_prefix('"') {
            let end = text.find('"').unwrap();
            for letter in text[..end].chars() {
                effects.extend(key(state, KeyCode::Char(letter), KeyModifiers::NONE));
            }
            rest = text[end + 1..].trim_start();
            continue;
        }
        let (name, after) = rest.split_once(' ').unwrap_or((rest, ""));
        rest = after.trim_start();
        let (modifiers, plain) = match name.strip_prefix("ctrl-") {
            Some(plain) => (KeyModifiers::CONTROL, plain),
            None => (KeyModifiers::NONE, name),
        };
        let code = match plain {
            "enter" => KeyCode::Enter,
            "esc" => KeyCode::Esc,
            "tab" => KeyCode::Tab,
            "space" => KeyCode::Char(' '),
            "down" => KeyCode::Down,
            "home" => KeyCode::Home,
            "end" => KeyCode::End,
            one => KeyCode::Char(one.chars().next().unwrap()),
        };
        effects.extend(key(state, code, modifiers));
    }
    effects
}

fn key(state: &mut State, code: KeyCode, modifiers: KeyModifiers) -> Vec<Effect> {
    update(state, Message::Key(KeyEvent::new(code, modifiers)))
}

/// The text of a file as it is being edited.
pub fn text(state: &State, file: &str) -> String {
    state.texts.get(&PathBuf::from(file)).unwrap().now.clone()
}

/// The screen, a line a row.
pub fn screen(state: &State) -> String {
    let mut terminal = Terminal::new(TestBackend::new(state.size.0, state.size.1)).unwrap();
    terminal.draw(|frame| draw(state, Theme::default(), frame)).unwrap();
    let buffer = terminal.backend().buffer().clone();
    let rows = (0..buffer.area.height).map(|y| {
        let row: String = (0..buffer.area.width).map(|x| buffer[(x, y)].symbol()).collect();
        row.trim_end().to_owned()
    });
    rows.collect::<Vec<_>>().join("\n")
}

/// A file of edits with one key of the take that [`worked`] works on.
pub const EDITS: &str = r#"// By hand.
(
    takes: {
        "take_00": (keys: {"smile": [(frame: 110, value: 0.5)]}), // the first
    },
)
"#;

/// An editor at work on two channels over frames 101 to 200, with errors of two regions.
pub fn worked(size: (u16, u16)) -> State {
    let mut state = over(&[("graph.ron", GRAPH), ("inner.ron", INNER)], size);
    state.select("calm");
    let effects = press(&mut state, "v");
    let [Effect::Work(cell, port)] = effects.as_slice() else { panic!("{effects:?}") };
    assert_eq!((cell.as_str(), port.as_str()), ("calm", "curves"));
    let axis = FrameAxis { first: 101, count: 100, rate_hz: 60.0 };
    let curves = |channels: &[&str], value: &dyn Fn(usize, usize) -> f32| {
        let names: Vec<String> = channels.iter().map(|name| (*name).to_owned()).collect();
        let all = (0..100).flat_map(|frame| (0..names.len()).map(move |channel| (frame, channel)));
        Arc::new(Curves::new(axis, names.clone(), all.map(|(frame, channel)| value(frame, channel)).collect()).unwrap())
    };
    let solved =
        curves(&["jawOpen", "smile"], &|frame, channel| if channel == 0 { 0.25 } else { frame as f32 / 100.0 });
    let errors = curves(&["rms_mm", "worst_mm", "lips_mm"], &|frame, channel| match (frame, channel) {
        (80, 0) | (20, 2) => 2.0,
        (40, _) => 1.0,
        _ => 0.1,
    });
    let desk = Desk {
        cell: "calm".to_owned(),
        take: "take_00".to_owned(),
        file: PathBuf::from("edits.ron"),
        edited: Arc::clone(&solved),
        solved,
        errors: Some(errors),
        anchored: true,
    };
    let revision = state.texts.revision;
    let of = ("calm".to_owned(), "curves".to_owned());
    let effects = update(&mut state, Message::Desk { of, revision, desk: Ok(Arc::new(desk)) });
    assert_eq!(effects, [Effect::Read(PathBuf::from("edits.ron"))]);
    update(&mut state, Message::OnDisk { file: PathBuf::from("edits.ron"), text: Ok(EDITS.to_owned()) });
    let effects = update(&mut state, Message::CookEnded(Ok(Summary::default())));
    assert!(effects.is_empty(), "what shows is up to date: {effects:?}");
    state
}
