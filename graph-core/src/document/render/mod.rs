//! Diagnostics for people (the source line with the place marked, the cure, the files that nest it) and as JSON.

mod report;

use super::{Diagnostic, Diagnostics, Place, Span};
use miette::{GraphicalReportHandler, GraphicalTheme};
use report::Report;
use serde_json::{Value, json};
use std::path::Path;

/// All mistakes, in the order of the files, as text of at most about `width` columns, each with its `file:line:column`, and their count at the
/// end.
pub fn render(diagnostics: &Diagnostics, colour: bool, width: usize) -> String {
    let theme = if colour { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let handler = GraphicalReportHandler::new_themed(theme)
        .with_width(width.max(40))
        .with_links(false)
        .with_wrap_lines(false)
        .with_cause_chain()
        .tab_width(4);
    let mut out = String::new();
    for diagnostic in in_order(&diagnostics.0) {
        let report = Report::new(diagnostic, width.max(40));
        // Writing to a string cannot fail; should miette refuse a span, the bare facts stand in.
        if handler.render_report(&mut out, &report).is_err() {
            out.push_str(&report.message);
        }
        out.push('\n');
    }
    out + &summary(&diagnostics.0) + "\n"
}

/// File by file, as they first appear, each from top to bottom; what has no place comes last.
fn in_order(diagnostics: &[Diagnostic]) -> Vec<&Diagnostic> {
    let mut files: Vec<&Path> = Vec::new();
    let mut keyed: Vec<_> = diagnostics
        .iter()
        .map(|diagnostic| {
            let Some((place, _)) = &diagnostic.place else { return (usize::MAX, Span::default(), diagnostic) };
            let path = place.source.path.as_path();
            let file = files.iter().position(|known| *known == path).unwrap_or_else(|| {
                files.push(path);
                files.len() - 1
            });
            (file, place.span, diagnostic)
        })
        .collect();
    keyed.sort_by_key(|(file, span, _)| (*file, *span));
    keyed.into_iter().map(|(.., diagnostic)| diagnostic).collect()
}

/// `3 mistakes in graph.ron and solve_take.ron`.
fn summary(diagnostics: &[Diagnostic]) -> String {
    const NAMED: usize = 4;
    let mut files: Vec<String> = Vec::new();
    for (place, _) in diagnostics.iter().filter_map(|diagnostic| diagnostic.place.as_ref()) {
        let file = place.source.path.display().to_string();
        if !files.contains(&file) {
            files.push(file);
        }
    }
    let count = match diagnostics.len() {
        1 => "1 mistake".to_owned(),
        count => format!("{count} mistakes"),
    };
    if files.len() > NAMED {
        let more = format!("{} more files", files.len() - NAMED);
        files.truncate(NAMED);
        files.push(more);
    }
    match files.as_slice() {
        [] => count,
        [one] => format!("{count} in {one}"),
        [several @ .., last] => format!("{count} in {} and {last}", several.join(", ")),
    }
}

/// All mistakes as a list of objects: `code`, `message`, and where they apply `label`, `help`, `file`, `line`,
/// `column`, `end_line`, `end_column` and `through` (the places that nest the file, outermost first). Lines and columns
/// count from 1, columns in characters.
pub fn to_json(diagnostics: &Diagnostics) -> Value {
    in_order(&diagnostics.0).into_iter().map(one_to_json).collect()
}

fn one_to_json(diagnostic: &Diagnostic) -> Value {
    let mut object = json!({ "code": diagnostic.code, "message": diagnostic.message });
    if let Some((place, label)) = &diagnostic.place {
        put_place(&mut object, place);
        let (line, column) = place.source.line_column(place.span.end);
        object["end_line"] = json!(line);
        object["end_column"] = json!(column);
        if !label.is_empty() {
            object["label"] = json!(label);
        }
    }
    if let Some(help) = &diagnostic.help {
        object["help"] = json!(help);
    }
    if !diagnostic.through.is_empty() {
        let places = diagnostic.through.iter().map(|place| {
            let mut object = json!({});
            put_place(&mut object, place);
            object
        });
        object["through"] = places.collect();
    }
    object
}

fn put_place(object: &mut Value, place: &Place) {
    let (line, column) = place.source.line_column(place.span.start);
    object["file"] = json!(place.source.path.display().to_string());
    object["line"] = json!(line);
    object["column"] = json!(column);
}

#[cfg(test)]
mod tests {
    use super::{render, to_json};
    use crate::document::sample::{rendered, source};
    use crate::document::{Diagnostic, Diagnostics, Place, Source, Span};
    use serde_json::json;
    use std::sync::Arc;

    fn nested() -> Diagnostic {
        let outer = source("(nodes: {\n\"solve\": (graph: \"lib/take.ron\")})");
        let inner = Arc::new(Source::new("show/lib/take.ron", "(nodes: {\"a\": (kind: \"x\")})"));
        let mistake = Diagnostic::at("unknown-kind", &inner, Span { start: 21, end: 24 }, "there is no node kind `x`");
        let place = |start| Place { source: Arc::clone(&outer), span: Span { start, end: start + 4 } };
        Diagnostic {
            through: vec![place(0), place(27)],
            ..mistake.label("here").help("`grimace nodes` lists all kinds")
        }
    }

    #[test]
    fn nested_mistakes_show_the_chain_of_files() {
        let expected = "\
unknown-kind

  × there is no node kind `x`
  ├─▶ nested at show/graph.ron:2:18
  ╰─▶ nested at show/graph.ron:1:1
   ╭─[show/lib/take.ron:1:22]
 1 │ (nodes: {\"a\": (kind: \"x\")})
   ·                      ─┬─
   ·                       ╰── here
   ╰────
  help: `grimace nodes` lists all kinds

bad-override

  × `--set x`: there is no `=`

2 mistakes in show/lib/take.ron";
        assert_eq!(rendered(vec![nested(), Diagnostic::new("bad-override", "`--set x`: there is no `=`")]), expected);
    }

    #[test]
    fn json_holds_the_same_facts() {
        let place = |line, column| json!({"file": "show/graph.ron", "line": line, "column": column});
        let expected = json!([{
            "code": "unknown-kind", "message": "there is no node kind `x`", "label": "here",
            "help": "`grimace nodes` lists all kinds", "file": "show/lib/take.ron",
            "line": 1, "column": 22, "end_line": 1, "end_column": 25, "through": [place(1, 1), place(2, 18)],
        }, {"code": "x", "message": "y"}]);
        assert_eq!(to_json(&Diagnostics(vec![nested(), Diagnostic::new("x", "y")])), expected);
    }

    #[test]
    fn long_lines_are_cut_and_terminals_are_safe() {
        let text = format!("{}\u{1b}[31mé\t\u{9b}{}\r\nnext", "é".repeat(5000), "x".repeat(5000));
        let at = 10_000;
        let mistake = Diagnostic::at("c", &source(&text), Span { start: at, end: text.len() }, "a\u{1b}[0m b");
        let shown = rendered(vec![mistake]);
        assert!(shown.contains("show/graph.ron:1:5001]") && shown.contains("é?[31mé"), "{shown}");
        assert!(
            shown.lines().all(|line| line.chars().count() < 300) && !shown.contains(['\u{1b}', '\u{9b}']),
            "{shown}"
        );
        let coloured = render(&Diagnostics(vec![nested()]), true, 80);
        assert!(coloured.contains("\u{1b}["));
    }

    #[test]
    fn the_count_names_the_files() {
        let of = |names: &[&str]| {
            let mistakes = names.iter().map(|name| {
                let source = Arc::new(Source::new(name, "x"));
                Diagnostic::at("c", &source, Span { start: 0, end: 1 }, "m")
            });
            super::summary(&mistakes.collect::<Vec<_>>())
        };
        assert_eq!(of(&["a"]), "1 mistake in a");
        assert_eq!(of(&["a", "b", "a"]), "3 mistakes in a and b");
        assert_eq!(of(&["a", "b", "c", "d", "e", "f"]), "6 mistakes in a, b, c, d and 2 more files");
        assert_eq!(super::summary(&[Diagnostic::new("c", "m")]), "1 mistake");
    }

    #[test]
    fn lines_break_at_blanks_only() {
        assert_eq!(super::report::wrapped("one two /a/long-path/x.ron three", 8), "one two\n/a/long-path/x.ron\nthree");
        assert_eq!(super::report::wrapped("a\nbb c", 4), "a\nbb c");
    }
}
