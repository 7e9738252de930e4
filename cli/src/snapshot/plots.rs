//! What was, drawn beside what is: lines for numbers over rows, rasters for pictures.

use crate::exit::Trouble;
use graph_core::snapshot::{Difference, Reduced, ReducedTable};
use plot::{Ink, Line, Plot, Raster, draw_rasters};
use std::fs;
use std::path::{Path, PathBuf};

/// Columns that are drawn of one value, the worst.
const DRAWN: usize = 4;
/// The table to which pictures are reduced.
const PICTURE: &str = "raster";

/// Draws the worst columns of a value into a file in `folder`; none where there is nothing to be drawn.
pub fn draw(
    (output, item): (&str, &str),
    (was, now): (&Reduced, &Reduced),
    differences: &[Difference],
    folder: &Path,
) -> Result<Option<PathBuf>, Trouble> {
    let title = if item.is_empty() { output.to_owned() } else { format!("{output}@{item}") };
    let Some(worst) = differences.iter().find(|one| !one.column.is_empty()) else { return Ok(None) };
    let (Some(was), Some(now)) = (was.tables.get(&worst.table), now.tables.get(&worst.table)) else { return Ok(None) };
    let svg = if worst.table == PICTURE {
        pictures(&title, was, now)
    } else {
        let mut columns: Vec<&str> = Vec::new();
        for one in differences.iter().filter(|one| one.table == worst.table && !one.column.is_empty()) {
            if columns.len() < DRAWN && !columns.contains(&one.column.as_str()) {
                columns.push(&one.column);
            }
        }
        lines(&title, (was, now), &columns, &worst.table)
    };
    let path = folder.join(format!("{}.svg", title.replace('/', ".")));
    let failed = |problem| Trouble::File { path: path.clone(), problem };
    fs::create_dir_all(folder).map_err(failed)?;
    fs::write(&path, svg).map_err(failed)?;
    Ok(Some(path))
}

fn lines(title: &str, (was, now): (&ReducedTable, &ReducedTable), columns: &[&str], table: &str) -> String {
    // Rows that are counted stand at their numbers, others in their order.
    let place =
        |row: &String, at: usize| row.rsplit(' ').next().and_then(|word| word.parse().ok()).unwrap_or(at as f64);
    let line = |table: &ReducedTable, column: &str, told: &str, dots: bool| {
        let held = table.columns.get(column)?;
        let points =
            table.held.iter().zip(&held.at).enumerate().map(|(at, (row, value))| (place(row, at), *value)).collect();
        Some(Line { name: format!("{column}, {told}"), points, dots })
    };
    let each =
        columns.iter().flat_map(|column| [line(was, column, "accepted", false), line(now, column, "found", true)]);
    let unit = if was.unit.is_empty() { String::new() } else { format!(" ({})", was.unit) };
    let x_label = was.held.first().and_then(|row| row.split(' ').next()).unwrap_or_default().to_owned();
    let (width_px, height_px) = (960.0, 480.0);
    let plot = Plot {
        title: title.to_owned(),
        x_label,
        y_label: format!("{table}{unit}"),
        from_zero: false,
        width_px,
        height_px,
        lines: each.flatten().collect(),
    };
    plot::draw(&plot, &Ink::PAPER)
}

fn pictures(title: &str, was: &ReducedTable, now: &ReducedTable) -> String {
    let level = |table: &ReducedTable, row: usize, column: usize, colour: &str| {
        table.columns.get(&format!("{column} {colour}")).and_then(|column| column.at.get(row)).copied().unwrap_or(0.0)
    };
    let colours = ["red", "green", "blue"];
    let raster = |name: &str, of: &dyn Fn(usize, usize, &str) -> f64| {
        let row = |row: usize| (0..was.width / 3).map(|column| colours.map(|colour| of(row, column, colour))).collect();
        Raster { name: name.to_owned(), rows: (0..was.held.len()).map(row).collect() }
    };
    let rasters = [
        raster("accepted", &|row, column, colour| level(was, row, column, colour)),
        raster("found", &|row, column, colour| level(now, row, column, colour)),
        raster("difference, ten times", &|row, column, colour| {
            10.0 * (level(was, row, column, colour) - level(now, row, column, colour)).abs()
        }),
    ];
    draw_rasters(title, &rasters, &Ink::PAPER)
}
