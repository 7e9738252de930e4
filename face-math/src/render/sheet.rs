//! Contact sheets: pictures in a grid, each with a caption below.

use super::font::{GLYPH_HEIGHT_PX, GLYPH_WIDTH_PX, draw_text};
use crate::data::Image;

/// Pictures to be laid out in a grid, row after row.
#[derive(Debug, Clone)]
pub struct Sheet {
    columns: usize,
    cells: Vec<(String, Image)>,
    background: [u8; 3],
    ink: [u8; 3],
}

impl Sheet {
    /// An empty sheet of so many columns (at least one).
    pub fn new(columns: usize) -> Self {
        Self { columns: columns.max(1), cells: Vec::new(), background: [22, 23, 26], ink: [220, 222, 226] }
    }

    /// Adds a picture with its caption.
    pub fn add(&mut self, caption: impl Into<String>, image: Image) {
        self.cells.push((caption.into(), image));
    }

    /// Draws the sheet: cells are as large as the largest picture, smaller ones stand at their top left.
    pub fn compose(&self) -> Image {
        let gap = 4;
        let cell_width = self.cells.iter().map(|(_, image)| image.width_px()).max().unwrap_or(0);
        let cell_height = self.cells.iter().map(|(_, image)| image.height_px()).max().unwrap_or(0);
        let scale = if cell_width >= 400 { 2 } else { 1 };
        let caption_height = GLYPH_HEIGHT_PX * scale + 2;
        let columns = self.columns.min(self.cells.len().max(1));
        let rows = self.cells.len().div_ceil(columns);
        let (step_x, step_y) = (cell_width + gap, cell_height + caption_height + gap);
        let mut sheet = Image::filled(columns * step_x + gap, rows * step_y + gap, self.background);
        let width = sheet.width_px();
        for (index, (caption, image)) in self.cells.iter().enumerate() {
            let (left, top) = (gap + index % columns * step_x, gap + index / columns * step_y);
            for (y, row) in image.pixels().chunks_exact((image.width_px() * 3).max(1)).enumerate() {
                let start = ((top + y) * width + left) * 3;
                sheet.pixels_mut()[start..start + row.len()].copy_from_slice(row);
            }
            let letters = (cell_width / (GLYPH_WIDTH_PX * scale)).max(1);
            let text: String = caption.chars().take(letters).collect();
            draw_text(&mut sheet, left, top + cell_height + 3, scale, self.ink, &text);
        }
        sheet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_hold_their_pictures_in_rows() {
        let mut sheet = Sheet::new(2);
        for i in 0..3u8 {
            sheet.add(format!("picture {i}"), Image::filled(40, 30, [200 + i, 0, 0]));
        }
        let image = sheet.compose();
        assert_eq!((image.width_px(), image.height_px()), (92, 96));
        let at = |x: usize, y: usize| image.pixels()[(y * image.width_px() + x) * 3];
        assert_eq!((at(5, 5), at(50, 5), at(5, 60)), (200, 201, 202));
        assert_eq!(Sheet::new(3).compose().height_px(), 4);
    }
}
