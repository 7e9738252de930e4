//! Rasters of colours side by side, as SVG: reduced pictures, an old one beside a new one.

use crate::escaped;
use crate::lines::Ink;
use std::fmt::Write;

/// Width and height of a cell of a raster.
const CELL_PX: usize = 10;

/// A raster of colours.
#[derive(Debug, Clone)]
pub struct Raster {
    /// What stands above it.
    pub name: String,
    /// Rows of colours, red, green and blue from 0 to 255.
    pub rows: Vec<Vec<[f64; 3]>>,
}

/// Rasters beside each other.
pub fn draw_rasters(title: &str, rasters: &[Raster], ink: &Ink) -> String {
    let width_of = |raster: &Raster| raster.rows.first().map_or(0, Vec::len) * CELL_PX + 20;
    let width = rasters.iter().map(width_of).sum::<usize>() + 20;
    let height = rasters.iter().map(|raster| raster.rows.len() * CELL_PX).max().unwrap_or(0) + 80;
    let mut svg = ink.open(title, width as f64, height as f64);
    let mut left = 20;
    for raster in rasters {
        let _ = writeln!(svg, "<text x=\"{left}\" y=\"52\" fill=\"{}\">{}</text>", ink.text, escaped(&raster.name));
        for (y, row) in raster.rows.iter().enumerate() {
            for (x, colour) in row.iter().enumerate() {
                let [r, g, b] = colour.map(|level| level.round().clamp(0.0, 255.0) as u8);
                let (x, y) = (left + x * CELL_PX, 60 + y * CELL_PX);
                let _ = write!(
                    svg,
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{CELL_PX}\" height=\"{CELL_PX}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>"
                );
            }
            svg.push('\n');
        }
        left += width_of(raster);
    }
    svg + "</svg>\n"
}
