//! Reading sound graphs, and mistakes of meaning.

use super::read;
use crate::document::sample::{graph, rendered, source, told};
use crate::document::{Body, Diagnostic, Diagnostics, Graph, Literal, Source, Span, render, to_json};
use proptest::prelude::*;

/// Texts and everything that is said about them: `code line:column message | label | help`.
const MISTAKES: &[(&str, &[&str])] = &[
    (
        "[1, 2]",
        &[
            r#"wrong-type 1:1 the graph must be ( … ) with named fields, found a list | a graph looks like ( grimace: 1, nodes: { "head": (kind: "sample_actor") } )"#,
        ],
    ),
    (
        r#""graph""#,
        &[
            r#"wrong-type 1:1 the graph must be ( … ) with named fields, found the string "graph" | a graph looks like ( grimace: 1, nodes: { "head": (kind: "sample_actor") } )"#,
        ],
    ),
    (
        "(grimace: 2, nodes: {})",
        &[
            "unsupported-version 1:11 this program reads version 1 of the graph language, found the number 2 | update grimace, or write the graph for version 1",
        ],
    ),
    (
        r#"(grimace: "1", nodes: {})"#,
        &[
            r#"unsupported-version 1:11 this program reads version 1 of the graph language, found the string "1" | write `grimace: 1`"#,
        ],
    ),
    (
        "(nods: {})",
        &[
            "unknown-field 1:2 the graph has no field `nods` | did you mean `nodes`? fields: `grimace`, `doc`, `params`, `inputs`, `outputs`, `nodes`",
        ],
    ),
    (r#"(doc: "x")"#, &["missing-field 1:1 the graph has no `nodes` | add `nodes: { … }`, or `nodes: {}` for none"]),
    (
        r#"(doc: 3, params: 4, inputs: [], outputs: "x", nodes: ["a"])"#,
        &[
            "wrong-type 1:7 `doc` must be a string, found the number 3",
            r#"wrong-type 1:18 `params` must be a map, found the number 4 | write { "parameter": … }"#,
            r#"wrong-type 1:29 `inputs` must be a map, found a list | write { "input": … }"#,
            r#"wrong-type 1:42 `outputs` must be a map, found the string "x" | write { "output": … }"#,
            r#"wrong-type 1:54 `nodes` must be a map, found a list | write { "node": … }"#,
        ],
    ),
    (
        r#"(nodes: {"a": (kind: "x"), "b": (kind: "y"), "a": (kind: "z")})"#,
        &["duplicate-node 1:46 the node `a` stands here twice | first in line 1 | rename or remove one"],
    ),
    (
        r#"(doc: "x", doc: "y", params: {"a": 1, "a": 2, "b": {"c": 1, "c": 2}}, nodes: {})"#,
        &[
            "duplicate-field 1:12 the field `doc` stands here twice | first in line 1 | rename or remove one",
            "duplicate-field 1:39 the parameter `a` stands here twice | first in line 1 | rename or remove one",
            "duplicate-field 1:61 the key `c` stands here twice | rename or remove one",
        ],
    ),
    (
        r#"(nodes: {"a": (kind: "x", graph: "y.ron"), "b": (in: {}), "c": (knid: "x"), "d": "x", "e": (kind: 3, for_each: 4)})"#,
        &[
            "kind-or-graph 1:27 the node `a` has both `kind` and `graph` | keep `kind` for a node, or `graph` for a nested graph file",
            r#"kind-or-graph 1:44 the node `b` has neither `kind` nor `graph` | add `kind: "…"` for a node, or `graph: "….ron"` for a nested graph file"#,
            "unknown-field 1:65 the node `c` has no field `knid` | did you mean `kind`? fields: `kind`, `graph`, `for_each`, `in`, `with`",
            r#"wrong-type 1:82 the node `d` must be ( … ) with named fields, found the string "x""#,
            "wrong-type 1:99 `kind` must be a string, found the number 3",
            "wrong-type 1:112 `for_each` must be a string, found the number 4",
        ],
    ),
    (
        r#"(nodes: {"a.b": (kind: "x"), "": (kind: "x"), "a@1": (kind: "x"), "ok-1_é": (kind: "x")})"#,
        &[
            "bad-name 1:10 `a.b` cannot name a node | use letters, digits, `_` and `-`; `.` goes before ports and `/` before nested nodes",
            "bad-name 1:30 an empty text cannot name a node | use letters, digits, `_` and `-`; `.` goes before ports and `/` before nested nodes",
            "bad-name 1:47 `a@1` cannot name a node | use letters, digits, `_` and `-`; `.` goes before ports and `/` before nested nodes",
        ],
    ),
    (
        r#"(params: {"a.b": 1, "ENV:X": 2, "": 3}, nodes: {})"#,
        &[
            "bad-name 1:11 `a.b` cannot name a parameter | use letters, digits, `_` and `-`",
            "bad-name 1:21 `ENV:X` cannot name a parameter | use letters, digits, `_` and `-`",
            "bad-name 1:33 an empty text cannot name a parameter | use letters, digits, `_` and `-`",
        ],
    ),
    (
        r#"(nodes: {"a": (kind: "x", in: {"i": "b.c", "j": ["b", "c.d"], "k": 3, "l": [4], "m": "a.b.c", "n": "", "i": "b"}, with: [1])})"#,
        &[
            r#"wrong-type 1:68 input `k` of `a` must be "node.port" or a list of these, found the number 3"#,
            "wrong-type 1:77 input `l` of `a` must be a string, found the number 4",
            r#"bad-connection 1:86 input `m` of `a`: `a.b.c` names no output | write "node.port", or "node" where the node has one output"#,
            r#"bad-connection 1:100 input `n` of `a`: an empty text names no output | write "node.port", or "node" where the node has one output"#,
            "duplicate-field 1:104 the input `i` stands here twice | first in line 1 | rename or remove one",
            r#"wrong-type 1:121 `with` must be a map, found a list | write { "parameter": … }"#,
        ],
    ),
    (
        r#"(inputs: {"a": "Markers", "b": "[Markers]?", "c": "[Markers", "d": 3, "e": "two words"}, nodes: {})"#,
        &[
            r#"bad-type 1:51 `[Markers` is not a type | write "Markers", "[Markers]" for a list, "Markers?" where it may be left open"#,
            "wrong-type 1:68 the type of input `d` must be a string, found the number 3",
            r#"bad-type 1:76 `two words` is not a type | write "Markers", "[Markers]" for a list, "Markers?" where it may be left open"#,
        ],
    ),
    (
        r#"(nodes: {"a": (kind: "x", with: (p: (q: 1, q: 2), p: 3))})"#,
        &[
            "duplicate-field 1:44 the key `q` stands here twice | rename or remove one",
            "duplicate-field 1:51 the parameter `p` stands here twice | first in line 1 | rename or remove one",
        ],
    ),
];

#[test]
fn every_mistake_is_answered() {
    for (text, expected) in MISTAKES {
        let (_, mistakes) = read(source(text));
        assert_eq!(told(&mistakes), *expected, "{text}");
    }
}

const SOUND: &str = r#"#![enable(implicit_some)]
// Solves one day.
(
    grimace: 1,
    doc: "Solve",
    params: { "actor": "a.glb", "hold": 0.5, "takes": ["a", "b"] },
    inputs: { "rig": "Rig", "rom": "[Curves]", "anchors": "Anchors?" },
    outputs: { "curves": "out.curves", },
    nodes: {
        "rig": (kind: "load_rig", with: (path: "${actor}")),
        "takes": (kind: "load_markers", with: { "path": "takes/*.c3d", "schedule": one_cycle(peak: 0.5) }),
        /* nested */
        "solve": (for_each: "takes", graph: "solve_take.ron", in: { "rig": "rig", "all": ["takes", "a.b"] }),
    },
)
"#;

#[test]
fn a_sound_graph() {
    let graph = graph(SOUND);
    assert_eq!(graph.doc.as_deref(), Some("Solve"));
    assert_eq!(graph.params["hold"].value, Literal::Number(0.5));
    assert_eq!((graph.inputs["rom"].type_name.as_str(), graph.inputs["rom"].list), ("Curves", true));
    assert!(graph.inputs["anchors"].optional && !graph.inputs["rig"].optional);
    assert_eq!(graph.outputs["curves"].value, "out.curves");
    let solve = &graph.nodes["solve"];
    assert!(matches!(&solve.body, Body::Graph(file) if file.value == "solve_take.ron"));
    assert_eq!(solve.for_each.as_ref().map(|list| list.value.as_str()), Some("takes"));
    let sources: Vec<_> = solve.inputs["all"].sources.iter().map(|source| source.value.as_str()).collect();
    assert_eq!(sources, ["takes", "a.b"]);
    let schedule = &graph.nodes["takes"].with["schedule"];
    assert!(matches!(&schedule.value.value, Literal::Variant(name, _) if name == "one_cycle"));
    let written = |span: crate::document::Span| &graph.source.text[span.start..span.end];
    assert_eq!(written(schedule.value.span), "one_cycle(peak: 0.5)");
    assert_eq!(written(schedule.name_span), "\"schedule\"");
    assert_eq!(written(solve.name_span), "\"solve\"");
    assert_eq!(written(graph.inputs["rom"].span), "\"[Curves]\"");
}

#[test]
fn what_may_be_left_out() {
    assert!(graph("(nodes: {})").nodes.is_empty());
    let graph = graph(r#"(doc: None, params: (), nodes: { "a": (kind: "x", in: {}, with: ()) })"#);
    assert!(graph.nodes["a"].with.is_empty());
}

#[test]
fn a_mistake_as_it_is_printed() {
    let (_, mistakes) = read(source("(\n    nodes: {\n\t\"tête\": (knd: \"x\"), \"b\": (kind: 3),\n    },\n)\n"));
    let expected = r#"unknown-field

  × the node `tête` has no field `knd`
   ╭─[show/graph.ron:3:11]
 3 │     "tête": (knd: "x"), "b": (kind: 3),
   ·              ───
   ╰────
  help: did you mean `kind`? fields: `kind`, `graph`, `for_each`, `in`, `with`

wrong-type

  × `kind` must be a string, found the number 3
   ╭─[show/graph.ron:3:34]
 3 │     "tête": (knd: "x"), "b": (kind: 3),
   ·                                     ─
   ╰────

2 mistakes in show/graph.ron"#;
    assert_eq!(rendered(mistakes), expected);
}

/// Every place within a graph.
fn spans(graph: &Graph) -> Vec<Span> {
    fn of_value(value: &crate::document::Spanned<Literal>, spans: &mut Vec<Span>) {
        spans.push(value.span);
        match &value.value {
            Literal::List(items) => items.iter().for_each(|item| of_value(item, spans)),
            Literal::Map(entries) => entries.iter().for_each(|(key, value)| {
                spans.push(key.span);
                of_value(value, spans);
            }),
            Literal::Variant(_, content) => of_value(content, spans),
            _ => {}
        }
    }
    let mut spans = Vec::new();
    graph.params.values().for_each(|value| of_value(value, &mut spans));
    spans.extend(graph.inputs.values().map(|input| input.span));
    spans.extend(graph.outputs.values().map(|output| output.span));
    for entry in graph.nodes.values() {
        spans.push(entry.name_span);
        spans.extend(entry.inputs.values().flat_map(|input| input.sources.iter().map(|source| source.span)));
        for param in entry.with.values() {
            spans.push(param.name_span);
            of_value(&param.value, &mut spans);
        }
    }
    spans
}

/// Reads `text`, whatever it is: nothing panics, and every place lies within the text.
fn survives(text: &str) -> Result<(), TestCaseError> {
    let source = source(text);
    let (graph, mistakes) = read(std::sync::Arc::clone(&source));
    let within = |source: &Source, span: Span| source.text.get(span.start..span.end).is_some();
    for span in graph.iter().flat_map(spans) {
        prop_assert!(within(&source, span), "{span:?}");
    }
    let placed = |mistake: &Diagnostic| mistake.place.as_ref().is_some_and(|(place, _)| within(&source, place.span));
    prop_assert!(mistakes.iter().all(placed), "{mistakes:?}");
    prop_assert!(graph.is_some() || !mistakes.is_empty());
    if !mistakes.is_empty() {
        let diagnostics = Diagnostics(mistakes);
        let shown = render(&diagnostics, false, 80);
        for (place, _) in diagnostics.0.iter().filter_map(|mistake| mistake.place.as_ref()) {
            prop_assert!(shown.contains(&place.text()), "{} in {shown}", place.text());
        }
        prop_assert_eq!(to_json(&diagnostics).as_array().map(Vec::len), Some(diagnostics.0.len()));
    }
    Ok(())
}

/// `SOUND` with some of its characters removed, doubled, moved or replaced.
fn damaged() -> impl Strategy<Value = String> {
    let piece =
        prop_oneof!["[(){}\\[\\]:,\"'/*#$ \n]{1,2}", any::<String>().prop_map(|text| text.chars().take(3).collect())];
    let edit = (any::<prop::sample::Index>(), 0_usize..12, piece, any::<prop::sample::Index>());
    prop::collection::vec(edit, 1..5).prop_map(|edits| {
        let mut letters: Vec<char> = SOUND.chars().collect();
        for (at, length, piece, to) in edits {
            let at = at.index(letters.len() + 1);
            let end = (at + length).min(letters.len());
            let taken: Vec<char> = letters.splice(at..end, piece.chars()).collect();
            let to = to.index(letters.len() + 1);
            letters.splice(to..to, taken.into_iter().take(length / 2));
        }
        letters.into_iter().collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(600) })]

    #[test]
    fn damaged_graphs_are_survived(text in damaged()) {
        survives(&text)?;
    }

    #[test]
    fn any_text_is_survived(text in any::<String>()) {
        survives(&text)?;
    }

    #[test]
    fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        survives(&String::from_utf8_lossy(&bytes))?;
    }
}
