//! Parameters against the schema of a kind: each mistake with its place, and what nodes are made.

use super::canonical_parameters;
use crate::document::sample::{made, rendered, told};
use crate::node::{kind, kinds};
use proptest::prelude::*;

/// A graph with one node; `with` stands alone in line 3.
fn calm(with: &str) -> String {
    let params = r#"params: {"c": 500, "l": [1, "x"], "s": "constant"}"#;
    format!("({params}, nodes: {{\"a\": (kind: \"calm_curves\", with: (\n\n{with}\n))}})")
}

fn mistakes(with: &str) -> Vec<String> {
    made(&calm(with), "a", &[]).map_or_else(|mistakes| told(&mistakes), |_| Vec::new())
}

/// What stands in `with`, and everything that is said about it.
const MISTAKES: &[(&str, &[&str])] = &[
    (
        "cutoff_hz: 500",
        &["out-of-range 3:12 `cutoff_hz` must be a number between 0.1 and 120 Hz, found the number 500"],
    ),
    (
        "cutoff_hz: 0.0999",
        &["out-of-range 3:12 `cutoff_hz` must be a number between 0.1 and 120 Hz, found the number 0.0999"],
    ),
    ("cutoff_hz: inf", &["out-of-range 3:12 `cutoff_hz` must be a finite number, found the number inf"]),
    (
        "cutoff_hz: \"6\"",
        &[
            "wrong-type 3:12 `cutoff_hz` must be a number between 0.1 and 120 Hz, found the string \"6\" | write 6 without quotes",
        ],
    ),
    ("cutoff_hz: None", &["wrong-type 3:12 `cutoff_hz` must be a number between 0.1 and 120 Hz, found nothing"]),
    (
        "cutoff_hz: \"${c}\"",
        &[
            "out-of-range 3:12 `cutoff_hz` must be a number between 0.1 and 120 Hz, found the number 500 | ${c} stands for the number 500",
        ],
    ),
    (
        "order: 2.5",
        &["wrong-type 3:8 `order` must be a whole number between 1 and 8, found the number 2.5 | write 2 or 3"],
    ),
    ("order: 4.0", &["wrong-type 3:8 `order` must be a whole number between 1 and 8, found the number 4.0 | write 4"]),
    ("padded: 1", &["wrong-type 3:9 `padded` must be true or false, found the number 1"]),
    (
        "padded: \"true\"",
        &["wrong-type 3:9 `padded` must be true or false, found the string \"true\" | write true without quotes"],
    ),
    ("note: 3", &["wrong-type 3:7 `note` must be a string, found the number 3 | write \"3\""]),
    ("rate_hz: 0", &["out-of-range 3:10 `rate_hz` must be a number above 0 Hz or None, found the number 0"]),
    (
        "cutof_hz: 3",
        &[
            "unknown-parameter 3:1 `calm_curves` has no parameter `cutof_hz` | did you mean `cutoff_hz`? parameters: `axes`, `channels`, `cutoff_hz`, `limits`, `note`, `order`, `padded`, `rate_hz`, `schedule`, `second`, `strength`",
        ],
    ),
    (
        "schedule: constnt",
        &[
            "unknown-variant 3:11 `schedule` has no variant `constnt` | did you mean `constant`? variants: `constant`, `linear`, `one_cycle`, `steps`",
        ],
    ),
    (
        "schedule: one_cycle",
        &[
            "wrong-type 3:11 `schedule`: the variant `one_cycle` needs content | write one_cycle(…) with (peak: …, warmup: …)",
        ],
    ),
    ("schedule: linear(3)", &["wrong-type 3:11 `schedule`: the variant `linear` takes no content | write linear"]),
    (
        "schedule: one_cycel(peak: 1)",
        &[
            "unknown-variant 3:11 `schedule` has no variant `one_cycel` | did you mean `one_cycle`? variants: `constant`, `linear`, `one_cycle`, `steps`",
        ],
    ),
    (
        "schedule: one_cycle(peak: 3, wamup: 1)",
        &[
            "out-of-range 3:27 `schedule.one_cycle.peak` must be a number between 0 and 1, found the number 3",
            "unknown-parameter 3:30 `schedule.one_cycle` has no field `wamup` | did you mean `warmup`? fields: `peak`, `warmup`",
        ],
    ),
    (
        "second: Some(one_cycle())",
        &["missing-parameter 3:23 `second.one_cycle` needs the field `peak` | add `peak`: a number between 0 and 1"],
    ),
    (
        "second: steps([1, -2, 2.5])",
        &[
            "out-of-range 3:19 `second.steps[1]` must be a whole number between 0 and 4294967295, found the number -2",
            "wrong-type 3:23 `second.steps[2]` must be a whole number between 0 and 4294967295, found the number 2.5 | write 2 or 3",
        ],
    ),
    (
        "second: 3",
        &[
            "wrong-type 3:9 `second` must be one of `constant`, `linear`, `one_cycle(…)`, `steps(…)` or None, found the number 3",
        ],
    ),
    ("limits: 3", &["wrong-type 3:9 `limits` must be (least_mm: …, most_mm: …), found the number 3"]),
    (
        "limits: (least_mm: \"a\", most: 3)",
        &[
            "wrong-type 3:20 `limits.least_mm` must be a number in mm, found the string \"a\"",
            "unknown-parameter 3:25 `limits` has no field `most` | did you mean `most_mm`? fields: `least_mm`, `most_mm`",
        ],
    ),
    ("axes: (1, 2)", &["out-of-range 3:7 `axes` must be a list of 3, each a number, found 2"]),
    (
        "axes: [1, \"x\", true]",
        &[
            "wrong-type 3:11 `axes[1]` must be a number, found the string \"x\"",
            "wrong-type 3:16 `axes[2]` must be a number, found `true`",
        ],
    ),
    (
        "axes: 3",
        &[
            "wrong-type 3:7 `axes` must be a list of 3, each a number, found the number 3 | write [ ] around it for a list of one",
        ],
    ),
    ("channels: \"${l}\"", &["wrong-type 3:11 `channels[0]` must be a string, found the number 1 | write \"1\""]),
    (
        "strength: {\"jaw\": 1, \"brow\": \"x\"}",
        &["wrong-type 3:30 `strength.brow` must be a number, found the string \"x\""],
    ),
    (
        "note: \"${d}\", order: 9",
        &[
            "unknown-parameter 3:8 there is no parameter `d` | parameters of this graph: `c`, `l`, `s`",
            "out-of-range 3:22 `order` must be a whole number between 1 and 8, found the number 9",
        ],
    ),
];

