//! `grimace plan`: what a cook would compute, and why, without computing anything.

use crate::arguments::Plan;
use crate::exit::{Exit, Trouble};
use crate::graph::Asked;
use crate::tell::JsonLines;
use crate::words::one_line;
use crate::{cooking, output};
use graph_core::cook::{Event, Summary};
use std::fmt::Write;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

/// What becomes of one cell.
struct Row {
    fate: &'static str,
    node: String,
    kind: String,
    because: String,
}

/// Prints what a cook would do, a line a cell.
pub fn plan(arguments: &Plan) -> Result<Exit, Trouble> {
    let asked = Asked::read(&arguments.graph)?;
    let options = cooking::options(&arguments.cook, true);
    let work = cooking::find(&asked, &arguments.store, &options, arguments.json)?;
    let cancel = Arc::new(AtomicBool::new(false));
    let cook = |tell: &(dyn Fn(Event) + Sync)| cooking::run((&asked, work), &arguments.store, &options, &cancel, tell);
    if arguments.json {
        let lines = JsonLines::new(&cancel);
        let summary = cook(&|event| lines.tell(&event));
        lines.finish()?;
        return Ok(cooking::exit(&summary?));
    }
    let rows = Mutex::new(Vec::new());
    let notices = Mutex::new(Vec::new());
    let summary = cook(&|event| match row(event) {
        Told::Row(row) => lock(&rows).push(row),
        Told::Notice(notice) => lock(&notices).push(notice),
        Told::Nothing => {}
    })?;
    lock(&notices).iter().for_each(|notice| output::say(notice));
    output::print(&table(&lock(&rows), &summary))?;
    Ok(cooking::exit(&summary))
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

enum Told {
    Row(Row),
    Notice(String),
    Nothing,
}

fn row(event: Event) -> Told {
    Told::Row(match event {
        Event::WouldCook { node, kind, because, sure } => {
            Row { fate: if sure { "cook" } else { "may cook" }, node, kind, because }
        }
        Event::Cached { node, kind, .. } => Row { fate: "cached", node, kind, because: String::new() },
        Event::Failed { node, kind, error, .. } => Row { fate: "fails", node, kind, because: error },
        Event::Skipped { node, because } => {
            Row { fate: "skipped", node, kind: String::new(), because: format!("it needs {because}") }
        }
        Event::Notice { about, message } => return Told::Notice(format!("{about}: {message}")),
        _ => return Told::Nothing,
    })
}

fn table(rows: &[Row], summary: &Summary) -> String {
    let widest = |of: fn(&Row) -> &str, most: usize| {
        rows.iter().map(|row| console::measure_text_width(of(row))).max().unwrap_or(0).min(most)
    };
    let (nodes, kinds) = (widest(|row| &row.node, 60), widest(|row| &row.kind, 40));
    let mut out = String::new();
    for Row { fate, node, kind, because } in rows {
        let line = format!("{fate:<8}  {node:<nodes$}  {kind:<kinds$}  {}", one_line(because, usize::MAX));
        let _ = writeln!(out, "{}", line.trim_end());
    }
    let of = |fate: &str| rows.iter().filter(|row| row.fate == fate).count();
    let mut totals = vec![format!("{} to cook", of("cook"))];
    if of("may cook") > 0 {
        totals.push(format!("{} more where results change", of("may cook")));
    }
    totals.push(format!("{} cached", summary.cached));
    if summary.failed > 0 {
        totals.push(format!("{} would fail", summary.failed));
    }
    if summary.skipped > 0 {
        totals.push(format!("{} would be skipped", summary.skipped));
    }
    let _ = writeln!(out, "{}", totals.join(", "));
    out
}

#[cfg(test)]
mod tests {
    use super::{Row, table};
    use graph_core::cook::Summary;

    #[test]
    fn columns_line_up() {
        let row = |fate, node: &str, kind: &str, because: &str| Row {
            fate,
            node: node.to_owned(),
            kind: kind.to_owned(),
            because: because.to_owned(),
        };
        let rows = [
            row("cook", "rig", "load_rig", "its file changed (a.glb)"),
            row("may cook", "solve@smile", "solve_regions", "rig may give another result"),
            row("cached", "takes@smile", "load_markers", ""),
        ];
        let summary = Summary { cooked: 2, cached: 1, ..Summary::default() };
        let expected = "\
cook      rig          load_rig       its file changed (a.glb)
may cook  solve@smile  solve_regions  rig may give another result
cached    takes@smile  load_markers
1 to cook, 1 more where results change, 1 cached
";
        assert_eq!(table(&rows, &summary), expected);
    }
}
