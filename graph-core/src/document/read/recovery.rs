//! Mistakes in the spelling of a graph: each with what it is answered, and that the rest of the text is still read.

use super::read;
use crate::document::sample::{source, told};

/// Texts and everything that is said about them: `code line:column message | label | help`.
const MISTAKES: &[(&str, &[&str])] = &[
    ("(grimace: 1 nodes: {})", &["syntax 1:12 expected `,` or `)`, found `nodes` | a `,` is missing here"]),
    ("(nodes {})", &["syntax 1:7 expected `:` and a value, found `{` | a `:` is missing here"]),
    ("(nodes = {})", &["syntax 1:8 expected `:` after a name, found `=`"]),
    (
        r#"(nodes: {"a" (kind: "x"), "b" 3})"#,
        &[
            "syntax 1:13 expected `:` and a value, found `(` | a `:` is missing here",
            "syntax 1:30 expected `:` and a value, found `3` | a `:` is missing here",
            "wrong-type 1:31 the node `b` must be ( … ) with named fields, found the number 3",
        ],
    ),
    (r#"(nodes: {"a": })"#, &["syntax 1:15 expected a value, found `}`"]),
    (r#"(nodes: {"a": (kind: , in: {})})"#, &["syntax 1:22 expected a value, found `,`"]),
    (r#"(nodes: {"a": (kind: "x",, with: ())})"#, &["syntax 1:26 expected a value or `)`, found `,`"]),
    (
        "(nodes: {\"a\": (kind: \"x\", with: (p: 1),\n \"b\": (kind: \"y\")})",
        &[r#"syntax 1:15 this `(` is not closed before `"b"` in line 2 | opened here | add the missing `)`"#],
    ),
    (
        "(params: {\"p\": 1,\n nodes: {}))",
        &[
            "syntax 1:10 this `{` is not closed before `nodes` in line 2 | opened here | add the missing `}`",
            "syntax 2:12 this `)` closes nothing | take it away, or open it further up",
        ],
    ),
    (
        "(params: {\"p\": [1, 2},\n nodes: {}))",
        &[
            "syntax 1:16 this `[` is not closed before `}` in line 1 | opened here | add the missing `]`",
            "syntax 2:12 this `)` closes nothing | take it away, or open it further up",
        ],
    ),
    (
        r#"(nodes: {"a": (kind: "x", with: (p: [1, 2))})"#,
        &["syntax 1:37 this `[` is not closed before `)` in line 1 | opened here | add the missing `]`"],
    ),
    (r#"(nodes: {"a": (kind: "x")), "b": (kind: "y")})"#, &["syntax 1:26 expected `}`, found `)` | closes nothing"]),
    ("(nodes: {}))", &["syntax 1:12 this `)` closes nothing | take it away, or open it further up"]),
    ("(nodes: {}", &["syntax 1:1 this `(` is never closed | opened here | add the missing `)`"]),
    ("(nodes: {}) (x)", &["syntax 1:13 expected the end of the file, found `(` | a graph is one value: ( … )"]),
    (
        "(doc: \"open,\n nodes: {\"a\": (kind: \"x\")})",
        &[r#"syntax 1:7 this string is never closed | a `"` is missing at its end"#],
    ),
    (
        "(doc: \"several\nlines\", nodes: {\"a\": (kind: \"x), \"b\": (kind: \"y\"),\n \"c\": (kind: \"z\")})",
        &[r#"syntax 2:29 this string is never closed | a `"` is missing at its end"#],
    ),
    (r#"(doc: r#"open", nodes: {})"#, &[r##"syntax 1:7 this raw string is never closed | close it with `"#`"##]),
    ("(doc: 'single', nodes: {})", &[r#"syntax 1:7 strings stand in double quotes | write "single""#]),
    ("(doc: “curly”, nodes: {})", &[r#"syntax 1:7 strings stand in straight double quotes | write "curly""#]),
    (
        r#"(doc: "C:\takes\new\u{110000}\xff", nodes: {})"#,
        &[r"syntax 1:20 `\u{110000}` is no character", "syntax 1:30 these bytes are no character"],
    ),
    (
        "(doc: 'x, nodes: {})",
        &[r#"syntax 1:7 strings stand in double quotes, and this one is never closed | write "x""#],
    ),
    (
        r"(doc: '\q', nodes: {})",
        &[
            r#"syntax 1:8 `\q` is no escape | write `\\` for a backslash; in paths, write `/`, or use a raw string: r"…""#,
        ],
    ),
    (
        "(doc: takes/day-1, nodes: {})",
        &[r#"syntax 1:7 `takes/day-1` is neither a name nor a number | if it is meant as text, write "takes/day-1""#],
    ),
    (
        "(doc: takes/*.c3d, nodes: {})",
        &[r#"syntax 1:7 `takes/*.c3d` is neither a name nor a number | if it is meant as text, write "takes/*.c3d""#],
    ),
    (
        r#"(nodes: {a: (kind: "x"), b: (kind: "y")})"#,
        &["syntax 1:10 keys in { } stand in quotes | use quotes, or ( ) for fields"],
    ),
    (
        r#"(nodes: {"a": (kind: "x", "with": ())})"#,
        &["syntax 1:27 names in ( ) stand without quotes | use { } around quoted keys"],
    ),
    (
        r#"(nodes: {"a": (kind: "x", with: (p: [a: 1, b: 2]))})"#,
        &["syntax 1:38 a list [ ] has no names | use { } around quoted keys"],
    ),
    (
        r#"(nodes: {"a": (kind: "x", with: (p: (1, a: 2), q: (a: 1, 2)))})"#,
        &[
            "syntax 1:41 either all values in ( ) have names, or none",
            "syntax 1:58 either all values in ( ) have names, or none",
        ],
    ),
    (
        r#"(params: {"a": 1.2.3, "b": 99999999999999999999, "c": 300u8, "d": 1..3, "e": 1001-1100, "f": b"x", "g": 0xfg}, nodes: {})"#,
        &[
            r#"syntax 1:16 `1.2.3` is not a number | if it is meant as text, write "1.2.3""#,
            "syntax 1:28 `99999999999999999999` is too large: whole numbers go from -9223372036854775808 to 9223372036854775807",
            "syntax 1:55 `300u8` does not fit its suffix, which allows 0 to 255",
            r#"syntax 1:67 `1..3`: ranges have no meaning in a graph | write a string, such as "1001-1100x2", or two numbers"#,
            r#"syntax 1:78 `1001-1100` is not a number | if it is meant as text, write "1001-1100""#,
            "syntax 1:94 byte strings have no meaning in a graph | write a string without the `b`",
            r#"syntax 1:105 `0xfg` is not a number | if it is meant as text, write "0xfg""#,
        ],
    ),
    (
        r#"(params: {"a": Some(), "b": Some(1, 2), "c": Some, "d": Some(3)}, nodes: {})"#,
        &[
            "syntax 1:16 `Some` takes one value, found 0",
            "syntax 1:29 `Some` takes one value, found 2",
            "syntax 1:46 `Some` without a value | write `Some(value)` or `None`",
        ],
    ),
    ("(params: {(1, 2): 3}, nodes: {})", &["syntax 1:11 a key must be a string"]),
    (
        "#![enable(implicit_sum)]\n(nodes: {})",
        &[
            "syntax 1:11 RON has no extension `implicit_sum` | did you mean `implicit_some`? extensions: `explicit_struct_names`, `implicit_some`, `unwrap_newtypes`, `unwrap_variant_newtypes`",
        ],
    ),
    (
        "#![enable implicit_some]\n(nodes: {})",
        &["syntax 1:1 this is no line of extensions | write `#![enable(implicit_some)]`, or leave it out"],
    ),
    (
        "",
        &[
            r#"syntax 1:1 expected a value, found the end of the file | a graph looks like ( grimace: 1, nodes: { "head": (kind: "sample_actor") } )"#,
        ],
    ),
    (
        "// only a comment",
        &[
            r#"syntax 1:18 expected a value, found the end of the file | a graph looks like ( grimace: 1, nodes: { "head": (kind: "sample_actor") } )"#,
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

/// Texts with mistakes, and the nodes that are read from them all the same.
const RECOVERED: &[(&str, &[&str])] = &[
    ("(nodes: {\"a\": (kind: \"x\", with: (p: 1),\n \"b\": (kind: \"y\")})", &["a", "b"]),
    (r#"(nodes: {"a": (kind: "x")), "b": (kind: "y")})"#, &["a", "b"]),
    (r#"(nodes: {"a": (kind: "x" with: (p: [1, 2)), "b": (kind = "y"), c: (kind: 'z')})"#, &["a", "b", "c"]),
    ("(doc: \"open,\n nodes: {\"a\": (kind: \"x\")})", &["a"]),
    (
        "(doc: \"of two\nlines\", nodes: {\"a\": (kind: \"x), \"b\": (kind: \"y\"),\n \"c\": (kind: \"z\")})",
        &["a", "b", "c"],
    ),
    ("(nodes: {\"a\": (kind: \"x\", with: (path: \"C:\\takes\")), \"b\": (kind: \"y\")", &["a", "b"]),
];

#[test]
fn the_rest_is_still_read() {
    for (text, nodes) in RECOVERED {
        let (graph, mistakes) = read(source(text));
        assert!(!mistakes.is_empty(), "{text}");
        let graph = graph.expect("a graph in spite of the mistakes");
        assert_eq!(graph.nodes.keys().collect::<Vec<_>>(), *nodes, "{text}");
    }
}

#[test]
fn deep_nesting_is_a_mistake_not_a_crash() {
    for opening in ["(", "[", "{\"a\":", "Some(", "v(", "(a: "] {
        let deepest = if opening.starts_with('{') || opening.ends_with(": ") { 126 } else { 128 };
        let told = |count: usize| told(&read(source(&opening.repeat(count))).1);
        let is_deep = |mistake: &String| mistake.contains("brackets nest deeper than 128");
        assert!(!told(deepest).iter().any(is_deep), "{opening}");
        assert!(told(200_000).iter().any(is_deep), "{opening}");
    }
}

#[test]
fn hostile_texts_are_read_in_time() {
    let started = std::time::Instant::now();
    for part in
        ["\"", "'", "a/* ", "/*", "/**/", "(a: \"", ")", "(]", "{[", "\\", "r#\"", "${", "{\"a\": (b: 1, ", "\"\n", "“"]
    {
        let text = part.repeat(200_000 / part.len());
        let (_, mistakes) = read(source(&text));
        assert!(!mistakes.is_empty(), "{part}");
    }
    assert!(started.elapsed().as_secs() < 60, "{:?}", started.elapsed());
}
