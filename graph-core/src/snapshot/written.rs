//! The text of snapshots: one column or one cell a line, so that a difference between two snapshots reads well in a code review.

use super::golden::{HeldOutput, Hits};
use super::reduce::{Column, ReducedTable};
use super::trace::Trace;
use std::collections::BTreeMap;
use std::fmt::Write;
use wire::Tolerance;

pub(super) fn settings(set: &[String], second_cook: &Hits) -> String {
    let set: Vec<String> = set.iter().map(|text| quoted(text)).collect();
    format!(
        "// How the graph was cooked for this snapshot, and what a second cook then did. Written by `grimace snapshot accept`.\n\
         (\n    set: [{}],\n    second_cook: (cooked: {}, cached: {}),\n)\n",
        set.join(", "),
        second_cook.cooked,
        second_cook.cached
    )
}

pub(super) fn trace(trace: &Trace) -> String {
    let mut out = String::from(
        "// What each cell before the held outputs was made of and gave, by short digests: so that the first that differs can be named.\n{\n",
    );
    for (name, cell) in &trace.0 {
        let map = |map: &BTreeMap<String, String>| {
            let each: Vec<_> =
                map.iter().map(|(label, digest)| format!("{}: {}", quoted(label), quoted(digest))).collect();
            format!("{{{}}}", each.join(", "))
        };
        let (name, kind) = (quoted(name), quoted(&cell.kind));
        let _ = writeln!(
            out,
            "    {name}: (kind: {kind}, gave: {},\n        made_of: {}),",
            map(&cell.gave),
            map(&cell.made_of)
        );
    }
    out + "}\n"
}

/// An output, with the tolerances that its type has in a comment, so that who wants others sees what they are called.
pub(super) fn output(output: &HeldOutput, own: Option<&BTreeMap<String, (Tolerance, &'static str)>>) -> String {
    let mut out = format!(
        "(\n    output: {},\n    kind: {},\n    version: {},\n",
        quoted(&output.output),
        quoted(&output.kind),
        output.version
    );
    if let Some(own) = own.filter(|own| !own.is_empty()) {
        let told = own.iter().map(|(table, (tolerance, unit))| {
            let unit = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
            format!("{}: {}{unit}", quoted(table), held(tolerance.absolute, tolerance.relative))
        });
        let _ = writeln!(out, "    // Set by hand what should not be {}.", told.collect::<Vec<_>>().join(", "));
    }
    let tolerances = output.tolerances.iter();
    let tolerances: Vec<_> = tolerances
        .map(|(table, tolerance)| format!("{}: {}", quoted(table), held(tolerance.absolute, tolerance.relative)))
        .collect();
    let _ = writeln!(out, "    tolerances: {{{}}},\n    items: {{", tolerances.join(", "));
    for (item, value) in &output.items {
        let _ = writeln!(out, "        {}: (", quoted(item));
        let _ = writeln!(
            out,
            "            digest: {},\n            summary: {},",
            quoted(&value.digest),
            quoted(&value.summary)
        );
        if !value.tables.is_empty() {
            out.push_str("            tables: {\n");
            for (name, table) in &value.tables {
                write_table(&mut out, name, table);
            }
            out.push_str("            },\n");
        }
        out.push_str("        ),\n");
    }
    out + "    },\n)\n"
}

fn held(absolute: f64, relative: f64) -> String {
    format!("(absolute: {absolute}, relative: {relative})")
}

fn write_table(out: &mut String, name: &str, table: &ReducedTable) {
    let all = &table.all;
    let rows: Vec<String> = table.held.iter().map(|row| quoted(row)).collect();
    let _ = writeln!(
        out,
        "                {}: (\n                    unit: {}, rows: {}, width: {},\n                    \
         all: (missing: {}, low: {}, high: {}, mean: {}),\n                    held: [{}],\n                    columns: {{",
        quoted(name),
        quoted(&table.unit),
        quoted(&table.rows),
        table.width,
        all.missing,
        number(all.low),
        number(all.high),
        number(all.mean),
        rows.join(", "),
    );
    for (name, Column { missing, low, high, mean, step, at }) in &table.columns {
        let at: Vec<String> = at.iter().map(|value| number(*value)).collect();
        let _ = writeln!(
            out,
            "                        {}: (missing: {missing}, low: {}, high: {}, mean: {}, step: {}, at: [{}]),",
            quoted(name),
            number(*low),
            number(*high),
            number(*mean),
            number(*step),
            at.join(", ")
        );
    }
    out.push_str("                    },\n                ),\n");
}

/// A number as RON reads it back.
fn number(value: f64) -> String {
    if value.is_nan() {
        "NaN".to_owned()
    } else if value.is_infinite() {
        if value > 0.0 { "inf" } else { "-inf" }.to_owned()
    } else if value != 0.0 && !(1e-5..1e12).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.escape_default().to_string().replace("\\'", "'"))
}
