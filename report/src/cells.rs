//! What was cooked and why, how long it took, and which files were written.

use crate::Told;
use crate::errors::{TakeError, best};
use crate::html::{Section, seconds, table};
use graph_core::cook::Engine;
use plot::escaped;
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

/// Cells of a node that are told one by one.
const LISTED: usize = 200;

/// The few numbers on top of the page.
pub(crate) fn tiles(engine: &Engine, told: &Told, errors: &[TakeError]) -> Vec<(String, String)> {
    let summary = &told.summary;
    let tile = |what: &str, much: String| (what.to_owned(), much);
    let mut tiles = vec![
        tile("nodes", engine.plan().nodes.len().to_string()),
        tile("computed now", summary.cooked.to_string()),
        tile("up to date", summary.cached.to_string()),
        tile("failed", (summary.failed + summary.skipped).to_string()),
        tile("this cook", seconds(summary.seconds)),
    ];
    let best = best(errors);
    if !best.is_empty() {
        let mean_mm = best.iter().map(|error| error.mean_mm).sum::<f64>() / best.len() as f64;
        tiles.push(tile("takes measured", best.len().to_string()));
        tiles.push(tile("mean marker error", format!("{mean_mm:.2} mm")));
    }
    tiles
}

/// A row a node, and a row a cell for what was computed.
pub(crate) fn section(engine: &Engine) -> Section {
    let cells = engine.cells();
    let mut rows = Vec::new();
    for (at, node) in engine.plan().nodes.iter().enumerate() {
        let own: Vec<_> = cells.iter().filter(|cell| cell.node == at).collect();
        let cooked = own.iter().filter(|cell| cell.cooked.as_ref().is_some_and(|(now, _)| *now)).count();
        let failed = own.iter().filter(|cell| cell.failed.is_some()).count();
        let fate = match (failed, cooked, own.len()) {
            (0, 0, _) => "up to date".to_owned(),
            (0, cooked, all) if cooked == all => "computed".to_owned(),
            (0, cooked, all) => format!("{cooked} of {all} computed"),
            (failed, _, all) => format!("{failed} of {all} failed or skipped"),
        };
        let spent: f64 = own.iter().map(|cell| cell.seconds).sum();
        let why = own.iter().filter_map(|cell| cell.cooked.as_ref()).max_by_key(|(now, _)| *now);
        let why = why.map_or_else(
            || "found in the store".to_owned(),
            |(now, why)| if *now { why.clone() } else { format!("last: {why}") },
        );
        let name =
            vec![escaped(&node.path), escaped(&node.kind), fate, escaped(&why), own.len().to_string(), seconds(spent)];
        rows.push((format!("node-{at}"), name));
    }
    let names = ["node", "kind", "this cook", "why", "cells", "time"];
    let mut body =
        table("Every node; the time is what its cells took when they were last computed, added up", &names, 4, &rows);
    let mut slow: Vec<_> = cells.iter().filter(|cell| cell.seconds > 0.0).collect();
    slow.sort_by(|a, b| b.seconds.total_cmp(&a.seconds).then(a.name.cmp(b.name)));
    let longest = slow.first().map_or(1.0, |cell| cell.seconds);
    let row = |cell: &&&graph_core::cook::CellLook<'_>| {
        let share = (cell.seconds / longest * 100.0).max(0.5);
        let bar = format!(
            "<svg width=\"160\" height=\"12\" role=\"img\" aria-label=\"{share:.0} per cent of the longest\">\
             <rect width=\"{:.1}\" height=\"12\" rx=\"2\" fill=\"var(--cooked)\"/></svg>",
            share * 1.6
        );
        (String::new(), vec![escaped(cell.name), escaped(cell.kind), bar, seconds(cell.seconds)])
    };
    let rows: Vec<_> = slow.iter().take(20).map(|cell| row(&cell)).collect();
    body += "<h3>Where the time went</h3>\n";
    body += &table("The twenty cells that took longest", &["cell", "kind", "share", "time"], 3, &rows);
    Section { id: "cells", title: "What was cooked, and why", body }
}

/// Links to the files that the graph writes.
pub(crate) fn files(engine: &Engine, folder: &Path) -> Option<Section> {
    let cells = engine.cells();
    let written: Vec<_> =
        cells.iter().filter_map(|cell| Some((cell.name, cell.writes?))).filter(|(_, path)| path.is_file()).collect();
    if written.is_empty() {
        return None;
    }
    let mut body = String::from("<ul>\n");
    for (name, path) in written.iter().take(LISTED) {
        let link = relative(path, folder);
        let shown = path.file_name().unwrap_or_default().to_string_lossy();
        let _ = writeln!(
            body,
            "<li><a href=\"{}\">{}</a> <span class=\"quiet\">{}</span></li>",
            escaped(&encoded(&link)),
            escaped(&shown),
            escaped(name)
        );
    }
    body += "</ul>\n";
    if written.len() > LISTED {
        let _ = writeln!(body, "<p class=\"quiet\">… and {} more</p>", written.len() - LISTED);
    }
    Some(Section { id: "files", title: "Written files", body })
}

/// The way from `folder` to `path`; the whole path where there is none.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let (Ok(path), Ok(folder)) = (path.canonicalize(), folder.canonicalize()) else { return path.to_owned() };
    let (own, theirs): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (path.components().collect(), folder.components().collect());
    let shared = own.iter().zip(&theirs).take_while(|(a, b)| a == b).count();
    let up = theirs[shared..].iter().map(|_| Component::ParentDir);
    up.chain(own[shared..].iter().copied()).collect()
}

/// A path as links write it.
fn encoded(path: &Path) -> String {
    let text = path.to_string_lossy().replace('\\', "/");
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/._-~@".contains(&byte);
    text.bytes().fold(String::new(), |mut out, byte| {
        if plain(byte) {
            out.push(byte as char);
        } else {
            let _ = write!(out, "%{byte:02X}");
        }
        out
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_written_as_browsers_read_them() {
        assert_eq!(encoded(Path::new("../out/take 1#ü.csv")), "../out/take%201%23%C3%BC.csv");
    }
}