#[test]
fn every_mistake_is_answered() {
    for (with, expected) in MISTAKES {
        assert_eq!(mistakes(with), *expected, "{with}");
    }
}

/// What stands in `with`, and a parameter's canonical text.
const SOUND: &[(&str, &str, &str)] = &[
    ("", "cutoff_hz", "6.0"),
    ("cutoff_hz: 5", "cutoff_hz", "5.0"),
    ("cutoff_hz: 0.1, order: 8", "cutoff_hz", "0.1"),
    ("rate_hz: 24", "rate_hz", "24.0"),
    ("rate_hz: Some(24)", "rate_hz", "24.0"),
    ("rate_hz: None", "rate_hz", "null"),
    ("schedule: linear", "schedule", "\"linear\""),
    ("schedule: \"linear\"", "schedule", "\"linear\""),
    ("schedule: linear()", "schedule", "\"linear\""),
    ("schedule: \"${s}\"", "schedule", "\"constant\""),
    ("schedule: one_cycle(warmup: 0.5, peak: 1)", "schedule", r#"{"one_cycle":{"peak":1.0,"warmup":0.5}}"#),
    ("schedule: {\"one_cycle\": (peak: 1)}", "schedule", r#"{"one_cycle":{"peak":1.0,"warmup":0.0}}"#),
    ("second: steps([3, 1])", "second", r#"{"steps":[3,1]}"#),
    ("limits: ()", "limits", r#"{"least_mm":0.0,"most_mm":0.0}"#),
    ("limits: {\"most_mm\": 2}", "limits", r#"{"least_mm":0.0,"most_mm":2.0}"#),
    ("axes: (1, 2, 3.5)", "axes", "[1.0,2.0,3.5]"),
    ("strength: {\"b\": 1, \"a\": 2}", "strength", r#"{"a":2.0,"b":1.0}"#),
    ("strength: (b: 1, a: 2)", "strength", r#"{"a":2.0,"b":1.0}"#),
    ("channels: [\"a\", b]", "channels", r#"["a","b"]"#),
    ("note: \"at ${c} Hz\"", "note", "\"at 500 Hz\""),
];

#[test]
fn sound_parameters_make_nodes() {
    for (with, parameter, expected) in SOUND {
        let node = made(&calm(with), "a", &[]).unwrap_or_else(|mistakes| panic!("{with}: {}", rendered(mistakes)));
        assert_eq!(canonical_parameters(node.as_ref(), &[])[*parameter], *expected, "{with}");
    }
}

#[test]
fn canonical_parameters_hold_defaults_and_skip_files() {
    let node = made("(nodes: {\"a\": (kind: \"fetch_curves\", with: (path: \"x.csv\"))})", "a", &[]).unwrap();
    let names = |skip: &[&str]| canonical_parameters(node.as_ref(), skip).into_keys().collect::<Vec<_>>();
    assert_eq!(names(&[]), ["first", "path"]);
    assert_eq!(names(&["path"]), ["first"]);
}

#[test]
fn kinds_and_missing_parameters() {
    let mistakes = |entry: &str| told(&made(&format!("(nodes: {{\"a\": {entry}}})"), "a", &[]).unwrap_err());
    assert_eq!(
        mistakes(r#"(kind: "fetch_curve")"#),
        [
            "unknown-kind 1:22 there is no node kind `fetch_curve` | did you mean `fetch_curves`? `grimace nodes` lists all kinds"
        ]
    );
    assert_eq!(
        mistakes(r#"(kind: "xyz")"#),
        ["unknown-kind 1:22 there is no node kind `xyz` | `grimace nodes` lists all kinds"]
    );
    let needs = "missing-parameter 1:22 `fetch_curves` needs the parameter `path` \
        | add `path` to `with`: a string that is not empty";
    assert_eq!(mistakes(r#"(kind: "fetch_curves")"#), [needs]);
    let empty = "out-of-range 1:51 `path` must be a string that is not empty, found the string \"\"";
    assert_eq!(mistakes(r#"(kind: "fetch_curves", with: (path: ""))"#), [empty]);
}

#[test]
fn what_only_serde_knows_is_placed_at_the_parameter() {
    let text = "(nodes: {\"a\": (kind: \"fussy\", with: (name: \"a\", even: 3))})";
    assert_eq!(told(&made(text, "a", &[]).unwrap_err()), ["bad-parameter 1:55 parameter `even`: 3 is odd"]);
}

#[test]
fn mistakes_as_they_are_printed() {
    let shown = rendered(made(&calm("order: \"${c}\""), "a", &["a.cutoff_hz=500"]).unwrap_err());
    let expected = "\
out-of-range

  × `order` must be a whole number between 1 and 8, found the number 500
   ╭─[show/graph.ron:3:8]
 3 │ order: \"${c}\"
   ·        ───┬──
   ·           ╰── ${c} stands for the number 500
   ╰────

out-of-range

  × `--set a.cutoff_hz=500`: `cutoff_hz` must be a number between 0.1 and 120 Hz, found the number
  │ 500

2 mistakes in show/graph.ron";
    assert_eq!(shown, expected);
}

#[test]
fn every_schema_is_understood() {
    for (name, kind) in kinds() {
        let node = kind.default_node();
        assert!(serde_json::to_value(node.as_ref()).is_ok_and(|value| value.get(name).is_some()), "{name}");
    }
    assert!(kind("calm_curves").is_some());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    /// What the check lets pass, serde accepts: a residual mistake would have the code `bad-parameter`.
    #[test]
    fn the_check_finds_all_that_serde_refuses(
        name in prop::sample::select(vec![
            "cutoff_hz", "order", "padded", "schedule", "second", "limits", "axes", "strength", "channels", "note", "rate_hz",
        ]),
        value in prop::sample::select(vec![
            "1", "-1", "2.5", "4294967296", "true", "None", "()", "\"x\"", "constant", "linear", "[]", "[1, 2, 3]", "[\"a\"]",
            "(1, 2.5, 3)", "{\"a\": 1}", "(least_mm: 1)", "{}", "one_cycle(peak: 0.5)", "one_cycle(0.5)", "one_cycle()",
            "steps([1])", "steps(1)", "steps()", "steps(1, 2)", "steps((1, 2))", "{\"steps\": [1]}", "Some(Some(1))", "nothing(1)",
            "\"${c}\"", "\"${l}\"", "\"${s}\"", "inf", "NaN", "1e300", "[[1]]", "one_cycle([0.5, 1])", "one_cycle(0.5, 1)",
        ]),
    ) {
        let told = mistakes(&format!("{name}: {value}"));
        prop_assert!(!told.iter().any(|mistake| mistake.starts_with("bad-parameter")), "{told:?}");
    }
}
