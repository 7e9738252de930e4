//! `${…}`, overrides and nested graphs.

use super::{Environment, Given, Override, Resolved, Scope, apply_overrides, node_parameters, resolve};
use crate::document::sample::{graph, rendered, source, told};
use crate::document::{Diagnostic, Graph, Literal, Source, Span, Spanned, read};
use std::path::Path;
use std::sync::Arc;

fn environment() -> Arc<Environment> {
    let variables = [("HOME", "/home/td/"), ("SHOW", "alpha"), ("BRACES", "{take}${x}")];
    Arc::new(variables.into_iter().map(|(name, value)| (name.to_owned(), value.to_owned())).collect())
}

fn opened(text: &str) -> (Graph, Scope, Vec<Diagnostic>) {
    let graph = graph(text);
    let (scope, mistakes) = Scope::open(&graph, Given::default(), &environment());
    (graph, scope, mistakes)
}

/// The value of the parameter `p`.
fn value_of(params: &str) -> Result<Resolved, Vec<String>> {
    let (_, scope, mistakes) = opened(&format!("(nodes: {{}}, params: {{\n{params}\n}})"));
    if mistakes.is_empty() { Ok(scope.values["p"].clone().unwrap()) } else { Err(told(&mistakes)) }
}

fn text(text: &str, folder: &str) -> Resolved {
    Resolved::Text { text: text.to_owned(), folder: folder.into() }
}

