//! Any text as a graph: mistakes that can be shown, or a plan, never a crash; and an edit of a text that can be read leaves
//! one that can be read.
#![no_main]

use fuzz::kinds;
use graph_core::document::edit::{Draft, apply};
use graph_core::document::{render, to_json};
use graph_core::plan::load_texts;
use libfuzzer_sys::fuzz_target;
use std::collections::BTreeMap;
use std::path::Path;

fuzz_target!(init: kinds::link(), |text: &str| {
    let path = Path::new("graph.ron");
    // `nested.ron` is the same text, so that graphs that nest one another are reached too.
    let texts = ["graph.ron", "nested.ron"].map(|name| (name.into(), text.to_owned()));
    let mistakes = load_texts(path, &[], BTreeMap::from(texts)).err();
    if let Some(mistakes) = &mistakes {
        assert!(!render(mistakes, false, 80).is_empty());
        assert!(!to_json(mistakes).is_null());
    }
    let Ok(draft) = Draft::of(text) else { return };
    for edit in [
        draft.set_param("a", "number", "2"),
        draft.unset_param("a", "number"),
        draft.set_graph_param("p", "\"two\""),
        draft.add_node("fresh", "(kind: \"many\")"),
        draft.connect("a", "first", "b", false),
        draft.delete_node("a"),
        draft.rename_node("a", "fresh"),
    ] {
        let Ok(changes) = edit else { continue };
        let edited = apply(text, &changes);
        assert!(Draft::of(&edited).is_ok(), "{text:?} was edited into {edited:?}, which cannot be read");
    }
});
