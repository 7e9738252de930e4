//! Tables of landmarks in pictures: a picture a row, columns `x_0, y_0, x_1 …` in pixels.
//!
//! Where a tracker has a column `success`, the landmarks of rows with 0 in it are missing, whatever numbers stand there.

use super::Inspection;
use crate::csv::{CsvError, Row, Table};
use std::collections::BTreeMap;

/// Columns of x and y of each landmark.
fn columns(table: &Table<'_>) -> Vec<(usize, usize)> {
    let by_name: BTreeMap<&str, usize> =
        table.names.cells.iter().enumerate().map(|(index, cell)| (cell.text.as_ref(), index)).collect();
    let column = |axis: &str, index: usize| by_name.get(format!("{axis}_{index}").as_str()).copied();
    (0..by_name.len()).map_while(|index| Some((column("x", index)?, column("y", index)?))).collect()
}

pub(super) fn detect(table: &Table<'_>) -> bool {
    !columns(table).is_empty()
}

pub(super) fn facts(table: &Table<'_>) -> Result<Inspection, CsvError> {
    let columns = columns(table);
    let mut points = Vec::with_capacity(columns.len() * table.rows.len());
    let success = table.names.cells.iter().position(|cell| cell.text == "success");
    let mut missing = 0;
    for row in &table.rows {
        if let Some(success) = success
            && table.number(row, success)? == 0.0
        {
            missing += columns.len();
            continue;
        }
        for (x, y) in &columns {
            let empty = |row: &Row<'_>, column: usize| row.cells[column].text.is_empty();
            if empty(row, *x) && empty(row, *y) {
                missing += 1;
            } else {
                points.push([f64::from(table.number(row, *x)?), f64::from(table.number(row, *y)?)]);
            }
        }
    }
    let mut facts = Inspection::new("landmarks", "CSV, landmarks").range(points.into_iter());
    facts.frames = Some(table.rows.len());
    facts.rate_hz = table.rate_hz()?;
    facts.names = (0..columns.len()).map(|index| index.to_string()).collect();
    facts.missing = Some(missing);
    facts.unit = Some("px".to_owned());
    Ok(facts)
}