#[test]
fn what_texts_stand_for() {
    let cases: &[(&str, Resolved)] = &[
        (r#""p": "plain $ {a,b} $x""#, text("plain $ {a,b} $x", "show")),
        (r#""p": "${n}", "n": 3"#, Resolved::Integer(3)),
        (r#""p": "${n}", "n": 0.5"#, Resolved::Number(0.5)),
        (
            r#""p": "${n}", "n": [1, "${m}"], "m": true"#,
            Resolved::List(vec![Resolved::Integer(1), Resolved::Bool(true)]),
        ),
        (r#""p": "a${n}b${m}", "n": 3, "m": 1.5"#, text("a3b1.5", "show")),
        (r#""p": "${a}/${b}", "a": "${b}", "b": "x""#, text("x/x", "show")),
        (r#""p": "$${n} $$${n}", "n": 3"#, text("${n} $${n}", "show")),
        (r#""p": "$$", "n": 3"#, text("$$", "show")),
        (r#""p": "~/x""#, text("/home/td/x", "show")),
        (r#""p": "~""#, text("/home/td", "show")),
        (r#""p": "~td/x ~/""#, text("~td/x ~/", "show")),
        (r#""p": "${n}/x", "n": "~""#, text("/home/td/x", "show")),
        (r#""p": "${ENV:SHOW}/x""#, text("alpha/x", "show")),
        (r#""p": "${ENV:BRACES}""#, text("{take}${x}", "show")),
        (r#""p": "{take}.csv""#, text("{take}.csv", "show")),
        (r#""p": {"${n}": 1}, "n": "x""#, Resolved::Map(vec![("x".to_owned(), Resolved::Integer(1))])),
        (
            r#""p": v(a: "${n}"), "n": 3"#,
            Resolved::Variant("v".to_owned(), Box::new(Resolved::Map(vec![("a".to_owned(), Resolved::Integer(3))]))),
        ),
    ];
    for (params, expected) in cases {
        assert_eq!(value_of(params).as_ref(), Ok(expected), "{params}");
    }
}

/// Parameters, and everything that is said about them.
const MISTAKES: &[(&str, &[&str])] = &[
    (
        r#""p": "x/${actr}", "actor": "a""#,
        &[
            "unknown-parameter 2:9 there is no parameter `actr` | did you mean `actor`? parameters of this graph: `actor`, `p`",
        ],
    ),
    (r#""p": "${zzz}""#, &["unknown-parameter 2:7 there is no parameter `zzz` | parameters of this graph: `p`"]),
    (r#""p": "\t${zzz}""#, &["unknown-parameter 2:6 there is no parameter `zzz` | parameters of this graph: `p`"]),
    (r##""p": r#"\${zzz}"#"##, &["unknown-parameter 2:10 there is no parameter `zzz` | parameters of this graph: `p`"]),
    (
        r#""p": "${ENV:SHWO} ${ENV:NOPE}""#,
        &[
            "unset-variable 2:7 the environment variable `SHWO` is not set | did you mean `SHOW`?",
            "unset-variable 2:19 the environment variable `NOPE` is not set | set it: export NOPE=…",
        ],
    ),
    (
        r#""p": "é ${n", "n": 1"#,
        &["bad-reference 2:9 this `${` is never closed | close it with `}`, or write `$${` for a plain `${`"],
    ),
    (r#""p": "x${n}", "n": [1]"#, &["wrong-type 2:8 `${n}` is a list and cannot stand within a text"]),
    (
        r#""p": "${q}", "q": "x${r}", "r": "${p}""#,
        &[
            "parameter-cycle 2:6 parameters refer to each other in a circle: p → q → r → p | give one of them a plain value",
        ],
    ),
    (
        r#""p": "${p}""#,
        &["parameter-cycle 2:6 parameters refer to each other in a circle: p → p | give one of them a plain value"],
    ),
    (
        r#""p": "${q} ${zz}", "q": "${x}""#,
        &[
            "unknown-parameter 2:26 there is no parameter `x` | parameters of this graph: `p`, `q`",
            "unknown-parameter 2:12 there is no parameter `zz` | parameters of this graph: `p`, `q`",
        ],
    ),
];

#[test]
fn every_mistake_is_answered() {
    for (params, expected) in MISTAKES {
        assert_eq!(value_of(params).unwrap_err(), *expected, "{params}");
    }
}

#[test]
fn a_wrong_default_is_reported_once_and_not_where_it_is_used() {
    let (graph, scope, mistakes) =
        opened(r#"(params: {"a": "${x}"}, nodes: {"n": (kind: "calm_curves", with: (note: "${a}", order: 3))})"#);
    assert_eq!(mistakes.len(), 1);
    let given = node_parameters(&graph, &graph.nodes["n"], &scope, None, &[], "n");
    assert_eq!(given, Err(Vec::new()));
}

#[test]
fn overrides_are_read() {
    let parse = |text: &str| Override::parse(text).unwrap();
    assert_eq!((parse("a=1").path.len(), parse("a=1").name.as_str()), (0, "a"));
    assert_eq!(parse("solve.raw.hold=0.1").path, ["solve", "raw"]);
    assert_eq!(parse("solve/raw.hold=0.1").path, ["solve", "raw"]);
    assert_eq!(parse("a=x=y").value, Literal::Text("x=y".to_owned()));
    let read = [
        ("1", Literal::Integer(1)),
        ("0x10", Literal::Integer(16)),
        ("-.5", Literal::Number(-0.5)),
        ("true", Literal::Bool(true)),
        ("None", Literal::Nothing),
        ("", Literal::Text(String::new())),
        ("\"07\"", Literal::Text("07".to_owned())),
        ("takes/*.c3d", Literal::Text("takes/*.c3d".to_owned())),
        ("/shows/a b/{take}.csv", Literal::Text("/shows/a b/{take}.csv".to_owned())),
        ("1001-1100x2", Literal::Text("1001-1100x2".to_owned())),
        ("constant", Literal::Text("constant".to_owned())),
        ("'x'", Literal::Text("'x'".to_owned())),
        ("\"x", Literal::Text("\"x".to_owned())),
    ];
    for (raw, expected) in read {
        assert_eq!(parse(&format!("a={raw}")).value, expected, "{raw}");
    }
    assert!(matches!(parse("a=[1, 2]").value, Literal::List(_)));
    assert!(matches!(parse("a={\"x\": 1}").value, Literal::Map(_)));
    assert!(matches!(parse("a=one_cycle(peak: 1)").value, Literal::Variant(..)));
    for wrong in ["a", "=1", ".a=1", "a.=1", ""] {
        assert_eq!(Override::parse(wrong).unwrap_err().code, "bad-override", "{wrong}");
    }
}

#[test]
fn overrides_stand_above_defaults_and_entries() {
    let graph = graph(
        r#"(params: {"take": "a", "hold": 1, "list": []},
            nodes: {"n": (kind: "calm_curves", with: (note: "${take}", order: 3))})"#,
    );
    let sets: Vec<_> = ["take=007", "hold=2", "list=[1]", "n.order=4", "n.note=5", "n.axes=[1,2,3]"]
        .iter()
        .map(|text| Override::parse(text).unwrap())
        .collect();
    let (scope, mistakes) = apply_overrides(&graph, &sets, &environment());
    assert_eq!(mistakes, []);
    assert_eq!(scope.values["take"], Some(text("007", "")));
    assert_eq!(scope.values["hold"], Some(Resolved::Integer(2)));
    let given = node_parameters(&graph, &graph.nodes["n"], &scope, None, &sets, "n").unwrap().parameters;
    assert_eq!(given["order"].value, Resolved::Integer(4));
    assert_eq!(given["note"].value, text("5", ""));
    assert!(matches!(given["axes"].value, Resolved::List(_)));
}

#[test]
fn unknown_overrides_are_mistakes() {
    let graph = graph(r#"(params: {"hold": 1}, nodes: {"smooth": (kind: "calm_curves")})"#);
    let told_of = |set: &str| told(&apply_overrides(&graph, &[Override::parse(set).unwrap()], &environment()).1);
    assert_eq!(
        told_of("hodl=2"),
        ["unknown-parameter - `--set hodl=2`: show/graph.ron has no parameter `hodl` | did you mean `hold`?"]
    );
    assert_eq!(
        told_of("smooth=2"),
        [
            "unknown-parameter - `--set smooth=2`: show/graph.ron has no parameter `smooth` | `smooth` is a node; write `--set smooth.param=value`"
        ]
    );
    assert_eq!(
        told_of("hold=${x}"),
        [
            "unknown-parameter - `--set hold=${x}`: there is no parameter `x` | this graph has no `params`; write `$${` for a plain `${`"
        ]
    );
}

/// The graph `text` at `path`.
fn graph_at(path: &str, text: &str) -> Graph {
    let (graph, mistakes) = read(Arc::new(Source::new(path, text)));
    assert!(mistakes.is_empty(), "{}", rendered(mistakes));
    graph.unwrap()
}

#[test]
fn paths_start_from_the_folder_of_whoever_wrote_their_beginning() {
    let outer = graph_at(
        "show/graph.ron",
        r#"(params: {"out": "renders"}, nodes: {"s": (graph: "lib/inner.ron", with: (rig: "rigs/a.glb", out: "${out}"))})"#,
    );
    let inner = graph_at(
        "show/lib/inner.ron",
        r#"(params: {"rig": "default.glb", "out": ".", "mask": "mask.png"},
            nodes: {"n": (kind: "fetch_curves", with: (
                a: "${rig}", b: "${out}/{take}.csv", c: "${mask}", d: "x/${rig}", e: "/abs/${rig}"))})"#,
    );
    let paths = |sets: &[&str], item: Option<&str>| {
        let sets: Vec<_> = sets.iter().map(|text| Override::parse(text).unwrap()).collect();
        let (scope, mistakes) = apply_overrides(&outer, &sets, &environment());
        assert_eq!(mistakes, []);
        let (scope, mistakes) = Scope::nested(&inner, &outer.nodes["s"], &outer.source, &scope, &sets, "s");
        assert_eq!(mistakes, []);
        let given = node_parameters(&inner, &inner.nodes["n"], &scope, item, &sets, "s/n").unwrap();
        assert!(given.mentions_item);
        let path = |given: &super::GivenParam<'_>| given.value.path().unwrap().display().to_string();
        given.parameters.values().map(path).collect::<Vec<_>>()
    };
    assert_eq!(
        paths(&[], Some("walk")),
        ["show/rigs/a.glb", "show/renders/walk.csv", "show/lib/mask.png", "show/lib/x/rigs/a.glb", "/abs/rigs/a.glb"]
    );
    assert_eq!(
        paths(&["out=/o", "s.rig=here.glb", "s/n.c=m.png"], None),
        ["here.glb", "/o/{take}.csv", "m.png", "show/lib/x/here.glb", "/abs/here.glb"]
    );
}

#[test]
fn nested_graphs_have_the_parameters_they_have() {
    let outer = graph(r#"(nodes: {"s": (graph: "inner.ron", with: (hodl: 1, rig: "${nope}"))})"#);
    let inner = graph_at("show/inner.ron", r#"(params: {"hold": 1, "rig": "x"}, nodes: {})"#);
    let (scope, mistakes) = apply_overrides(&outer, &[], &environment());
    assert_eq!(mistakes, []);
    let set = Override::parse("s.holdd=2").unwrap();
    let (_, mistakes) = Scope::nested(&inner, &outer.nodes["s"], &outer.source, &scope, &[set], "s");
    assert_eq!(
        told(&mistakes),
        [
            "unknown-parameter 1:43 `show/inner.ron` has no parameter `hodl` | did you mean `hold`? parameters: `hold`, `rig`",
            "unknown-parameter 1:58 there is no parameter `nope` | this graph has no `params`; write `$${` for a plain `${`",
            "unknown-parameter - `--set s.holdd=2`: show/inner.ron has no parameter `holdd` | did you mean `hold`? parameters: `hold`, `rig`",
        ]
    );
}

#[test]
fn the_environment_of_the_process_is_seen() {
    let scope = Scope::file(&source(""));
    let written = Spanned { value: Literal::Text("${ENV:CARGO_MANIFEST_DIR}".to_owned()), span: Span::default() };
    let expected = Resolved::Text { text: env!("CARGO_MANIFEST_DIR").to_owned(), folder: Path::new("show").into() };
    assert_eq!(resolve(&written, &scope), Ok(expected));
}
