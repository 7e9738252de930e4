//! What edits leave alone: everything but what they are about.

use super::{Draft, EditFault, apply};
use proptest::prelude::*;

const TEXT: &str = r#"#![enable(implicit_some)]
// A show.
(
    grimace: 1,
    params: { "out": "out" }, // knobs
    outputs: { "calm": "calm" },
    nodes: {
        "actor":  (kind: "sample_actor", with: (takes: 2)), // the head
        /* calm */
        "calm":   (kind: "smooth_curves", in: {"curves": "actor.truth"}, with: (cutoff_hz: /* low */ 6.0, order: 2)),
        "all":    (
            kind: "join",
            in: {"curves": ["calm", "actor.rom"]},
        )
    },
)
"#;

fn edited(edit: impl Fn(&Draft<'_>) -> Result<Vec<super::Change>, EditFault>) -> String {
    let draft = Draft::of(TEXT).unwrap();
    let text = apply(TEXT, &edit(&draft).unwrap());
    Draft::of(&text).unwrap_or_else(|fault| panic!("{fault}:\n{text}"));
    text
}

#[test]
fn values_are_replaced_where_they_stand() {
    let text = edited(|draft| draft.set_param("calm", "cutoff_hz", "9.5"));
    assert_eq!(text, TEXT.replace("6.0", "9.5"));
    let text = edited(|draft| draft.set_param("actor", "frames", "24"));
    assert_eq!(text, TEXT.replace("(takes: 2)", "(takes: 2, frames: 24)"));
    let text = edited(|draft| draft.set_param("all", "strict", "true"));
    let added = "            in: {\"curves\": [\"calm\", \"actor.rom\"]},\n            with: (strict: true),\n";
    assert!(text.contains(added), "{text}");
    let text = edited(|draft| draft.set_graph_param("takes", "3"));
    assert_eq!(text, TEXT.replace("\"out\": \"out\" }", "\"out\": \"out\", \"takes\": 3 }"));
    let text = edited(|draft| draft.unset_param("calm", "cutoff_hz"));
    assert_eq!(text, TEXT.replace("cutoff_hz: /* low */ 6.0, ", ""));
    let text = edited(|draft| draft.unset_param("actor", "takes"));
    assert_eq!(text, TEXT.replace(", with: (takes: 2)", ""));
    let draft = Draft::of(TEXT).unwrap();
    assert!(matches!(draft.set_param("calm", "order", "2 3"), Err(EditFault::BadValue(_))));
    assert!(matches!(draft.set_param("clam", "order", "2"), Err(EditFault::NoNode(_))));
}

#[test]
fn nodes_come_after_the_last_in_its_layout() {
    let text = edited(|draft| draft.add_node("rig", "(kind: \"skin_jaw\")"));
    assert!(text.contains("        ),\n        \"rig\":    (kind: \"skin_jaw\"),\n    },\n"), "{text}");
    let draft = Draft::of(TEXT).unwrap();
    assert_eq!(draft.add_node("calm", "()"), Err(EditFault::Taken("calm".into())));
    assert_eq!(draft.add_node("a.b", "()"), Err(EditFault::BadName("a.b".into())));
    let empty = "( grimace: 1, nodes: {} )";
    let changes = Draft::of(empty).unwrap().add_node("a", "(kind: \"b\")").unwrap();
    assert_eq!(apply(empty, &changes), "( grimace: 1, nodes: {\"a\": (kind: \"b\")} )");
}

#[test]
fn wires_are_made_and_undone() {
    let text = edited(|draft| draft.connect("calm", "curves", "actor.rom", false));
    assert_eq!(text, TEXT.replace("\"curves\": \"actor.truth\"", "\"curves\": \"actor.rom\""));
    let text = edited(|draft| draft.connect("all", "curves", "x", true));
    assert_eq!(text, TEXT.replace("\"actor.rom\"]", "\"actor.rom\", \"x\"]"));
    let text = edited(|draft| draft.connect("actor", "rig", "calm", false));
    let wired = "(kind: \"sample_actor\", in: {\"rig\": \"calm\"}, with";
    assert_eq!(text, TEXT.replace("(kind: \"sample_actor\", with", wired));
    let text = edited(|draft| draft.disconnect("all", "curves", Some("calm")));
    assert_eq!(text, TEXT.replace("[\"calm\", \"actor.rom\"]", "[\"actor.rom\"]"));
    let text = edited(|draft| draft.disconnect("calm", "curves", None));
    assert_eq!(text, TEXT.replace("in: {\"curves\": \"actor.truth\"}, ", ""));
}

#[test]
fn leaving_and_renamed_nodes_take_their_wires_along() {
    let text = edited(|draft| draft.rename_node("calm", "quiet"));
    let expected = TEXT.replace("\"calm\":   (", "\"quiet\":   (").replace("[\"calm\"", "[\"quiet\"");
    assert_eq!(text, expected.replace("\"calm\": \"calm\"", "\"calm\": \"quiet\""));
    let text = edited(|draft| draft.delete_node("calm"));
    assert!(!text.contains("smooth_curves") && text.contains("[\"actor.rom\"]") && text.contains("/* calm */"));
    let text = edited(|draft| draft.delete_node("actor"));
    assert!(!text.contains("actor") && !text.contains("the head"), "{text}");
}

#[test]
fn broken_texts_are_not_touched() {
    assert!(matches!(Draft::of("( nodes: {"), Err(EditFault::Broken { line: 1, .. })));
}

proptest! {
    /// Whatever stands around a value, setting it changes its bytes and no other.
    #[test]
    fn every_other_byte_stays(
        around in prop::collection::vec("[ \t\n]{0,3}(//[ -~é]{0,8}\n|/\\*[ a-zé]{0,8}\\*/|)[ \n]{0,2}", 6),
        old in prop_oneof![Just("1"), Just("[1, 2]"), Just("\"a\\\"b)\""), Just("(a: 1)"), Just("r#\"x\"y\"#")],
        new in prop_oneof![Just("2.5"), Just("\"new\""), Just("{ \"k\": 1 }")],
    ) {
        let [a, b, c, d, e, f] = std::array::from_fn(|at| around[at].as_str());
        let head = format!("({a}nodes: {{{b}\"n\":{c}(kind: \"k\", with: (z: 0, p:{d}");
        let tail = format!("{e},{f}q: 3)))}}");
        let tail = tail.replacen(")))}", "))})", 1);
        let text = format!("{head}{old}{tail}");
        let draft = Draft::of(&text).unwrap();
        let changes = draft.set_param("n", "p", new).unwrap();
        prop_assert_eq!(apply(&text, &changes), format!("{head}{new}{tail}"));
        // What is put in and taken out again leaves the text as it was.
        let added = apply(&text, &draft.set_param("n", "fresh", "1").unwrap());
        let back = apply(&added, &Draft::of(&added).unwrap().unset_param("n", "fresh").unwrap());
        prop_assert!(Draft::of(&back).is_ok() && !back.contains("fresh"), "{}", back);
        prop_assert!(added.contains("fresh: 1"), "{}", added);
    }
}
